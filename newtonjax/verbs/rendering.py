"""The public verbs: render an image, or its optical path difference."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.fields import image
from newtonjax.methods import AbstractMethod, Chebyshev, ClosedForm, Traced, require_method, unreached
from newtonjax.numerics import afresh, chebyshev, image_memory, is_concrete, require_x64, x64
from newtonjax.planning import planned
from newtonjax.scene import Camera, Scene, require_bench

# Bytes a pixel while an image is computed, measured; on nodes there is the image alone.
_BYTES = {ClosedForm: 30, Traced: 32}


def render(
    scene: Scene, camera: Camera, method: AbstractMethod | None = None, tolerance: float = 1e-3
) -> Float[Array, "rows columns"]:
    """The image on the scene's screen: irradiance over the incident one, without noise.

    Without a method, `plan` picks the cheapest whose error is at most `tolerance` times the largest intensity. Inside a
    transformation (jit, grad, vmap) the numbers are not known: there the given method is used, or `Chebyshev()`.
    Called eagerly it computes in float64 whatever JAX's setting, and returns float32 where x64 is off.

    Raises ValueError where the method cannot honour a part of the scene and where the image is larger than memory,
    RuntimeError where a transformation would trace rays in float32.
    """
    return _run(_IMAGE, scene, camera, method, tolerance)


def opd(
    scene: Scene, camera: Camera, method: AbstractMethod | None = None, tolerance: float = 1e-3
) -> Float[Array, "rows columns"]:
    """Optical path difference of the scene's two beams at every pixel [m]: paths only, without phase jumps.

    The beam with more gap crossings minus the other. Method, precision and errors as in `render`; a scene that has not
    exactly two beams raises ValueError.
    """
    if len(scene.beams) != 2:
        raise ValueError(f"a path difference is between two beams; this scene has {len(scene.beams)}")
    return _run(_OPD, scene, camera, method, tolerance)


class _Verb(NamedTuple):
    """What a verb computes: at every pixel by a method, and the coefficients of its fields at nodes."""

    at_pixels: Any  # compiled; `__wrapped__` is what it was made of
    at_nodes: Callable[[Scene, Camera, Chebyshev], tuple[Float[np.ndarray, "fields nodes nodes"], Any]]


def _run(verb: _Verb, scene, camera, method, tolerance):
    require_bench(scene, camera)
    require_method(method)
    scene, camera = afresh(scene, camera)
    if not is_concrete(scene, camera):
        method = Chebyshev() if method is None else method
        method.check(scene)
        compute = verb.at_pixels
        if not isinstance(method, ClosedForm):
            require_x64(type(method).__name__)
        elif not jax.config.read("jax_enable_x64"):
            # As it stands: compiled apart, it would be given its numbers in float32, the concrete ones too.
            compute = compute.__wrapped__
        return compute(scene, camera, method)
    single = not jax.config.read("jax_enable_x64")
    image_memory(camera.shape, _BYTES.get(type(method), 4 if single else 8))
    coefficients = None
    if method is None:
        chosen, coefficients = planned(scene, camera, tolerance)
        scene, method = chosen.scene, chosen.method
        image_memory(camera.shape, _BYTES.get(type(method), 4 if single else 8))
    else:
        method.check(scene)
    method = pixels_as_set(method)
    if isinstance(method, Chebyshev):
        if coefficients is None or verb is not _IMAGE:
            coefficients, reached = verb.at_nodes(scene, camera, method)
            if not reached:
                raise unreached(method)
        # An array of a type that the user's setting does not have would warn at every further step.
        dtype = (method.dtype if verb is _IMAGE else None) or "float64"
        return image(coefficients, camera.shape, dtype, "float32" if single else dtype)
    with x64():
        # As it stands: a program around it would be another one for each bench.
        pixels = verb.at_pixels.__wrapped__(scene, camera, method)
    return _as_float32(pixels) if single and pixels.dtype != jnp.float32 else pixels


def pixels_as_set(method: AbstractMethod) -> AbstractMethod:
    """The method with its pixels in the type of JAX's setting, where it leaves that open."""
    if not isinstance(method, Chebyshev) or method.dtype is not None:
        return method
    return replace(method, dtype="float64" if jax.config.read("jax_enable_x64") else "float32")


def _as_float32(image):
    with x64():
        return jax.block_until_ready(image.astype(jnp.float32))


@partial(jax.jit, static_argnames="method")
def _image(scene, camera, method):
    return method.image(scene, camera)


@partial(jax.jit, static_argnames="method")
def _opd(scene, camera, method):
    return method.opd(scene, camera)


def at_nodes(scene: Scene, camera: Camera, method: Chebyshev) -> tuple[Float[np.ndarray, "fields nodes nodes"], Any]:
    """The coefficients of the image's fields, and whether every beam reaches every node; for known numbers."""
    fields = method.fields(scene, camera)
    return method.coefficients(fields), fields.arrives.all()


def _opd_at_nodes(scene, camera, method):
    paths, arrives = method.paths(scene, camera)
    return chebyshev.coefficients(paths[None]), arrives.all()


_IMAGE, _OPD = _Verb(_image, at_nodes), _Verb(_opd, _opd_at_nodes)
