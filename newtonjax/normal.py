"""Normal equations of an image in any parameters, through the nodes: their cost hardly grows with their number."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax import chebyshev
from newtonjax.camera import Camera
from newtonjax.checks import require_bench, require_method, unreached
from newtonjax.methods import Chebyshev
from newtonjax.precision import require_x64, x64
from newtonjax.quantities import is_concrete
from newtonjax.scene import Scene
from newtonjax.synthesis import combine, slopes


class NormalEquations(NamedTuple):
    """Of the misfit S = Σ w (I - d)² / 2: its value, gradient Jᵀ w (I - d), and Gauss and Newton's matrix Jᵀ w J."""

    misfit: Float[Array, ""]
    gradient: Float[Array, " parameters"]
    matrix: Float[Array, "parameters parameters"]


def normal_equations(
    bench: Callable[[Float[Array, " parameters"]], Any],
    parameters: Float[Array | np.ndarray, "..."],
    camera: Camera | None = None,
    data: Float[Array | np.ndarray, "rows columns"] | None = None,
    weights: Float[Array | np.ndarray, "rows columns"] | Callable[[Array], Array] | None = None,
    method: Chebyshev | None = None,
) -> NormalEquations:
    """Misfit, gradient and Gauss-Newton matrix of an image that is differentiable in a vector of parameters.

    J is never formed. A tangent of the image is a sum of smooth fields times 1, cos 2πφ and sin 2πφ; a product of two
    of them is summed over the pixels by quadrature weights on 2 n - 1 nodes, which are a few matrix products whatever
    the number of parameters. Exact for the image of the nodes, to rounding.

    Args:
      bench: from the parameters to a `Scene`, or to (Scene, Camera) where no camera is given.
      parameters: where; in any units, all of one array.
      camera: of the image; None where `bench` gives it.
      data: the image to compare with; None for the image itself, which leaves the matrix only.
      weights: per pixel, or a function of the image that gives them, such as one over its variance; None for 1.
      method: the nodes; `Chebyshev()` unless given.

    Raises ValueError for parameters that are no vector, tables of another shape, and beams that miss a node (not within
    a transformation, where numbers are not known); RuntimeError within a transformation in float32.

    """
    require_method(method, Chebyshev)
    method = Chebyshev() if method is None else method
    if jnp.ndim(parameters) != 1:
        raise ValueError(f"parameters has shape {jnp.shape(parameters)}; allowed: a vector")
    if not is_concrete(parameters, data):
        require_x64("normal_equations")
        return _equations(bench, parameters, camera, data, weights, method)
    with x64():
        values = jnp.asarray(parameters, dtype=float)
        scene, seen_by = _pair(bench, values, camera)
        if not method.fields(scene, seen_by).arrives.all():
            raise unreached(method)
        return _equations(bench, values, camera, data, weights, method)


def _equations(bench, parameters, camera, data, weights, method) -> NormalEquations:
    def of_nodes(values):
        return method.coefficients(method.fields(*_pair(bench, values, camera)))

    shape = _pair(bench, parameters, camera)[1].shape
    for name, table in (("data", data), ("weights", weights)):
        if table is not None and not callable(table) and np.shape(table) != shape:
            raise ValueError(f"{name} has shape {np.shape(table)}; allowed: the camera's, {shape}")
    return from_coefficients(of_nodes, parameters, shape, data, weights)


def _pair(bench, values, camera: Camera | None) -> tuple[Scene, Camera]:
    made = bench(values)
    if camera is not None:
        made = (made, camera)
    elif not (isinstance(made, tuple) and len(made) == 2):
        raise ValueError("without a camera the bench must return (scene, camera); give one of them")
    require_bench(*made)
    return made


def from_coefficients(
    of_nodes: Callable[[Float[Array, " parameters"]], Float[Array, "fields count count"]],
    parameters: Float[Array, " parameters"],
    shape: tuple[int, int],
    data: Float[Array | np.ndarray, "rows columns"] | None = None,
    weights: Float[Array | np.ndarray, "rows columns"] | Callable[[Array], Array] | None = None,
) -> NormalEquations:
    """`normal_equations` of an image that is given by its Chebyshev coefficients (background, moduli, phases)."""
    at = of_nodes(parameters)
    changes = jnp.moveaxis(jax.jacfwd(of_nodes)(parameters), -1, 0)
    fields = chebyshev.expand(at, shape)
    factors = [jnp.ones(shape), *slopes(fields)]
    image = combine(fields)
    given = weights(image) if callable(weights) else weights
    weight: Array = jnp.ones(shape) if given is None else jnp.asarray(given)
    if data is None:
        gradient, misfit = jnp.zeros(len(changes)), jnp.zeros(())
    else:
        left = image - jnp.asarray(data)
        sums = jnp.stack([_moments(weight * left * factor, at.shape[-1]) for factor in factors])
        gradient, misfit = jnp.einsum("fkl,pfkl->p", sums, changes), 0.5 * jnp.vdot(weight * left, left)
    return NormalEquations(misfit, gradient, _matrix(weight, factors, changes))


def _moments(table: Float[Array, "rows columns"], count: int) -> Float[Array, "count count"]:
    """Σ over pixels of the table times T_k(y) T_l(x)."""
    along_y, along_x = (jnp.asarray(chebyshev.basis(n, count), table.dtype) for n in table.shape)
    return along_y @ (table @ along_x.T)


def _matrix(weight, factors, changes) -> Float[Array, "parameters parameters"]:
    count = changes.shape[-1]
    fine = 2 * count - 1
    onto = jnp.asarray(chebyshev.values(count, fine))  # from coefficients to the fine nodes, where products are exact
    at_fine = jnp.einsum("ik,pfkl,jl->fpij", onto, changes, onto, precision="highest")
    back = jnp.asarray(chebyshev.analysis(fine))
    total = jnp.zeros((len(changes), len(changes)), changes.dtype)
    for a, one in enumerate(factors):
        for b, other in enumerate(factors[: a + 1]):
            quadrature = back.T @ _moments(weight * one * other, fine) @ back
            part = jnp.einsum("pij,ij,qij->pq", at_fine[a], quadrature, at_fine[b], precision="highest")
            total = total + (part if a == b else part + part.T)
    return total
