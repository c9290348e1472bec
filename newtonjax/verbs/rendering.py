"""The public verbs: render an image, or its optical path difference."""

import warnings
from functools import partial

import jax
from jaxtyping import Array, Float

from newtonjax.methods import AbstractMethod, AbstractPicture, Chebyshev, is_single, require_method, require_two_beams
from newtonjax.numerics import Statement, afresh, image_memory, is_concrete, refuse_after_fork, require_x64
from newtonjax.planning import end_warnings, planned
from newtonjax.scene import Camera, Scene, require_bench


def render(
    scene: Scene, camera: Camera, method: AbstractMethod | None = None, tolerance: float = 1e-3
) -> Float[Array, "rows columns *channels"]:
    """The image on the scene's screen: irradiance over the incident one, without noise.

    Of a camera with a `response` the last axis is its channels.

    Without a method, `plan` picks the cheapest whose error is at most `tolerance` times the largest intensity. Inside a
    transformation (jit, grad, vmap) the numbers are not known: there the given method is used, or `Chebyshev()`.
    Called eagerly it computes in float64 whatever JAX's setting, and returns float32 where x64 is off, and warns of
    what the plan warns of; with a method given, of surfaces that end within the image.

    Raises ValueError where the method cannot honour a part of the scene and where the image is larger than memory,
    RuntimeError where a transformation would trace rays in float32.
    """
    require_bench(scene, camera)
    require_method(method)
    if not is_concrete(scene, camera):
        return _within_transformation(_image, scene, camera, method)
    scene, method, picture = _choose_for_memory(scene, camera, method, tolerance)
    return (method.picture(scene, camera) if picture is None else picture).image()


def opd(
    scene: Scene, camera: Camera, method: AbstractMethod | None = None, tolerance: float = 1e-3
) -> Float[Array, "rows columns"]:
    """Optical path difference of the scene's two beams at every pixel [m]: paths only, without phase jumps.

    The beam with more gap crossings minus the other. Method, precision and errors as in `render`; a scene that has not
    exactly two beams raises ValueError.
    """
    require_bench(scene, camera)
    require_method(method)
    require_two_beams(scene)
    if not is_concrete(scene, camera):
        return _within_transformation(_opd, scene, camera, method)
    scene, method, _ = _choose_for_memory(scene, camera, method, tolerance)
    return method.opd_picture(scene, camera).image()


def choose(
    scene: Scene, camera: Camera, method: AbstractMethod | None, tolerance: float
) -> tuple[Scene, AbstractMethod, AbstractPicture | None]:
    """Scene and method as they are given, or planned: then with the picture that the plan comes with.

    Raises ValueError where the method given cannot honour a part of the scene.
    """
    if method is not None:
        method.check(scene)
        method.check_camera(camera)
        _warn(end_warnings(scene, camera))
        return scene, method, None
    chosen, picture = planned(scene, camera, tolerance)
    _warn(chosen.warnings)
    return chosen.scene, chosen.method, picture


def _warn(sentences: tuple[Statement, ...]) -> None:
    for words in sentences:
        warnings.warn(words, stacklevel=4)


def _choose_for_memory(scene, camera, method, tolerance):
    """`choose`, refused where memory does not hold what the method takes for the pixels."""
    if method is None:
        image_memory(camera.shape, 4 if is_single() else 8)  # of the image alone, before anything is traced
    scene, method, picture = choose(scene, camera, method, tolerance)
    image_memory(camera.shape, method.bytes_per_pixel())
    return scene, method, picture


def _within_transformation(verb, scene, camera, method: AbstractMethod | None):
    """Pixels of traced numbers, by a compiled form of a verb; `__wrapped__` is what that was made of."""
    method = Chebyshev() if method is None else method
    method.check(scene)
    method.check_camera(camera)
    refuse_after_fork()  # the user's own program runs in this process
    if method.needs_float64:
        require_x64(type(method).__name__)
    # In float32 as it stands: compiled apart, it would be given its numbers in float32, the concrete ones too.
    return (verb.__wrapped__ if is_single() else verb)(*afresh(scene, camera), method)


@partial(jax.jit, static_argnames="method")
def _image(scene, camera, method):
    return method.image(scene, camera)


@partial(jax.jit, static_argnames="method")
def _opd(scene, camera, method):
    return method.opd(scene, camera)
