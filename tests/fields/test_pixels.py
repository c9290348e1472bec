"""Images from coefficients by small programs: the full sum at every pixel, whatever nodes, pairs, shape and blocks."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from newtonjax.fields import pixels, sums, synthesize
from newtonjax.numerics.chebyshev import basis
from newtonjax.verbs.normal import from_coefficients


def fields(count: int, pairs: int = 1, turns: float = 20.0) -> np.ndarray:
    """Coefficients that fall by e a degree, phases of so many turns behind a plate of 30000."""
    rng = np.random.default_rng(count)
    size = np.exp(-np.add.outer(np.arange(count), np.arange(count)))
    table = rng.normal(size=(1 + 2 * pairs, count, count)) * size
    table[1 + pairs :] *= turns
    table[1 + pairs :, 0, 0] += 30_000
    return table


def full_sum(table: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    y, x = (basis(n, table.shape[-1]) for n in shape)
    whole = np.round(table[1 + (len(table) - 1) // 2 :, :1, :1])
    smooth, *others = (y.T @ field @ x for field in [*table[: 1 + len(whole)], *(table[1 + len(whole) :])])
    phases = [phase - turns for phase, turns in zip(others[len(whole) :], whole.ravel(), strict=True)]
    return smooth + sum(a * np.cos(2 * np.pi * p) for a, p in zip(others, phases, strict=False))


@pytest.mark.parametrize("count", [3, 6, 12])
@pytest.mark.parametrize("pairs", [0, 1, 3])
def test_an_image_is_the_full_sum(count, pairs):
    table, shape = fields(count, pairs), (33, 250)  # strips that reach beyond the image
    exact = full_sum(table, shape)
    # Behind 30000 turns a phase is rounded by 4e-12 turns. Strips leave a thousandth of the last coefficients.
    allowed = 1e-9 if count > 9 else 2e-10
    np.testing.assert_allclose(pixels.image(table, shape), exact, atol=allowed)
    single = pixels.image(table, shape, "float32")
    assert single.dtype == jnp.float32
    np.testing.assert_allclose(single, exact, atol=2e-5 * float(np.abs(exact).max()))


@pytest.mark.parametrize("result", ["float64", "float32"])
def test_an_image_in_blocks_is_that_in_one_call(monkeypatch, result):
    table, shape = fields(5), (70, 48)
    whole = np.asarray(pixels.image(table, shape))
    monkeypatch.setattr(pixels, "_WHOLE", 1000)
    monkeypatch.setattr(pixels, "_BLOCK", 48 * 16)  # the last block overlaps the one before
    made = pixels.image(table, shape, "float64", result)
    assert isinstance(made, jax.Array)
    assert made.dtype == result
    np.testing.assert_allclose(made, whole, atol=1e-13 if result == "float64" else 1e-6)


def test_nodes_of_one_class_share_a_program():
    shape = (21, 34)
    pixels.image(fields(6), shape)
    before = pixels._of_one_pair._cache_size()
    for count in (7, 8, 9):
        pixels.image(fields(count), shape)
    assert pixels._of_one_pair._cache_size() == before


@pytest.mark.parametrize("shape", [(1, 1), (5, 300), (300, 17)])
def test_sums_over_blocks_are_those_of_the_jacobian(monkeypatch, shape):
    monkeypatch.setattr(sums, "_ROWS", 64)
    table = jnp.asarray(fields(5))
    rng = np.random.default_rng(0)
    weights, data = rng.uniform(0.5, 2.0, shape), rng.normal(size=shape)
    moves = jnp.asarray(rng.normal(size=(3, *table.shape)) * np.asarray(fields(5) != 0))
    slopes = np.stack([np.asarray(jax.jvp(lambda c: synthesize(c, shape), (table,), (m,))[1]).ravel() for m in moves])
    left = np.asarray(synthesize(table, shape)) - data
    solved = from_coefficients(
        lambda p: table + jnp.einsum("p,pfkl->fkl", p, moves), jnp.zeros(3), shape, data, weights
    )
    dense = (slopes * weights.ravel()) @ slopes.T
    np.testing.assert_allclose(solved.matrix, dense, rtol=1e-9, atol=1e-9 * dense.max())
    gradient = slopes @ (weights * left).ravel()
    np.testing.assert_allclose(solved.gradient, gradient, rtol=1e-8, atol=1e-8 * np.abs(gradient).max())
    pulled = sums.slope_sums(table, jnp.asarray(weights * left))
    np.testing.assert_allclose(jnp.einsum("fkl,pfkl->p", pulled, moves), gradient, rtol=1e-8, atol=1e-8)
