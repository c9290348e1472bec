"""Where two rays of one source point meet: the plane in which an extended source shows their fringes."""

import jax
import numpy as np

from newtonjax.fields.packed import pack
from newtonjax.numerics import finite, require, require_concrete, shown, x64
from newtonjax.rays import trace
from newtonjax.scene import Scene, require_scene, word_of


def meeting_height(scene: Scene, first: str, second: str, start: tuple[float, float] | None = None) -> float:
    """Z at which two beams' rays from one launch point meet, or come nearest, drawn on past their last surfaces [m].

    The plane of localization of their fringes (Born and Wolf, Principles of Optics, section 7.5.3); what stands between
    bench and screen does not matter. Infinite for parallel rays: fringes of equal inclination.

    Args:
      scene: its own beams do not count.
      first, second: words, or names as in `choose_beams`; both leave on one side.
      start: launch point (u, v) on the plane across the light through the first vertex [m]; None is next to the axis,
        by 1/10 000 of the steepest face's radius, since on the axis itself the rays of centred faces coincide.

    Raises ValueError for an unknown name, for rays that never leave, and for traced values.

    """
    require_scene(scene)
    require_concrete("meeting_height", scene)
    words = tuple(word_of(name, len(scene.surfaces)) for name in (first, second))
    bare = Scene(scene.surfaces, scene.media, scene.light, scene.screen, words)
    if start is None:
        start = (1e-4 / max([1.0, *(abs(float(s.curvature)) for s in scene.surfaces)]), 0.0)
    allowed = "two lengths in metres, (u, v)"
    require("start", start, allowed, finite)
    if np.shape(start) != (2,):
        raise ValueError(f"start is {shown(start)}; allowed: {allowed}")
    bench = pack(bare)
    with x64():
        landing = _rays(bench.routes, bench.setting, np.array(start, dtype=float))
    if not np.all(landing.alive):
        raise ValueError(f"the rays of {first} and {second} from {start} m do not both leave the stack; move the start")
    (p, q), (d, e) = np.asarray(landing.position), np.asarray(landing.direction)
    # Of the points p + t d and q + s e, the nearest: the difference is normal to both rays.
    across = np.cross(d, e)
    if across @ across < 1e-24:  # parallel to 1e-12 rad, which is the rounding of a trace
        return np.inf
    t = np.cross(q - p, e) @ across / (across @ across)
    s = np.cross(q - p, d) @ across / (across @ across)
    return float((p + t * d)[2] + (q + s * e)[2]) / 2


# One program for all benches; the landings of both beams.
_rays = jax.jit(lambda routes, setting, start: jax.vmap(lambda route: trace(route, setting, start)[0])(routes))
