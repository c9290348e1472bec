"""Normal equations of an image in any parameters, through the nodes: their cost hardly grows with their number."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.fields import (
    WIDE,
    coefficients_and_changes,
    image,
    pack,
    pairs,
    pairs_of,
    product_sums,
    synthesize,
)
from newtonjax.methods import Chebyshev, has_channels, require_method, unreached
from newtonjax.numerics import (
    chebyshev,
    finite,
    image_memory,
    is_concrete,
    is_real,
    refuse_after_fork,
    require,
    require_x64,
    shown,
    x64,
)
from newtonjax.scene import Camera, Scene, node_points, require_bench

# Bytes a pixel, measured: data, weights, and the image that these may be made from.
_BYTES = 32


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

    Raises ValueError for parameters that are no vector, tables of another shape, and (not within a transformation,
    where numbers are not known) beams that miss a node and images larger than memory; RuntimeError within a
    transformation in float32.

    """
    require_method(method, Chebyshev)
    method = Chebyshev() if method is None else method
    if not callable(bench):
        raise ValueError(f"bench is {shown(bench)}; allowed: a function that makes a scene of the parameters")
    require("parameters", parameters, "a vector of finite numbers", finite)
    if np.ndim(parameters) != 1 or not np.size(parameters):
        raise ValueError(f"parameters is {shown(parameters)}; allowed: a vector, not empty")
    if not is_concrete(parameters, data):
        refuse_after_fork()  # the user's own program runs in this process
        require_x64("normal_equations")
        return _equations(bench, parameters, camera, data, weights, method)
    with x64():
        values = jnp.asarray(np.asarray(parameters, dtype=float))
        scene, seen_by = _pair(bench, values, camera)
        image_memory(seen_by.shape, _BYTES)
        _check_tables(seen_by.shape, data, weights)
        if not method.fields(scene, seen_by).arrives.all():
            raise unreached(method)
        at, changes = _known_nodes(bench, values, camera, method)
        return from_changes(at, changes, seen_by.shape, data, weights)


def _equations(bench, parameters, camera, data, weights, method) -> NormalEquations:
    def of_nodes(values):
        return method.coefficients(method.fields(*_pair(bench, values, camera)))

    shape = _pair(bench, parameters, camera)[1].shape
    _check_tables(shape, data, weights)
    return from_coefficients(of_nodes, parameters, shape, data, weights)


def _check_tables(shape: tuple[int, int], data, weights) -> None:
    tables = {"data": data, "weights": None if callable(weights) else weights}
    for name, table in tables.items():
        if table is None:
            continue
        if not is_real(table):
            raise ValueError(f"{name} is {shown(table)}; allowed: an array of the camera's shape, {shape}")
        if np.shape(table) != shape:
            raise ValueError(f"{name} has shape {np.shape(table)}; allowed: the camera's, {shape}")


def _known_nodes(bench, parameters: Float[Array, " parameters"], camera: Camera | None, method: Chebyshev):
    """Coefficients at the nodes, and by how much they change with each parameter, of known numbers.

    By two programs: a small one from the parameters to the bench's numbers, made anew at each call, since `bench` may
    have changed what it takes from elsewhere; and a large one from these to the coefficients, which serves all benches.
    """
    beam_pairs = pairs(_pair(bench, parameters, camera)[0])

    def numbers(values):
        scene, seen_by = _pair(bench, values, camera)
        packed = pack(scene)
        points = jnp.asarray(node_points(seen_by, method.nodes))
        words = packed.routes.action, packed.routes.down
        values_of_bench = (
            packed.routes._replace(action=None, down=None),
            packed.setting,
            packed.source,
            points,
        )
        return jax.tree.map(jnp.asarray, values_of_bench), words

    def push(values, direction):
        return jax.jvp(numbers, (values,), (direction,), has_aux=True)

    of_bench = jax.jit(jax.vmap(push, in_axes=(None, 0), out_axes=(None, 0, None)))
    values_of_bench, changes, words = of_bench(parameters, np.eye(len(parameters)))
    return coefficients_and_changes(values_of_bench, changes, words, np.array(beam_pairs, dtype=int).reshape(-1, 2))


def _pair(bench, values, camera: Camera | None) -> tuple[Scene, Camera]:
    pair = bench(values)
    if camera is not None:
        pair = (pair, camera)
    elif not (isinstance(pair, tuple) and len(pair) == 2):
        raise ValueError("without a camera the bench must return (scene, camera); give one of them")
    require_bench(*pair)
    if has_channels(pair[0].light, pair[1]):
        raise ValueError("light.spectrum or camera.response in normal_equations; allowed: one line, one channel")
    return pair


def from_coefficients(
    of_nodes: Callable[[Float[Array, " parameters"]], Float[Array, "fields count count"]],
    parameters: Float[Array, " parameters"],
    shape: tuple[int, int],
    data: Float[Array | np.ndarray, "rows columns"] | None = None,
    weights: Float[Array | np.ndarray, "rows columns"] | Callable[[Array], Array] | None = None,
) -> NormalEquations:
    """`normal_equations` of an image that is given by its Chebyshev coefficients (background, moduli, phases)."""
    return from_changes(*with_changes(of_nodes, parameters), shape, data, weights)


def with_changes(
    of_nodes: Callable[[Float[Array, " parameters"]], Float[Array, "fields count count"]],
    parameters: Float[Array, " parameters"],
) -> tuple[Float[Array, "fields count count"], Float[Array, "parameters fields count count"]]:
    """Coefficients, and their derivatives by every parameter, from one pass of the rays."""

    def twice(parameters):
        at = jnp.asarray(of_nodes(parameters))
        return at, at

    changes, at = jax.jacfwd(twice, has_aux=True)(parameters)
    return at, jnp.moveaxis(changes, -1, 0)


def from_changes(at, changes, shape: tuple[int, int], data=None, weights=None) -> NormalEquations:
    """`from_coefficients` of coefficients and their changes [parameters, fields, count, count]."""
    known = is_concrete(at, changes, data, None if callable(weights) else weights)
    if callable(weights):
        weights = weights(image(at, shape) if known else synthesize(at, shape))
    tables = [None if table is None else jnp.asarray(table, at.dtype) for table in (data, weights)]
    return (_alone if known else _assembled)(at, changes, shape, *tables)


def _assembled(at, changes, shape: tuple[int, int], data, weights) -> NormalEquations:
    sums = product_sums(at, shape, data, weights)
    gradient = jnp.einsum("fkl,pfkl->p", sums.slopes, changes, precision="highest")
    return NormalEquations(0.5 * sums.misfit, gradient, _matrix(sums.pairs, changes))


_alone = jax.jit(_assembled, static_argnums=2, compiler_options=WIDE)


def _matrix(
    moments: Float[Array, "pairs fine fine"], changes: Float[Array, "parameters fields count count"]
) -> Float[Array, "parameters parameters"]:
    """Σ over pairs of fields of the changes' products, summed by quadrature on nodes where they are exact."""
    fine = moments.shape[-1]
    onto = jnp.asarray(chebyshev.values(changes.shape[-1], fine), changes.dtype)
    at_fine = jnp.einsum("ik,pfkl,jl->fpij", onto, changes, onto, precision="highest")
    back = jnp.asarray(chebyshev.analysis(fine), changes.dtype)
    total = jnp.zeros((len(changes), len(changes)), changes.dtype)
    for (a, b), moment in zip(pairs_of(changes.shape[1]), moments, strict=True):
        quadrature = jnp.einsum("ki,kl,lj->ij", back, moment, back, precision="highest")
        part = jnp.einsum("pij,ij,qij->pq", at_fine[a], quadrature, at_fine[b], precision="highest")
        total = total + (part if a == b else part + part.T)
    return total
