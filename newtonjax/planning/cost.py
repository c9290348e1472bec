"""How long an image takes on this machine, predicted from its cost in passes of a cosine."""

from functools import cache
from time import perf_counter

import jax
import jax.numpy as jnp
import numpy as np

from newtonjax.methods import PASS_PIXELS, AbstractMethod
from newtonjax.numerics import cos_turns, x64
from newtonjax.scene import Camera, Scene


@cache
def _pass_seconds() -> float:
    """How long such a pass takes on this machine: the median of several over a sixteenth of it."""
    with x64():
        turns = jnp.linspace(0.0, 50.0, PASS_PIXELS // 16)
        compiled = jax.jit(cos_turns)
        jax.block_until_ready(compiled(turns))
        times = []
        for _ in range(9):
            begin = perf_counter()
            jax.block_until_ready(compiled(turns))
            times.append(perf_counter() - begin)
    return 16 * float(np.median(times))


def predicted_seconds(method: AbstractMethod, scene: Scene, camera: Camera) -> float:
    """How long a compiled image takes [s], to a factor of about two."""
    return method.passes(scene, camera) * _pass_seconds()
