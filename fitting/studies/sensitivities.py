"""How a measured radius depends on what a fit neglects: omitted-variable bias, from the image's own derivatives.

A fit that holds a number too large by δ moves its free ones by -(Jᵀ W J)⁻¹ Jᵀ W j δ, where J has the image's
derivatives by these and j that by the number (Angrist and Pischke 2009, Mostly Harmless Econometrics, section 3.2.2).
"""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from jaxtyping import Float

from fitting.parameters import chosen, free_names, knobs, target_first
from fitting.reasons import Reason
from fitting.studies.bench_origin import says_its_bench
from fitting.studies.fisher import derivatives, fine_nodes, information
from fitting.studies.gauss_newton import perfect_image
from fitting.studies.image_slopes import can_move, image_slopes, needs_images
from fitting.studies.implicit import measurement
from fitting.studies.pixel_sums import slopes_of
from fitting.studies.refusal import UndeterminedError
from fitting.studies.sensitivity_result import Neglected, Sensitivity
from newtonjax.methods import Chebyshev
from newtonjax.numerics import Joined, is_real, names_in, shown
from newtonjax.scene import Camera, Scene, require_bench


@says_its_bench
def sensitivity(
    scene: Scene,
    camera: Camera,
    *,
    target: str | None = None,
    relative_accuracy: float = 1e-3,
    free: Sequence[str] | None = None,
    noise: float | None = None,
    method: Chebyshev | None = None,
) -> Sensitivity:
    """What a fit of one number owes to each number that it holds fixed.

    Args:
      scene, camera: where; one gap with two faces.
      target: the number that is measured; None for the radius, or the wedge angle or the gap where there is none.
      relative_accuracy: to which it shall be known, as a fraction of it.
      free: what the fit determines with it; all other numbers of the bench are held fixed.
      noise [incident irradiance], method: as in `information`.

    The slopes are those of a fit weighted by the camera's noise, to first order: of a tilt that is 0, and of what else
    is symmetric, the target depends to second order, and nothing is said.

    Raises ValueError as `information` does, for an accuracy that is not positive, and for a target that is 0; and
    UndeterminedError, a ValueError, for one that the image does not determine.

    """
    if not (is_real(relative_accuracy) and np.ndim(relative_accuracy) == 0 and 0 < relative_accuracy < np.inf):
        raise ValueError(f"relative_accuracy is {shown(relative_accuracy)}; allowed: a positive fraction, such as 1e-3")
    every_knob = knobs(scene, camera)
    free = target_first(every_knob, target, free)
    chosen(every_knob, free)
    target, *beside = free
    if not every_knob[target].value:
        raise ValueError(
            f"{target} is 0 in this scene, so a relative accuracy is undefined; use a scene in which it is not 0"
        )
    movable = {name for name, knob in every_knob.items() if can_move(scene, camera, knob)}
    held = tuple(name for name in every_knob if name not in free and name in movable)
    bounds = information(scene, camera, free=(*free, *held), noise=noise, method=method)
    of_free = bounds.with_sd(**dict.fromkeys(held, 0.0))
    sd = of_free.sd(target)
    if not np.isfinite(sd):
        why = Joined("; ", of_free.undetermined) or "too few pixels"
        raise UndeterminedError(Reason.TARGET_UNDETERMINED(target=target, beside=Joined(", ", beside) or "it", why=why))
    count = len(free)
    step = np.sqrt(np.maximum(np.diag(bounds.matrix), 1e-300))
    scaled = bounds.matrix / np.outer(step, step)
    # By least squares: of what is not determined they take nothing.
    moves = -np.linalg.lstsq(scaled[:count, :count], scaled[:count, count:], rcond=1e-10)[0][0]
    allowed = relative_accuracy * abs(every_knob[target].value)
    neglected = []
    for name, by, size_by in zip(held, moves, step[count:], strict=True):
        slope = float(by * size_by / step[0])
        size = every_knob[name].scale if name == "gap" or not every_knob[name].value else abs(every_knob[name].value)
        tolerance = allowed / abs(slope) if 1e3 * size * abs(slope) > allowed else np.inf
        neglected.append(Neglected(name, every_knob[name].unit, every_knob[name].value, size, slope, tolerance))
    neglected.sort(key=lambda number: number.tolerance / number.size)
    warnings = []
    if sd > allowed:
        warnings.append(Reason.NOISE_ABOVE_ACCURACY())
    knob = every_knob[target]
    return Sensitivity(
        target,
        knob.value,
        knob.unit,
        relative_accuracy,
        sd,
        tuple(beside),
        tuple(neglected),
        warnings=warnings,
        images=partial(derivative_images, scene, camera),
    )


def refitted(
    scene: Scene,
    camera: Camera,
    shifts: Mapping[str, float],
    *,
    free: Sequence[str] | None = None,
    noise: float | None = None,
) -> dict[str, float]:
    """By how much the free numbers [units] move in a fit that is given others too large by `shifts`
    [units].

    The fit is `measurement` of the noise-free image. Raises ValueError where it does not converge, and for numbers that
    the scene does not have.
    """
    present = knobs(scene, camera)
    free = free_names(present, free)
    numbers = chosen(present, (*free, *shifts))
    method = fine_nodes(scene, camera)
    measure = measurement(scene, camera, free=free, noise=noise, method=method)
    image = perfect_image(scene, camera, method.nodes) / camera.exposure
    fit = measure(image, **{name: numbers[name].value + by for name, by in shifts.items()})
    if not fit.converged:
        raise ValueError(f"the fit with {', '.join(shifts)} off does not converge: the effect is too large")
    return {name: float(fit.numbers[name]) - numbers[name].value for name in free}


def derivative_images(
    scene: Scene, camera: Camera, names: Sequence[str]
) -> dict[str, Float[np.ndarray, "rows columns"]]:
    """By name the derivative of the image [photoelectrons per unit of the number].

    Raises ValueError for what is no scene, no camera, or no name of one of their numbers.
    """
    require_bench(scene, camera)
    numbers = chosen(knobs(scene, camera), names_in("names", names))
    if needs_images(scene, camera):
        _, images = image_slopes(scene, camera, list(numbers.values()))
    else:
        table, changes = derivatives(scene, camera, list(numbers.values()), fine_nodes(scene, camera).nodes)
        images = slopes_of(table, changes, camera.shape)
    return {name: image / knob.scale for (name, knob), image in zip(numbers.items(), images, strict=True)}
