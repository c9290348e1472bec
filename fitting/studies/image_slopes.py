"""Derivatives of images of any light and any camera that can be rendered, by differences of rendered images.

Nodes of background, modulus and phase (`electrons.tables`) hold one line of parallel light at points. What spectra,
sources, all orders and pixels of an area make of it is rendered, at steps that change the image by a hundredth of its
fringes: differences of the fourth order then err by some 1e-8 of the derivative.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from fitting.parameters import EVEN, TABLE, Knob, still
from newtonjax.fields import airy_of
from newtonjax.methods import AbstractMethod, Chebyshev, ClosedForm, OverSource, parallel
from newtonjax.numerics import chebyshev, require_memory, x64
from newtonjax.planning import planned
from newtonjax.scene import Camera, Scene, channels_of

# What the method may err by, the first that a method keeps; and a table of a spectrum, whose errors change with its
# ends. A hundredth of the image is a hundredth of a bound.
_TOLERANCES, _TABLE = (1e-4, 1e-3, 1e-2), 1e-10
# Change of the image that a step makes, in root mean squares of the fringes; the first step, in scales, and how often
# it is corrected.
_CHANGE, _FIRST, _CORRECTIONS = 1e-2, 1e-5, 4
# Steps and weights of differences of the fourth order about a place, and ahead of it (Fornberg 1988).
_CENTRAL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
_AHEAD = ((0, -25 / 12), (1, 4.0), (2, -3.0), (3, 4 / 3), (4, -1 / 4))

Image = Float[np.ndarray, "rows columns *channels"]


def needs_images(scene: Scene, camera: Camera) -> bool:
    """Whether an image is more than two beams of one line of parallel light at points."""
    light = scene.light
    has_parts = light.spectrum is not None or light.extent is not None or scene.all_orders is not None
    return has_parts or camera.takes_means or camera.response is not None


def image_slopes(
    scene: Scene, camera: Camera, numbers: Sequence[Knob]
) -> tuple[Image, Float[np.ndarray, "numbers rows columns *channels"]]:
    """The image [photoelectrons], and its derivatives by steps in the numbers' scales.

    Raises ValueError where no method renders the scene within a hundredth, and where memory does not hold all images.
    """
    size = float(np.prod(camera.image_shape)) * 8 * (len(numbers) + 4)
    require_memory(f"a study of {camera.shape[0]} x {camera.shape[1]} pixels", size, "allowed: a smaller shape")
    method = _fine(_method_of(scene, camera))
    middle = _rendered(method, scene, camera)
    fringes = middle - _background(scene, camera)
    slopes = np.zeros((len(numbers), *middle.shape))
    for place, knob in enumerate(numbers):
        if knob.move is still:
            slopes[place] = (fringes if knob.name == "contrast" else float(camera.exposure)) * knob.scale
        elif knob.name == "exposure":
            slopes[place] = middle / knob.value * knob.scale
        elif knob.value or knob.name not in EVEN:
            slopes[place] = _slope(_images_along(knob, method, scene, camera), knob, float(np.std(fringes)))
    return middle, slopes


def _method_of(scene: Scene, camera: Camera) -> AbstractMethod:
    for tolerance in _TOLERANCES[:-1]:
        with suppress(ValueError):
            return planned(scene, camera, tolerance)[0].method
    return planned(scene, camera, _TOLERANCES[-1])[0].method


def can_move(scene: Scene, camera: Camera, knob: Knob) -> bool:
    """Whether there is a method for the image with this number moved: of all orders only the closed form is."""
    if knob.move is still or scene.all_orders is None:
        return True
    return ClosedForm().refusal(knob.move(scene, camera, _FIRST * knob.scale)[0]) is None


def _images_along(knob: Knob, method: AbstractMethod, scene: Scene, camera: Camera) -> Callable[[float], Image]:
    """From a step of a number, in its scale, to the image; by rays where it moves the bench out of a closed form.

    Raises ValueError where nothing but a closed form has the image.
    """
    if not can_move(scene, camera, knob):
        raise ValueError(
            f"{knob.name} of a bench with all orders; allowed: what leaves it upright, and focused on the gap"
        )
    if isinstance(method, ClosedForm) and method.refusal(knob.move(scene, camera, _FIRST * knob.scale)[0]) is not None:
        method = _fine(Chebyshev(17) if scene.light.extent is None else OverSource(Chebyshev(9), 3))

    def image(step: float) -> Image:
        return _rendered(method, *knob.move(scene, camera, step * knob.scale))

    return image


def _slope(at: Callable[[float], Image], knob: Knob, swing: float) -> Image:
    """By differences, at steps that change the image noticeably and keep the number within what it can be."""
    middle = at(0.0)
    least, _ = TABLE[knob.name].bounds
    room = max((knob.value - least) / (2 * knob.scale), 0.0) if least == 0 else np.inf
    step = _FIRST
    for _ in range(_CORRECTIONS):
        change = float(np.sqrt(np.mean((at(step) - middle) ** 2)))
        growth = float(np.clip(_CHANGE * swing / change, 1e-3, 1e3)) if change > 0 else 1e3
        step = min(step * growth, 0.1)
        if 0.3 < growth < 3:
            break
    is_ahead = room < step
    weights = _AHEAD if is_ahead else _CENTRAL
    return sum((weight * (at(k * step) if k else middle) for k, weight in weights), np.zeros_like(middle)) / step


def _rendered(method: AbstractMethod, scene: Scene, camera: Camera) -> Image:
    with x64():
        return np.asarray(method.picture(scene, camera).image(), float) * float(camera.exposure)


def _fine(method: AbstractMethod) -> AbstractMethod:
    """The method with a table of negligible error."""
    if isinstance(method, OverSource):
        return replace(method, method=_fine(method.method))
    return replace(method, table_error=_TABLE) if isinstance(method, ClosedForm | Chebyshev) else method


def _background(scene: Scene, camera: Camera) -> Float[np.ndarray, "..."]:
    """What the image would be without fringes [photoelectrons]; a number, or one for each channel, where it is even."""
    levels = channels_of(scene.light, camera.response).powers.sum(axis=1) * float(camera.exposure)
    levels = levels if camera.response is not None else levels[0]
    if ClosedForm().refusal(parallel(scene)) is None:
        return np.asarray(airy_of(scene, np.asarray(scene.wavelength), np.zeros(())).level.mean() * levels)
    bench, points, method = parallel(scene), replace(camera, aperture=None, blur=None), Chebyshev(17)
    (coefficients,) = chebyshev.coefficients(method.light(bench, points).background)
    along_y, along_x = (chebyshev.basis(n, 17) for n in camera.shape)
    even = along_y.T @ coefficients @ along_x
    return even[..., None] * levels if camera.response is not None else even * levels
