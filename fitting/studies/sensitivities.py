"""How a measured radius depends on what a fit neglects: omitted-variable bias, from the image's own derivatives.

A fit that holds a number too large by δ moves its free ones by -(Jᵀ W J)⁻¹ Jᵀ W j δ, where J has the image's
derivatives by these and j that by the number (Angrist and Pischke 2009, Mostly Harmless Econometrics, section 3.2.2).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from fitting.parameters import Knob, chosen, knobs
from fitting.studies.fisher import FREE, derivatives, fine_nodes, information
from fitting.studies.gauss_newton import perfect_image
from fitting.studies.implicit import measurement
from fitting.studies.pixel_sums import slopes_of
from fitting.studies.refusal import UndeterminedError
from newtonjax.scene import Camera, Scene


@dataclass(frozen=True)
class Neglected:
    """A number that a fit holds, and what that costs.

    - `name`, `unit`, `value`: of the number.
    - `size`: its value, or what matters of it where that is zero [`unit`].
    - `slope`: change of the target per unit by which the number is held too large, in their units.
    - `tolerance`: the error of the number that moves the target by the accuracy asked for; infinite where that is more
      than 1000 times its size.
    """

    name: str
    unit: str
    value: float
    size: float
    slope: float
    tolerance: float


@dataclass(frozen=True)
class Sensitivity:
    """What `sensitivity` found. `str()` is a table, the most critical number first.

    - `target`, `value`, `unit`, `accuracy`: the number that is measured, and to what [unit].
    - `sd`: Cramér–Rao bound of the target with the free numbers unknown [unit].
    - `free`: what the fit finds beside it; `neglected`: what it holds.
    """

    target: str
    value: float
    unit: str
    accuracy: float
    sd: float
    free: tuple[str, ...]
    neglected: tuple[Neglected, ...]

    def __str__(self) -> str:
        lines = [
            f"{self.target} = {self.value:.6g} {self.unit}, noise alone {self.sd:.2g} {self.unit}; "
            f"free with it: {', '.join(self.free) or 'nothing'}",
            f"to know it to {self.accuracy:.2g} {self.unit} ({abs(self.accuracy / self.value):.2g} of it):",
            f"{'':<14} {'value':>12} {'known to':>11} {'unit':<15} {self.target} per unit",
        ]
        if self.sd > self.accuracy:
            lines.insert(2, "noise alone leaves more than that: take more light, pixels or rings before all else")
        for number in self.neglected:
            tolerance = "any" if np.isinf(number.tolerance) else f"{number.tolerance:.3g}"
            lines.append(
                f"{number.name:<14} {number.value:>12.6g} {tolerance:>11} {number.unit:<15} {number.slope:+.4g}"
            )
        return "\n".join(lines)


def sensitivity(
    scene: Scene,
    camera: Camera,
    target: str = "radius",
    accuracy: float = 1e-3,
    free: Sequence[str] = FREE,
    noise: float | None = None,
) -> Sensitivity:
    """What a fit of one number owes to each number that it holds at a value.

    Args:
      scene, camera: where; one gap with two faces.
      target: the number that is measured; accuracy: to what, as a fraction of it.
      free: what the fit finds together with it; all other numbers of `parameters.knobs` are held.
      noise: as in `information`.

    The slopes are those of a fit weighted by the camera's noise, to first order: of a tilt that is 0, and of what else
    is symmetric, the target depends to second order, and nothing is said.

    Raises ValueError as `information` does, for an accuracy that is not positive, and for a target that is 0; and
    UndeterminedError, a ValueError, for one that the image does not tell.

    """
    if not (isinstance(accuracy, int | float) and 0 < accuracy < np.inf):
        raise ValueError(f"accuracy is {accuracy!r}; allowed: a positive fraction, such as 1e-3")
    every_knob = knobs(scene, camera)
    free = free_beside(target, free, every_knob)
    chosen(every_knob, free)
    beside = tuple(name for name in free if name != target)
    if not every_knob[target].value:
        raise ValueError(f"{target} is 0 here: a fraction of it is no accuracy; take a scene in which it is not 0")
    held = tuple(name for name in every_knob if name not in free)
    bounds = information(scene, camera, (*free, *held), noise=noise)
    of_free = bounds.given(**dict.fromkeys(held, 0.0))
    sd = of_free.sd(target)
    if not np.isfinite(sd):
        words = "; ".join(of_free.undetermined) or "too few pixels"
        raise UndeterminedError(f"the image does not tell the {target} with {', '.join(beside) or 'it'} free: {words}")
    count = len(free)
    step = np.sqrt(np.maximum(np.diag(bounds.matrix), 1e-300))
    scaled = bounds.matrix / np.outer(step, step)
    # By least squares: of what is not determined they take nothing.
    moves = -np.linalg.lstsq(scaled[:count, :count], scaled[:count, count:], rcond=1e-10)[0][0]
    allowed = accuracy * abs(every_knob[target].value)
    neglected = []
    for name, by, size_by in zip(held, moves, step[count:], strict=True):
        slope = float(by * size_by / step[0])
        size = every_knob[name].scale if name == "gap" or not every_knob[name].value else abs(every_knob[name].value)
        tolerance = allowed / abs(slope) if 1e3 * size * abs(slope) > allowed else np.inf
        neglected.append(Neglected(name, every_knob[name].unit, every_knob[name].value, size, slope, tolerance))
    neglected.sort(key=lambda number: number.tolerance / number.size)
    unit = every_knob[target].unit
    return Sensitivity(target, every_knob[target].value, unit, allowed, sd, beside, tuple(neglected))


def free_beside(target: str, free: Sequence[str], every_knob: Mapping[str, Knob]) -> tuple[str, ...]:
    """The target and what is found beside it: no radius of its own accord where a scene has none."""
    names = (free,) if isinstance(free, str) else tuple(free)
    return (target, *(name for name in names if name != target and (name in every_knob or free is not FREE)))


def refitted(
    scene: Scene,
    camera: Camera,
    shifts: Mapping[str, float],
    free: Sequence[str] = FREE,
    noise: float | None = None,
) -> dict[str, float]:
    """By how much the free numbers [units] move in a fit that holds some others off by `shifts` [units].

    The fit is `measurement` of the noise-free image. Raises ValueError where it does not converge, and for numbers that
    the scene does not have.
    """
    numbers = chosen(knobs(scene, camera), (*free, *shifts))
    method = fine_nodes(scene, camera)
    measure = measurement(scene, camera, free, noise=noise, method=method)
    image = perfect_image(scene, camera, method.nodes) / camera.exposure
    fit = measure(image, **{name: numbers[name].value + by for name, by in shifts.items()})
    if not fit.converged:
        raise ValueError(f"the fit with {', '.join(shifts)} off does not converge: the effect is too large")
    return {name: float(fit.numbers[name]) - numbers[name].value for name in free}


def derivative_images(
    scene: Scene, camera: Camera, names: Sequence[str]
) -> dict[str, Float[np.ndarray, "rows columns"]]:
    """By name the derivative of the image [photoelectrons per unit of the number]."""
    numbers = chosen(knobs(scene, camera), tuple(names))
    table, changes = derivatives(scene, camera, list(numbers.values()), fine_nodes(scene, camera).nodes)
    images = slopes_of(table, changes, camera.shape)
    return {name: image / knob.scale for (name, knob), image in zip(numbers.items(), images, strict=True)}
