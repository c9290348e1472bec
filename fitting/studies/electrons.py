"""A photograph without its noise, in photoelectrons, as a function of a bench's numbers; and what each pixel weighs."""

from collections.abc import Callable, Sequence

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from newtonjax.fields import jet_fields
from newtonjax.methods import Chebyshev
from newtonjax.numerics import Jet, Scalar, is_concrete, jets, module_of, require, shown
from newtonjax.scene import NOISE, Camera, Scene

# Names of numbers, and how each is moved (`knobs.Knob.move`): hashable, so that they may be static arguments.
Moves = tuple[tuple[str, Callable], ...]
# A bench, and what its image has more than it: numbers of the image alone, by name.
Photographed = tuple[Scene, Camera, dict]


def moved(scene: Scene, camera: Camera, moves: Moves, steps, scales) -> Photographed:
    """A bench with its numbers moved by steps [numbers] in their scales: arrays, jets, or traced."""
    by = {name: step * scale for (name, _), step, scale in zip(moves, steps, scales, strict=True)}
    for name, move in moves:
        scene, camera = move(scene, camera, by[name])
    return scene, camera, by


def tables(benches: Sequence[Photographed], nodes: int, levels: int) -> tuple[Jet, Bool[np.ndarray, " benches"]]:
    """Chebyshev coefficients [benches, 3, n, n] of each image's background, modulus and phase [photoelectrons, turns].

    And whether all beams reach the nodes. The benches' numbers may be jets of so many levels, level 0 the launch
    plane's (`jet_fields`); the coefficients then are. Nothing is compiled. Raises ValueError for pixels that are means
    and for channels, which the nodes do not hold.
    """
    for _, camera, _ in benches:
        if camera.takes_means or camera.response is not None:
            raise ValueError(
                "aperture, blur or response of a camera in this study; allowed: None (`information` and "
                "`sensitivity` take them)"
            )
    fields = jet_fields.at_nodes([(scene, camera) for scene, camera, _ in benches], nodes, levels)
    table = jet_fields.coefficients(fields)

    def each(numbers):
        return jets.stack([jets.asarray(number, float) for number in numbers]).reshape(len(benches), 1, 1)

    exposure = each(camera.exposure for _, camera, _ in benches)
    contrast = each(1 + by.get("contrast", 0.0) for _, _, by in benches)
    constant = np.zeros((nodes, nodes))
    constant[0, 0] = 1.0
    stray = each(by.get("stray", 0.0) for _, _, by in benches) * constant
    parts = [(table[:, 0] + stray) * exposure, table[:, 1] * contrast * exposure, table[:, 2]]
    return jets.stack(parts, axis=1), np.asarray(fields.arrives.all(axis=1))


def photoelectrons(
    scene: Scene, camera: Camera, moves: Moves, scales, method: Chebyshev
) -> Callable[[Float[Array, " numbers"]], Float[Array, "fields count count"]]:
    """As `tables` of one bench, from steps of its numbers, for JAX's transformations."""

    def of_steps(steps):
        at_scene, at_camera, by = moved(scene, camera, moves, steps, scales)
        background, modulus, phase = method.coefficients(method.fields(at_scene, at_camera))
        background = background.at[0, 0].add(by.get("stray", 0.0))
        modulus = modulus * (1 + by.get("contrast", 0.0))
        return jnp.stack([background * at_camera.exposure, modulus * at_camera.exposure, phase])

    return of_steps


def weights(image, camera: Camera, noise: Scalar | None):
    """One over the variance of a pixel: shot and read noise and the code's rounding, or `noise` [incident irradiance].

    Saturated pixels weigh nothing. NumPy makes NumPy.
    """
    xp = module_of(image)
    if noise is not None:
        allowed = f"a standard deviation of {NOISE.words}, in incident irradiance"
        require("noise", noise, allowed, NOISE.holds)
        if is_concrete(noise) and np.ndim(noise):
            raise ValueError(f"noise is {shown(noise)}; allowed: {allowed}")
        return xp.full_like(image, 1.0) / (1.0 * noise * camera.exposure) ** 2
    return xp.where(image < camera.full_well, 1 / variance(image, camera), 0.0)


def variance(image, camera: Camera):
    """Of a pixel [photoelectrons squared]: shot and read noise, and the rounding of its code. NumPy makes NumPy."""
    code = camera.full_well / (2**camera.bits - 1)
    return module_of(image).maximum(image, 0.0) + camera.read_noise**2 + code**2 / 12
