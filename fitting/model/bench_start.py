"""Where to start the fit of a traced bench: its numbers that make the phase that the gap formula has found."""

from dataclasses import replace

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from fitting.model.phase import Frame, SceneModel, as_arrays, held_numbers, localize
from fitting.parameters import Quantities, change, curved_surface, quantities_of
from newtonjax.fields import fields_at
from newtonjax.scene import Scene, gap_height, imaged_plane

_ROUNDS = 20


def scene_start(scene: Scene, known: Quantities, frame: Frame, gap: np.ndarray, found: np.ndarray, fixed: dict):
    """The model of a bench and its starting numbers.

    `gap`: the gap formula's free numbers; `found`: its phase at the nodes. The quantities that are given replace the
    scene's; the unknown one starts from the gap formula. Then the bench's phase at the nodes is fitted to the one
    found, which has no fringes to miscount.

    Raises ValueError where the bench's beams do not reach the whole image.
    """
    at = curved_surface(scene)
    own = quantities_of(scene, at)
    place, rise = gap[1:3], 0.0
    if "centre_px" in fixed:
        place = [(c - m) / frame.unit for c, m in zip(fixed["centre_px"], frame.middle, strict=True)]
    # A collecting lens enlarges the gap's pixels to those of the screen.
    apparent = known.values(float(gap[0]) / frame.unit**2 * float(imaged_plane(scene)[1]) ** 2)
    # Where the apparent quantity makes no bench that light gets through, the scene's own one may.
    for values in (apparent, {**apparent, **known.given, known.measured: own.get(known.measured, 0.0)}):
        if not values[known.measured]:
            continue
        # What a shield cuts off is dark in the photograph, which masks it; the phase has no edge there.
        bench = replace(scene, shield=None)
        for name, value in own.items():
            bench = change(bench, name, values[name] / value, at)
        model = SceneModel(frame, bench, values["pixel_size"], at, known.measured)
        points = jnp.stack([frame.x - frame.middle[0], frame.y - frame.middle[1]], axis=1) * values["pixel_size"]
        if bool(_arrives(as_arrays(bench), points)):
            if "gap" in fixed:
                rise = (fixed["gap"] - gap_height(bench)) * 2 / values["wavelength"]
            return model, _match(
                as_arrays(model), np.array([0.0, *place, rise, *gap[4:7], 0.0, gap[8]]), held_numbers(fixed), found
            )
    raise ValueError("the scene's beams do not reach the whole image; check pixel_size, screen and thicknesses")


@eqx.filter_jit
def _arrives(scene: Scene, points):
    return fields_at(scene, points).arrives.all()


def _match(model: SceneModel, numbers: np.ndarray, held: tuple[int, ...], found: np.ndarray) -> np.ndarray:
    """Free numbers that make a phase, up to whole turns, by Gauss and Newton's method on the nodes.

    A constant stands in for the rise, which hardly differs from it: so the rise stays within half a turn of the
    scene's, and does not run away along a valley of centre and radius. Its fraction is the rise's in the end.
    """
    free = [k for k in range(3) if k not in held]
    sign, constant, slope = 0.0, 0.0, np.ones((1, len(numbers)))
    for _ in range(_ROUNDS):
        local = localize(model, jnp.asarray(numbers))
        phase = np.asarray(local.value[0])
        # The image does not tell the sign of the curvature; the scene does.
        sign = sign or np.sign(_bend(phase))
        slope = np.asarray(local.slope[0])
        columns = np.concatenate([slope[:, free], np.ones((len(phase), 1))], axis=1)
        *move, constant = np.linalg.lstsq(columns, sign * found - phase, rcond=None)[0]
        # A radius may not change by more than half in one step: its sign is the scene's.
        move = np.array(move) * min(1.0, 0.5 / max(abs(move[0]), 1e-12))
        numbers = numbers.copy()
        numbers[free] += move
        if np.abs(slope[:, free] @ move).max() < 1e-3:
            break
    if 3 not in held:
        numbers[3] += (constant - np.round(constant)) / slope[:, 3].mean()
    return numbers


def _bend(phase: np.ndarray) -> float:
    count = round(phase.shape[0] ** 0.5)
    grid = phase.reshape(count, count)
    return float(grid[0, 0] + grid[-1, -1] - 2 * grid[count // 2, count // 2])
