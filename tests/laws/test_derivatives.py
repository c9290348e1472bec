"""Derivatives through the nodes: every mode and order agrees with the dense Jacobian and with differences."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY

import newtonjax as nj
from newtonjax.fields import synthesize
from newtonjax.fields.fringes import split
from newtonjax.numerics import cos_turns
from newtonjax.numerics.chebyshev import expand

CAMERA = nj.Camera((37, 52), 60e-6)
POINT = np.array([2.0, 0.3, 1.0, 1e-3])
NODES = nj.Chebyshev(9)


def bench(theta):
    return nj.newton_rings(
        theta[0], 500e-9 * theta[2], 1e-6 * theta[1], screen=theta[3], beams=None, view="transmitted"
    )


def three_beams(theta):
    return nj.newton_rings(
        theta[0], 500e-9 * theta[2], 1e-6 * theta[1], "reflected", screen=theta[3], beams=("R1", "R2", "R3")
    )


def image(theta, made=bench):
    return nj.render(made(theta), CAMERA, NODES)


def dense_jacobian(image, theta):
    return jax.jit(jax.jacfwd(image), compiler_options=QUICKLY)(jnp.asarray(theta))


def plain(coefficients):
    """The sum as it stands, whose derivatives JAX makes by itself."""
    background, moduli, phases = split(expand(coefficients, CAMERA.shape))
    return background + sum(size * cos_turns(turns) for size, turns in zip(moduli, phases, strict=True))


@pytest.fixture(scope="module")
def coefficients():
    rng = np.random.default_rng(0)
    decay = np.exp(-0.7 * np.add.outer(np.arange(6), np.arange(6)))
    return jnp.asarray(rng.normal(size=(5, 6, 6)) * decay)


@pytest.mark.parametrize("mode", ["value", "jacfwd", "jacrev", "hessian", "reverse over reverse", "vmap", "third"])
def test_every_derivative_is_that_of_the_plain_sum(coefficients, mode):
    weights = jnp.asarray(np.random.default_rng(1).normal(size=CAMERA.shape))
    direction = jnp.asarray(np.random.default_rng(2).normal(size=coefficients.shape))

    def along(function):
        return lambda t: jnp.sum(weights * function(coefficients + t * direction) ** 2)

    take = {
        "value": lambda f: f(coefficients),
        "jacfwd": lambda f: jax.jacfwd(lambda t: f(coefficients + t * direction))(0.1),
        "jacrev": lambda f: jax.grad(lambda c: jnp.sum(weights * f(c)))(coefficients),
        "hessian": lambda f: jax.jacfwd(jax.grad(lambda c: jnp.sum(weights * f(c))))(coefficients),
        "reverse over reverse": lambda f: jax.grad(jax.grad(along(f)))(0.05),
        "vmap": lambda f: jax.vmap(jax.grad(lambda c: jnp.sum(weights * f(c))))(jnp.stack([coefficients, direction])),
        "third": lambda f: jax.jacfwd(jax.grad(jax.jacfwd(along(f))))(0.05),
    }[mode]
    # One program each, where step by step there would be hundreds of small ones.
    ours, expected = (
        jax.jit(lambda f=f: take(f), compiler_options=QUICKLY)() for f in (lambda c: synthesize(c, CAMERA.shape), plain)
    )
    np.testing.assert_allclose(ours, expected, rtol=1e-10, atol=1e-10 * float(jnp.abs(ours).max()))


@pytest.mark.parametrize("made", [bench, three_beams], ids=["two beams", "three beams"])
def test_normal_equations_are_those_of_the_dense_jacobian(made):
    rng = np.random.default_rng(3)
    data, weights = 1.02 * np.asarray(image(POINT, made)), rng.uniform(0.5, 2.0, CAMERA.shape)
    found = nj.normal_equations(made, POINT, CAMERA, data, weights, NODES)
    jacobian = np.asarray(dense_jacobian(lambda theta: image(theta, made), POINT)).reshape(-1, len(POINT))
    left = (np.asarray(image(POINT, made)) - data).ravel()
    size = np.sqrt(np.diag(jacobian.T @ (weights.ravel()[:, None] * jacobian)))
    dense = jacobian.T @ (weights.ravel()[:, None] * jacobian)
    np.testing.assert_allclose(found.matrix / np.outer(size, size), dense / np.outer(size, size), atol=1e-11)
    np.testing.assert_allclose(found.gradient / size, jacobian.T @ (weights.ravel() * left) / size, atol=1e-11)
    assert found.misfit == pytest.approx(0.5 * np.sum(weights.ravel() * left**2), rel=1e-12)


def test_the_matrix_agrees_with_central_differences_of_traced_images():
    step = POINT * np.array([1e-6, 1e-5, 1e-6, 1e-3])  # the screen moves the image least, and rounding is the same
    slope = [
        (nj.render(bench(POINT + e), CAMERA, nj.Traced()) - nj.render(bench(POINT - e), CAMERA, nj.Traced())) / 2
        for e in np.diag(step)
    ]
    table = np.stack([np.asarray(s).ravel() for s in slope]) / step[:, None]
    found = nj.normal_equations(bench, POINT, CAMERA, method=NODES).matrix
    size = np.sqrt(np.diag(table @ table.T))
    np.testing.assert_allclose(found / np.outer(size, size), table @ table.T / np.outer(size, size), atol=2e-6)


def test_a_camera_may_be_among_the_parameters():
    def both(theta):
        return bench(jnp.array([*POINT])), nj.Camera(CAMERA.shape, 60e-6 * theta[0], (25.0 + theta[1], 18.0))

    found = nj.normal_equations(both, np.array([1.0, 0.5]), weights=lambda light: 1 / (0.01 + light))

    def of(theta):
        return nj.render(*both(theta), nj.Chebyshev())

    theta = np.array([1.0, 0.5])
    jacobian = np.asarray(dense_jacobian(of, theta)).reshape(-1, 2)
    weights = 1 / (0.01 + np.asarray(of(theta)).ravel())
    np.testing.assert_allclose(found.matrix, jacobian.T @ (weights[:, None] * jacobian), rtol=1e-9, atol=1e-9)
    assert not found.gradient.any()


def test_parameters_must_be_a_vector():
    with pytest.raises(ValueError, match="allowed: a vector"):
        nj.normal_equations(bench, np.eye(2), CAMERA)
