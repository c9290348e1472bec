"""The closed form's phase in float32, computed in numbers of twice the bits."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.numerics import Double, double, exactly
from newtonjax.scene import Camera, Scene, Surface, frame, gap_opd, middle, required_gap


def closed_turns(scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
    """The phase 2 n t / λ of the gap at every pixel [turns], in float32 and without its whole turns.

    As `gap_opd` over the wavelength, in numbers of twice the bits: rounded itself, a phase of 250 turns errs by 1e-5.
    Concrete numbers keep their float64; traced ones have been rounded by JAX.
    """
    upper = required_gap(scene)
    above, below = scene.surfaces[upper], scene.surfaces[upper + 1]
    cx, cy = middle(camera.shape) if camera.centre_px is None else (camera.centre_px[0], camera.centre_px[1])
    numbers = (
        double(2 * scene.media[upper + 1]) / double(scene.wavelength),
        _numbers(above),
        _numbers(below),
        (double(camera.pixel_size), double(cx), double(cy)),
    )
    return _turns(numbers, scene, camera)


@jax.custom_jvp
def _turns(numbers, scene, camera):  # noqa: ARG001 (the scene is there for its tangents)
    return _turns_at_pixels(numbers, camera.shape)


@_turns.defjvp
def _turns_jvp(primals, tangents):
    numbers, scene, camera = primals

    def plain(scene, camera):
        x, y = camera.axes()
        return jnp.broadcast_to(gap_opd(scene, x[None, :], y[:, None]) / scene.wavelength, camera.shape)

    return _turns(numbers, scene, camera), jax.jvp(plain, (scene, camera), tangents[1:])[1]


@partial(jax.jit, static_argnums=1)
def _turns_at_pixels(numbers, shape: tuple[int, int]):
    # The compiler folds constants of a sum, as if it were exact: behind the barrier there are none.
    columns, rows = double(np.arange(shape[1])), double(np.arange(shape[0]))
    numbers, columns, rows = jax.lax.optimization_barrier((numbers, columns, rows))
    per_metre, over, under, (pixel, cx, cy) = numbers
    x, y = (columns - cx) * pixel, (rows - cy) * pixel
    return (per_metre * (_height(over, x, y) - _height(under, x, y))).turn()


def _numbers(surface: Surface) -> tuple[Double, ...]:
    """Curvature, vertex, and the slopes of the vertex plane."""
    axis = frame(surface.tilt)[2]
    return (
        double(surface.curvature),
        *map(double, surface.vertex),
        double(axis[0] / axis[2]),
        double(axis[1] / axis[2]),
    )


def _height(numbers: tuple[Double, ...], x: Double, y: Double) -> Double:
    """`gap.height` of a surface over columns x and rows y."""
    curvature, at_x, at_y, at_z, slope_x, slope_y = numbers
    dx, dy = x - at_x, y - at_y
    r2 = (dx * dx).at(None) + (dy * dy).at(slice(None), None)
    level = at_z - ((slope_x * dx).at(None) + (slope_y * dy).at(slice(None), None))
    return level + _sag(curvature, r2)


def _sag(curvature: Double, r2: Double) -> Double:
    """`scene.sag`, h, in float32, and a step of Newton's method on c h² - 2 h + c r² = 0."""
    parabola = curvature * r2
    inside = 1 - curvature.high * parabola.high
    root = jnp.sqrt(jnp.where(inside > 0, inside, 1.0))
    rough = exactly(parabola.high / (1 + root))
    residual = parabola + curvature * rough * rough - exactly(2 * rough.high)
    height = rough + exactly((residual.high + residual.low) / (2 * root))
    return Double(*(jnp.where(inside > 0, h, p) for h, p in zip(height, parabola, strict=True)))
