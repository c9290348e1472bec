"""Where to start the fit of a traced bench: its numbers that make the phase that the gap formula has found."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from fitting.models import Frame, SceneModel, as_arrays, change, curved_surface, localize
from fitting.quantity import Quantities
from newtonjax.fields import fields_at
from newtonjax.gap import required_gap
from newtonjax.scene import Scene

_ROUNDS = 20


def gap_height(scene: Scene) -> float:
    """Height of the upper face's vertex over the lower one's [m]."""
    upper = required_gap(scene)
    return float(scene.surfaces[upper].vertex[2] - scene.surfaces[upper + 1].vertex[2])


def scene_start(scene: Scene, known: Quantities, frame: Frame, gap: np.ndarray, found: np.ndarray, fixed: dict):
    """The model of a bench, its starting numbers, and which of them are held.

    `gap`: the gap formula's free numbers; `found`: its phase at the nodes. The quantities that are given replace the
    scene's; the unknown one starts from the gap formula. Then the bench's phase at the nodes is fitted to the one
    found, which has no fringes to miscount.

    Raises ValueError where the bench's beams do not reach the whole image.
    """
    values = known.values(float(gap[0]) / frame.unit**2)
    upper, at = required_gap(scene), curved_surface(scene)
    radius = 1 / float(scene.surfaces[at].curvature)
    scene = change(scene, "radius", values["radius"] / abs(radius), at)
    scene = change(scene, "wavelength", values["wavelength"] / float(scene.wavelength), at)
    scene = change(scene, "index", values["index"] / float(scene.media[upper + 1]), at)
    model = SceneModel(frame, scene, values["pixel_size"], at, known.measured)
    rise = (fixed["gap"] - gap_height(scene)) * 2 / values["wavelength"] if "gap" in fixed else 0.0
    place = gap[1:3]
    if "centre_px" in fixed:
        place = [(c - m) / frame.unit for c, m in zip(fixed["centre_px"], frame.middle, strict=True)]
    numbers = np.array([0.0, *place, rise])
    points = jnp.stack([frame.x - frame.middle[0], frame.y - frame.middle[1]], axis=1) * values["pixel_size"]
    if not bool(_arrives(as_arrays(scene), points)):
        raise ValueError("the scene's beams do not reach the whole image; check pixel_size, screen and thicknesses")
    held = ((1, 2) if "centre_px" in fixed else ()) + ((3,) if "gap" in fixed else ())
    return model, _match(as_arrays(model), numbers, held, found), held


@eqx.filter_jit
def _arrives(scene: Scene, points):
    return fields_at(scene, points).arrives.all()


def _match(model: SceneModel, numbers: np.ndarray, held: tuple[int, ...], found: np.ndarray) -> np.ndarray:
    """Free numbers that make a phase, up to whole turns, by Gauss and Newton's method on the nodes."""
    free = [k for k in range(len(numbers)) if k not in held]
    wanted = None
    for _ in range(_ROUNDS):
        local = localize(model, jnp.asarray(numbers))
        phase = np.asarray(local.value[0])
        if wanted is None:
            # The image does not tell the sign of the curvature; the scene does.
            wanted = np.sign(_bend(phase)) * found
            wanted += np.round(np.mean(phase - wanted))
        slope = np.asarray(local.slope[0])[:, free]
        move = np.linalg.lstsq(slope, wanted - phase, rcond=None)[0]
        # A radius may not change by more than half in one step: its sign is the scene's.
        move *= min(1.0, 0.5 / max(abs(move[0]), 1e-12)) if 0 in free else 1.0
        numbers = numbers.copy()
        numbers[free] += move
        if np.abs(slope @ move).max() < 1e-3:
            break
    return numbers


def _bend(phase: np.ndarray) -> float:
    count = round(phase.shape[0] ** 0.5)
    grid = phase.reshape(count, count)
    return float(grid[0, 0] + grid[-1, -1] - 2 * grid[count // 2, count // 2])
