"""How a measured radius depends on what a fit neglects: omitted-variable bias, from the image's own derivatives.

A fit that holds a number too large by δ moves its free ones by -(Jᵀ W J)⁻¹ Jᵀ W j δ, where J has the image's
derivatives by these and j that by the number (Angrist and Pischke 2009, Mostly Harmless Econometrics, section 3.2.2).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from fitting.electrons import Moves, photoelectrons, weights
from fitting.fisher import FREE, fine_nodes, information
from fitting.knobs import knobs
from newtonjax.camera import Camera
from newtonjax.methods import Chebyshev
from newtonjax.normal import from_coefficients
from newtonjax.precision import x64
from newtonjax.scene import Scene
from newtonjax.synthesis import synthesize

# Stages by which a refit follows what is wrong, and steps of Gauss and Newton's method in each.
_STAGES, _STEPS = 8, 12
# Of a stage the last step, over what the numbers have moved.
_SETTLED = 1e-9


@dataclass(frozen=True)
class Neglected:
    """A number that a fit holds, and what that costs.

    - `name`, `unit`, `value`: of the number.
    - `slope`: change of the target per unit by which the number is held too large, in their units.
    - `tolerance`: the error of the number that moves the target by the accuracy asked for; infinite where it moves it
      to second order only.
    """

    name: str
    unit: str
    value: float
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
        for one in self.neglected:
            known = "any" if one.tolerance > 1e3 * max(abs(one.value), 1.0) else f"{one.tolerance:.3g}"
            lines.append(f"{one.name:<14} {one.value:>12.6g} {known:>11} {one.unit:<15} {one.slope:+.4g}")
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
      free: what the fit finds together with it; all other numbers of `knobs.knobs` are held.
      noise: as in `information`.

    The slopes are those of a fit weighted by the camera's noise, to first order: of a tilt that is 0, and of what else
    is symmetric, the target depends to second order, and nothing is said.

    Raises ValueError as `information` does, and for an accuracy that is not positive.

    """
    if not 0 < accuracy < np.inf:
        raise ValueError(f"accuracy is {accuracy}; allowed: a positive fraction, such as 1e-3")
    known = knobs(scene, camera)
    free = (target, *(name for name in free if name != target))
    held = tuple(name for name in known if name not in free)
    told = information(scene, camera, (*free, *held), noise=noise)
    count = len(free)
    step = np.sqrt(np.maximum(np.diag(told.matrix), 1e-300))
    scaled = told.matrix / np.outer(step, step)
    # By least squares: of what is not determined they take nothing.
    moved = -np.linalg.lstsq(scaled[:count, :count], scaled[:count, count:], rcond=1e-10)[0][0]
    allowed = accuracy * abs(known[target].value)
    found = []
    for name, by, size in zip(held, moved, step[count:], strict=True):
        slope = float(by * size / step[0])
        small = abs(slope) * known[name].scale < 1e-9 * abs(known[target].value)
        tolerance = np.inf if small else allowed / abs(slope)
        found.append(Neglected(name, known[name].unit, known[name].value, slope, tolerance))
    found.sort(key=lambda one: one.tolerance / known[one.name].scale)
    sd = told.given(**dict.fromkeys(held, 0.0)).sd(target)
    unit = known[target].unit
    return Sensitivity(target, known[target].value, unit, allowed, sd, free[1:], tuple(found))


def refitted(
    scene: Scene,
    camera: Camera,
    wrong: Mapping[str, float],
    free: Sequence[str] = FREE,
    noise: float | None = None,
) -> dict[str, float]:
    """By how much the free numbers [units] move in a fit that holds some others off by `wrong` [units].

    The fit is least squares on the noise-free image, by Gauss and Newton's method through the nodes. Raises ValueError
    where it does not converge, and for numbers that the scene does not have.
    """
    known = knobs(scene, camera)
    if not set(free) | set(wrong) <= set(known):
        raise ValueError(f"numbers are {', '.join((*free, *wrong))}; allowed: {', '.join(known)}")
    method = fine_nodes(scene, camera)
    names = (*free, *wrong)
    moves = tuple((name, known[name].move) for name in names)
    scales = np.array([known[name].scale for name in names])
    # The image has the numbers as they are; the model has them off.
    off = np.array([wrong[name] / known[name].scale for name in wrong])
    with x64():
        data = _image(scene, camera, moves, jnp.asarray(scales), jnp.zeros(len(names)), method)
        weight = weights(data, camera, noise)
        at, count = np.zeros(len(free)), len(free)
        for stage in range(_STAGES + 1):
            for _ in range(_STEPS):
                steps = jnp.asarray(np.concatenate([at, off * stage / _STAGES]))
                made = _equations(scene, camera, moves, jnp.asarray(scales), steps, data, weight, method)
                matrix, gradient = (np.asarray(part) for part in (made.matrix, made.gradient))
                size = np.sqrt(np.diag(matrix)[:count])
                inner = matrix[:count, :count] / np.outer(size, size)
                move = -np.linalg.lstsq(inner, gradient[:count] / size, rcond=1e-12)[0] / size
                at = at + move
                if np.abs(move).max() <= _SETTLED * max(np.abs(at).max(), 1e-6):
                    break
            else:
                raise ValueError(f"the fit with {', '.join(wrong)} off does not converge: the effect is too large")
            # The fringes of the next stage are met where the last one's slopes put them: else it may miscount them.
            if stage < _STAGES:
                follow = np.linalg.lstsq(inner, (matrix[:count, count:] @ off) / size, rcond=1e-12)[0] / size
                at = at - follow / _STAGES
    return dict(zip(free, (at * scales[:count]).tolist(), strict=True))


def derivative_images(
    scene: Scene, camera: Camera, names: Sequence[str]
) -> dict[str, Float[np.ndarray, "rows columns"]]:
    """By name the derivative of the image [photoelectrons per unit of the number]."""
    known = knobs(scene, camera)
    moves = tuple((name, known[name].move) for name in names)
    scales = np.array([known[name].scale for name in names])
    with x64():
        found = np.asarray(_slopes(scene, camera, moves, jnp.asarray(scales), fine_nodes(scene, camera)))
    return dict(zip(names, found / scales[:, None, None], strict=True))


@partial(jax.jit, static_argnames=("moves", "method"))
def _image(scene, camera, moves: Moves, scales, steps, method: Chebyshev):
    table = photoelectrons(scene, camera, moves, scales, method)(steps)
    return synthesize(table, camera.shape)


@partial(jax.jit, static_argnames=("moves", "method"))
def _equations(scene, camera, moves: Moves, scales, steps, data, weight, method: Chebyshev):
    return from_coefficients(photoelectrons(scene, camera, moves, scales, method), steps, camera.shape, data, weight)


@partial(jax.jit, static_argnames=("moves", "method"))
def _slopes(scene, camera, moves: Moves, scales, method: Chebyshev):
    of_steps, still = photoelectrons(scene, camera, moves, scales, method), jnp.zeros(len(moves))
    table, changes = of_steps(still), jnp.moveaxis(jax.jacfwd(of_steps)(still), -1, 0)
    return jax.lax.map(lambda change: jax.jvp(lambda t: synthesize(t, camera.shape), (table,), (change,))[1], changes)
