"""What an image costs, predicted: operations in units of one cosine, and how long that takes here."""

from functools import cache
from time import perf_counter

import jax
import jax.numpy as jnp
import numpy as np

from newtonjax.methods import AbstractMethod, Chebyshev, ClosedForm
from newtonjax.numerics import cos_turns, x64
from newtonjax.scene import Camera, Scene, itinerary

# Fitted to timings of 1024 x 1024 pixels on two cores, in passes of `cos_turns` over them (0.6 ms): a field's degree,
# what else a pixel costs, the closed form, one ray through one surface, and what a call costs by itself. That plans
# made with them are fast is what `experiments/accuracy/planner.py` checks.
_DEGREE, _PIXEL, _CLOSED, _STOP, _CALL = 0.059, 0.27, 1.6, 1.3e-3, 0.6
_PIXELS = 1024 * 1024
# Traced pixels are worked through one block after another: a ray costs more than one of a small grid's.
_TRACED = 1.5


def passes(method: AbstractMethod, scene: Scene, camera: Camera) -> float:
    """Cost of an image in passes of a cosine over 1024 x 1024 pixels."""
    share = camera.shape[0] * camera.shape[1] / _PIXELS
    pairs = len(scene.beams) * (len(scene.beams) - 1) // 2
    stops = sum(len(itinerary(word, len(scene.surfaces)).surface) for word in scene.beams)
    if isinstance(method, ClosedForm):
        return _CALL + _CLOSED * share
    if isinstance(method, Chebyshev):
        fields = 1 + 2 * pairs
        at_pixels = _PIXEL + pairs - 1 + _DEGREE * fields * method.nodes
        return _CALL + share * at_pixels + _STOP * stops * method.nodes**2
    return _CALL + _TRACED * _STOP * stops * share * _PIXELS


@cache
def _pass_seconds() -> float:
    """How long such a pass takes on this machine: the median of several over a sixteenth of it."""
    with x64():
        turns = jnp.linspace(0.0, 50.0, _PIXELS // 16)
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
    return passes(method, scene, camera) * _pass_seconds()
