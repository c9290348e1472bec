"""A photograph without its noise, in photoelectrons, as a function of a scene's numbers; and what each pixel weighs."""

from collections.abc import Callable

import jax.numpy as jnp
from jaxtyping import Array, Float

from newtonjax.camera import Camera
from newtonjax.methods import Chebyshev
from newtonjax.quantities import Scalar, positive, require
from newtonjax.scene import Scene

# Names of numbers, and how each is moved (`knobs.Knob.move`): hashable, so that they may be static arguments.
Moves = tuple[tuple[str, Callable], ...]


def photoelectrons(
    scene: Scene, camera: Camera, moves: Moves, scales, method: Chebyshev
) -> Callable[[Float[Array, " numbers"]], Float[Array, "fields count count"]]:
    """From steps of numbers, in their scales, to the image: Chebyshev coefficients of background, moduli and phases."""

    def of_steps(steps):
        by = {name: step * scale for (name, _), step, scale in zip(moves, steps, scales, strict=True)}
        at_scene, at_camera = scene, camera
        for name, move in moves:
            at_scene, at_camera = move(at_scene, at_camera, by[name])
        table = method.coefficients(method.fields(at_scene, at_camera))
        pairs = (len(table) - 1) // 2
        table = table.at[1 : 1 + pairs].multiply(1 + by.get("contrast", 0.0))
        table = table.at[0, 0, 0].add(by.get("stray", 0.0))
        return table.at[: 1 + pairs].multiply(at_camera.exposure)

    return of_steps


def weights(image: Float[Array, "rows columns"], camera: Camera, noise: Scalar | None) -> Float[Array, "rows columns"]:
    """One over the variance of a pixel: shot and read noise and the code's rounding, or `noise` [incident irradiance].

    Saturated pixels weigh nothing.
    """
    if noise is not None:
        require("noise", noise, "a positive standard deviation, in incident irradiance", positive)
        return jnp.full_like(image, 1.0) / (noise * camera.exposure) ** 2
    return jnp.where(image < camera.full_well, 1 / variance(image, camera), 0.0)


def variance(image: Float[Array, "rows columns"], camera: Camera) -> Float[Array, "rows columns"]:
    """Of a pixel [photoelectrons squared]: shot and read noise, and the rounding of its code."""
    code = camera.full_well / (2**camera.bits - 1)
    return jnp.clip(image, 0.0) + camera.read_noise**2 + code**2 / 12
