"""Zernike terms: Noll's order, orthonormal on the disc, slopes that are their derivatives; the nodes of the disc."""

import numpy as np
import pytest

from fitting.irregularity.projection import nodes
from fitting.irregularity.zernike import TERMS, at_points, noll, on_grid, slopes, terms_at

# Noll (1976), table I: (n, m) of terms 1 to 15, cosines with m > 0.
TABLE = [(0, 0), (1, 1), (1, -1), (2, 0), (2, -2), (2, 2), (3, -1), (3, 1), (3, -3), (3, 3), (4, 0), (4, 2), (4, -2)]


def quadrature() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points and weights of means over the unit disc, exact for products of two terms."""
    squares, weights = np.polynomial.legendre.leggauss(12)
    angles = 2 * np.pi * np.arange(32) / 32
    r = np.sqrt((squares + 1) / 2)
    u, v = np.outer(r, np.cos(angles)).ravel(), np.outer(r, np.sin(angles)).ravel()
    return u, v, np.repeat(weights / 2, 32) / 32


def test_terms_stand_in_the_order_of_noll():
    assert [noll(term) for term in range(1, 14)] == TABLE


def test_terms_are_orthonormal_on_the_disc():
    u, v, weights = quadrature()
    values = terms_at(u, v)
    assert np.abs(values.T @ (weights[:, None] * values) - np.eye(TERMS)).max() < 1e-12


@pytest.mark.parametrize(
    ("term", "formula"),
    [
        (4, lambda u, v: np.sqrt(3) * (2 * (u**2 + v**2) - 1)),
        (5, lambda u, v: np.sqrt(6) * 2 * u * v),
        (6, lambda u, v: np.sqrt(6) * (u**2 - v**2)),
        (8, lambda u, v: np.sqrt(8) * (3 * (u**2 + v**2) - 2) * u),
        (11, lambda u, v: np.sqrt(5) * (6 * (u**2 + v**2) ** 2 - 6 * (u**2 + v**2) + 1)),
    ],
)
def test_low_terms_are_those_of_the_textbook(term, formula):
    u, v, _ = quadrature()
    np.testing.assert_allclose(terms_at(u, v)[:, term - 1], formula(u, v), atol=1e-13)


def test_slopes_are_the_derivatives_of_the_terms():
    u, v, _ = quadrature()
    step = 1e-5
    along, down = (at_points(part, u, v) for part in slopes())
    # Central differences err by step² times the third derivative, 1e3 for order 7, and by rounding over the step.
    np.testing.assert_allclose(along, (terms_at(u + step, v) - terms_at(u - step, v)) / (2 * step), atol=1e-6)
    np.testing.assert_allclose(down, (terms_at(u, v + step) - terms_at(u, v - step)) / (2 * step), atol=1e-6)


def test_a_grid_holds_what_points_hold():
    rng = np.random.default_rng(0)
    form, u, v = rng.normal(size=36), np.linspace(-1, 1, 7), np.linspace(-0.9, 1, 5)
    across, down = (x.ravel() for x in np.meshgrid(u, v))
    np.testing.assert_allclose(on_grid(form, u, v).ravel(), terms_at(across, down) @ form, atol=1e-11)


def test_nodes_give_back_a_polynomial_of_the_disc():
    from fitting.irregularity.moments import DEGREE, products_at

    u, v, inverse = nodes()
    coefficients = np.random.default_rng(1).normal(size=inverse.shape[0])
    x, y, _ = quadrature()
    field = products_at(u, v, DEGREE) @ coefficients
    again = products_at(x, y, DEGREE) @ (inverse @ field)
    np.testing.assert_allclose(again, products_at(x, y, DEGREE) @ coefficients, atol=1e-8)
