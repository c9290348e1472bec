"""Where to start the fit of a traced bench: its numbers that make the phase that the gap formula has found."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np

from fitting.model.parts import PARTS, WARPS, free_numbers, numbers_of
from fitting.model.phase import SceneModel, as_arrays, localize
from fitting.model.warp import Frame
from fitting.parameters import NUMBERS, Numbers, Quantities, change, curved_surface, quantities_of, slots_of
from newtonjax.fields import arrivals, pack
from newtonjax.scene import Scene, gap_height, imaged_plane

_ROUNDS = 20


def scene_start(scene: Scene, quantities: Quantities, frame: Frame, gap: np.ndarray, target: np.ndarray, fixed: dict):
    """The model of a bench and its starting numbers.

    `gap`: the gap formula's free numbers; `target`: its phase at the nodes [turns]. The quantities that are given
    replace the scene's; the unknown one starts from the gap formula. Then the bench's phase at the nodes is fitted to
    the target, which has no fringes to miscount.

    Raises ValueError where the bench's beams do not reach the whole image.
    """
    at = curved_surface(scene)
    of_scene = quantities_of(scene, at)
    beyond = numbers_of(part for part in PARTS if part not in WARPS)
    start = np.array(Numbers(*gap)._replace(curvature=0.0, phase=0.0, **dict.fromkeys(beyond, 0.0)))
    if "centre_px" in fixed:
        x, y = ((c - m) / frame.unit for c, m in zip(fixed["centre_px"], frame.middle, strict=True))
        start = np.array(Numbers(*start)._replace(centre_x=x, centre_y=y))
    # A collecting lens enlarges the gap's pixels to those of the screen.
    curvature = float(Numbers(*gap).curvature) / frame.unit**2
    apparent = quantities.values(curvature * float(imaged_plane(scene)[1]) ** 2)
    measured = quantities.measured
    # Where the apparent quantity makes no bench that light gets through, the scene's own one may.
    for values in (apparent, {**apparent, **quantities.given, measured: of_scene.get(measured, 0.0)}):
        if not values[measured]:
            continue
        # What a shield cuts off is dark in the photograph, which masks it; the phase has no edge there.
        bench = replace(scene, shield=None)
        for name, value in of_scene.items():
            bench = change(bench, name, values[name] / value, at)
        model = SceneModel(frame, bench, values["pixel_size"], at, measured)
        points = np.stack([frame.x - frame.middle[0], frame.y - frame.middle[1]], axis=1) * values["pixel_size"]
        if arrivals(pack(bench), points).arrives.all():
            if "gap" in fixed:
                start = np.array(
                    Numbers(*start)._replace(phase=(fixed["gap"] - gap_height(bench)) * 2 / values["wavelength"])
                )
            return model, _match(as_arrays(model), start, free_numbers(fixed), target)
    raise ValueError("the scene's beams do not reach the whole image; check pixel_size, screen and thicknesses")


def _match(model: SceneModel, numbers: np.ndarray, free: tuple[str, ...], target: np.ndarray) -> np.ndarray:
    """Free numbers that make a phase, up to whole turns, by Gauss and Newton's method on the nodes.

    A constant stands in for the rise, which hardly differs from it: so the rise stays within half a turn of the
    scene's, and does not run away along a valley of centre and radius. Its fraction is the rise's in the end.
    """
    moving = slots_of(name for name in ("curvature", "centre_x", "centre_y") if name in free)
    sign, constant, slope = 0.0, 0.0, np.ones((1, len(numbers)))
    for _ in range(_ROUNDS):
        local = localize(model, jnp.asarray(numbers))
        phase = np.asarray(local.value[0])
        # The image does not tell the sign of the curvature; the scene does.
        sign = sign or np.sign(_bend(phase))
        slope = np.asarray(local.slope[0])
        columns = np.concatenate([slope[:, moving], np.ones((len(phase), 1))], axis=1)
        *move, constant = np.linalg.lstsq(columns, sign * target - phase, rcond=None)[0]
        # A radius may not change by more than half in one step: its sign is the scene's.
        move = np.array(move) * min(1.0, 0.5 / max(abs(move[0]), 1e-12))
        numbers = numbers.copy()
        numbers[moving] += move
        if np.abs(slope[:, moving] @ move).max() < 1e-3:
            break
    if "phase" in free:
        rise = NUMBERS.index("phase")
        numbers[rise] += (constant - np.round(constant)) / slope[:, rise].mean()
    return numbers


def _bend(phase: np.ndarray) -> float:
    count = round(phase.shape[0] ** 0.5)
    grid = phase.reshape(count, count)
    return float(grid[0, 0] + grid[-1, -1] - 2 * grid[count // 2, count // 2])
