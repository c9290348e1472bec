"""What the faces of a bench do within an image that no lens does: end, pass through each other, fold its rays."""

from math import isqrt
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from newtonjax.numerics import Statement, is_concrete
from newtonjax.planning.reasons import PlanReason
from newtonjax.scene import Camera, Scene, Surface, corners, gap_height, gap_of, imaged_plane, node_points

# Of a wavelength: lenses that are pressed together come nearer by as much.
_PRESSED = 0.5
# Light that is more oblique [rad] shows another part of a surface than the one below the image.
_OBLIQUE = 0.1


def end_warnings(scene: Scene, camera: Camera) -> tuple[Statement, ...]:
    """That a surface that is no sphere ends within the image: its figure at its disc, its base where it is upright.

    Nothing is said of traced numbers, nor of light that is tilted by more than 0.1 rad.
    """
    shaped = [(k, surface) for k, surface in enumerate(scene.surfaces) if surface.is_shaped()]
    if not shaped or not is_concrete(scene, camera) or np.abs(np.asarray(scene.light.tilt)).max() > _OBLIQUE:
        return ()
    rim = corners(camera) / abs(float(imaged_plane(scene)[1]))
    warnings = []
    for k, surface in shaped:
        reach = float(np.hypot(*(rim - np.asarray(surface.vertex)[:2]).T).max())
        end, what = min(_ends(surface), default=(np.inf, ""))
        if reach > end:
            words = PlanReason.SURFACE_ENDS(
                surface=k, end_mm=f"{1e3 * end:.4g}", what=what, reach_mm=f"{1e3 * reach:.4g}"
            )
            warnings.append(words)
    return tuple(warnings)


def _ends(surface: Surface) -> list[tuple[float, str]]:
    """Distances from the vertex at which a surface ends [m], and what ends it."""
    curvature, across = float(surface.curvature), surface.curvature_across
    conic = 0.0 if surface.conic is None else float(surface.conic)
    steepest = max(abs(curvature), 0.0 if across is None else abs(float(across))) * np.sqrt(max(1 + conic, 0.0))
    ends = [] if steepest == 0 else [(float(1 / steepest), "its base stands upright")]
    if surface.figure is not None:
        ends.append((float(surface.figure.radius), f"its {type(surface.figure).__name__} ends"))
    return ends


def crossing_warnings(
    scene: Scene,
    camera: Camera,
    paths: Float[Any, "beams n"],
    arrives: Bool[Any, "beams n"],
    pairs: Int[np.ndarray, "pairs 2"],
) -> tuple[Statement, ...]:
    """That the faces of the gap pass through each other, by both beams' paths [m] at a square of nodes.

    By more than a negative height of the vertex says, and than half a wavelength. Planes and convex spheres, which
    do so where they are tilted about a point of contact, are left alone.
    """
    upper = gap_of(scene)
    if upper is None or not _may_cross(*scene.surfaces[upper : upper + 2]):
        return ()
    ((once, thrice),) = pairs  # by crossings of the gap
    height = (paths[thrice] - paths[once]) / (2 * float(scene.media[upper + 1]))
    height = np.where(arrives.all(axis=0), height, np.inf)
    depth = min(gap_height(scene), 0.0) - float(height.min())
    if depth <= _PRESSED * float(scene.wavelength):
        return ()
    x, y = (f"{1e3 * value:.2f}" for value in _nodes(camera, height)[height.argmin()])
    return (PlanReason.FACES_CROSS(x_mm=x, y_mm=y, depth_um=f"{1e6 * depth:.3g}"),)


def _may_cross(above: Surface, below: Surface) -> bool:
    """Whether faces can be nearer than at their vertices: one has a shape, or the gap closes outwards."""
    return float(above.curvature) < float(below.curvature) or above.is_shaped() or below.is_shaped()


def _nodes(camera: Camera, values: np.ndarray) -> Float[np.ndarray, "n 2"]:
    """Points [m] of the square of nodes at which the values are along their last axis."""
    return node_points(camera, isqrt(values.shape[-1]))


def refuse_folds(scene: Scene, camera: Camera, arrives: Bool[np.ndarray, " n"], unexplained: bool) -> None:
    """Raise ValueError for a scene with a face that is no sphere, of which rays fold within the image.

    `arrives`: whether every beam does, at a square of nodes; `unexplained`: by the ends of surfaces.
    """
    shaped = [k for k, surface in enumerate(scene.surfaces) if surface.is_shaped()]
    if not shaped or not unexplained or scene.shield is not None:
        return
    points = _nodes(camera, arrives)
    missed = 1e3 * float(np.hypot(*points.T)[~arrives].min())
    faces = " and ".join(f"surfaces[{k}] ({', '.join(scene.surfaces[k].shape_words())})" for k in shaped)
    slope = max(_slope(scene.surfaces[k], points) for k in shaped)
    raise ValueError(
        f"{faces}: too steep for this image, slopes up to {slope:.2g}: its rays fold {missed:.2f} mm off the axis, "
        "several or none to a pixel; allowed: a smaller image or a flatter surface; method=Traced() draws one of them"
    )


def _slope(surface: Surface, points: Float[np.ndarray, "n 2"]) -> float:
    """The largest, of heights a thousandth of the image apart."""
    (x, y), step = points.T - np.asarray(surface.vertex)[:2, None], 1e-3 * float(np.ptp(points))
    along_x = surface.sag(x + step, y) - surface.sag(x - step, y)
    along_y = surface.sag(x, y + step) - surface.sag(x, y - step)
    return float(np.hypot(along_x, along_y).max() / (2 * step))
