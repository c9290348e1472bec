"""The public verbs: render an image, or its optical path difference."""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from newtonjax.camera import Camera
from newtonjax.checks import require_bench, require_method, unreached
from newtonjax.methods import AbstractMethod, Chebyshev, ClosedForm
from newtonjax.planning import plan
from newtonjax.precision import afresh, require_x64, x64
from newtonjax.quantities import is_concrete
from newtonjax.scene import Scene
from newtonjax.splatting import Splat


def render(
    scene: Scene, camera: Camera, method: AbstractMethod | None = None, tolerance: float = 1e-3
) -> Float[Array, "rows columns"]:
    """The image on the scene's screen: irradiance over the incident one, without noise.

    Without a method, `plan` picks the cheapest whose error is at most `tolerance` times the largest intensity. Inside a
    transformation (jit, grad, vmap) the numbers are not known: there the given method is used, or `Chebyshev()`.
    Called eagerly it computes in float64 whatever JAX's setting, and returns float32 where x64 is off.

    Raises ValueError where the method cannot honour a part of the scene, RuntimeError where a transformation would
    trace rays in float32.
    """
    return _run(_image, scene, camera, method, tolerance)


def opd(
    scene: Scene, camera: Camera, method: AbstractMethod | None = None, tolerance: float = 1e-3
) -> Float[Array, "rows columns"]:
    """Optical path difference of the scene's two beams at every pixel [m]: paths only, without phase jumps.

    The beam with more gap crossings minus the other. Method, precision and errors as in `render`; a scene that has not
    exactly two beams raises ValueError.
    """
    if len(scene.beams) != 2:
        raise ValueError(f"a path difference is between two beams; this scene has {len(scene.beams)}")
    return _run(_opd, scene, camera, method, tolerance)


def _run(kernel, scene, camera, method, tolerance):
    require_bench(scene, camera)
    require_method(method)
    scene, camera = afresh(scene, camera)
    if not is_concrete(scene, camera):
        method = Chebyshev() if method is None else method
        method.check(scene)
        if not isinstance(method, ClosedForm):
            require_x64(type(method).__name__)
        elif not jax.config.read("jax_enable_x64"):
            # As it stands: compiled apart, it would be given its numbers in float32, the concrete ones too.
            kernel = kernel.__wrapped__
        return kernel(scene, camera, method)[0]
    if method is None:
        chosen = plan(scene, camera, tolerance)
        scene, method = chosen.scene, chosen.method
    else:
        method.check(scene)
    method = pixels_as_set(method)
    with x64():
        # Splatting refines its source by what it sees, and so cannot be compiled as a whole.
        image, reached = (kernel.__wrapped__ if isinstance(method, Splat) else kernel)(scene, camera, method)
    if not reached:
        raise unreached(method)
    # An array of a type that the user's setting does not have would warn at every further step.
    return image if jax.config.read("jax_enable_x64") or image.dtype == jnp.float32 else _as_float32(image)


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
    if isinstance(method, Chebyshev):
        return method.image_and_reach(scene, camera)
    return method.image(scene, camera), True


@partial(jax.jit, static_argnames="method")
def _opd(scene, camera, method):
    if isinstance(method, Chebyshev):
        return method.opd_and_reach(scene, camera)
    return method.opd(scene, camera), True
