"""What pairs of rays of one source node get wrong, against rays aimed at where the two meet."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from newtonjax.fields import Packed
from newtonjax.methods.meeting import Rule, pair_opd
from newtonjax.rays import Route, Setting, arrive, trace
from newtonjax.scene import Camera

# Newton's steps to the pair that meets at a point of the frame.
_STEPS = 8


def largest_error(bench: Packed, camera: Camera, rule: Rule, points, starts: Float[np.ndarray, "beams n 2"]) -> float:
    """Largest phase error of pairs that meet at points of the screen [turns]: see `Splatted`.

    `starts`: where on the source to begin the search, by beam [m].
    """
    sizes = np.array([rule.reach(camera), camera.pixel_size, bench.source.wavelength])
    worst, looked = 0.0, False
    for j, k in bench.pairs:
        first, second = (jax.tree.map(lambda leaf, b=b: leaf[b], bench.routes) for b in (j, k))
        error, met = map(np.asarray, _wrong(first, second, bench.setting, sizes, points, starts[j], path=rule.path))
        worst, looked = np.maximum(worst, np.where(met, error, 0.0).max()), looked or bool(met.any())
    return float(worst) if looked else np.inf


@partial(jax.jit, static_argnames="path")
def _wrong(first: Route, second: Route, setting: Setting, sizes, points, starts, path: str):
    """Errors of the pairs of two beams that meet at points [turns], and whether they do: one program for all benches.

    `sizes`: how far apart the rays of a pair may land, a pixel's size, the wavelength [m].
    """
    reach, pixel, wavelength = sizes

    def wrong(point, start):
        def rays(start):
            landing_1, landing_2 = (trace(route, setting, start)[0] for route in (first, second))
            return (landing_1.point + landing_2.point) / 2, (landing_1, landing_2)

        def nearer(start, _):
            slope, _ = jax.jacfwd(rays, has_aux=True)(start)
            return start + jnp.linalg.solve(slope, point - rays(start)[0]), None

        start, _ = jax.lax.scan(nearer, start, None, length=_STEPS)
        landing_1, landing_2 = rays(start)[1]
        opd, meeting, apart = pair_opd(path, setting, landing_1, landing_2)
        exact_1, exact_2 = arrive(first, setting, meeting), arrive(second, setting, meeting)
        error = jnp.abs(opd - exact_2.path + exact_1.path) / wavelength
        # Pairs further apart than they may be do not count; nearer ones there err less, by the order of the error.
        share = jnp.minimum(1.0, reach / jnp.where(apart > 0, apart, 1.0))
        error = error * share ** (1 if path == "raw" else 2)
        error = error + jnp.abs(exact_2.quarter_turns - exact_1.quarter_turns) / 4
        met = landing_1.alive & landing_2.alive & (jnp.abs(meeting - point).max() < 1e-3 * pixel)
        return jnp.where(exact_1.arrives & exact_2.arrives, error, jnp.inf), met

    return jax.vmap(wrong)(points, starts)
