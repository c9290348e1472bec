"""Many scenes in one call and bounded memory: `sweep`."""

from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from newtonjax.methods import AbstractMethod, require_method
from newtonjax.numerics import require_concrete, require_mapping, require_memory, require_whole, shown, x64
from newtonjax.planning import plan
from newtonjax.scene import Camera, Scene, require_camera

# Pixels that are computed side by side where no batch is asked for, and scenes that are planned for.
_PIXELS, _PLANNED = 2**22, 32
# Of memory a pixel of each scene that is computed, measured.
_BYTES = 36


def sweep(
    bench: Callable[..., Scene],
    values: Mapping[str, Any],
    camera: Camera,
    method: AbstractMethod | None = None,
    *,
    reduce: Callable[[Array], Any] | None = None,
    tolerance: float = 1e-3,
    batch: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Any:
    """Images of many scenes, or what is made of them, by programs for a shape and not for a bench.

        contrast = nj.sweep(nj.newton_rings, {"radius": radii, "gap": 1e-6}, camera, reduce=jax.numpy.std)

    Args:
      bench: makes a scene of numbers given by name.
      values: by name, arrays of one length n, or single numbers for all; in the bench's units.
      camera: of all images.
      method: of all images; None for the one that keeps the tolerance in up to 32 of the scenes, spread evenly.
      reduce: from an image to what is kept of it (arrays, or a tree of them); None keeps the image.
      batch: scenes whose pixels are computed side by side; by default as many as have 4 million pixels. What memory
        holds besides are these and the answer. Only nodes are batched; other methods take one scene after the other.
      progress: a function of (steps done, their number): two to a scene, one for its rays and one for its pixels.

    Returns arrays whose first axis has length n. In float64, or float32 where JAX is set to it.
    Raises ValueError for lengths that differ, for what a bench or a method refuses, naming the scene, for more
    memory than there is, and for `Splat`.

    """
    require_camera(camera)
    require_method(method)
    require_concrete("sweep", values, camera)
    if method is not None:
        method.require_parts("sweep")
        method.check_camera(camera)
    require_whole("batch", batch)
    require_mapping("values", values)
    if values is None:
        raise ValueError("values is None; allowed: a mapping from names of the bench's arguments")
    for name, function in (("bench", bench), ("reduce", reduce), ("progress", progress)):
        if not (callable(function) or (function is None and name != "bench")):
            raise ValueError(f"{name} is {shown(function)}; allowed: a function")
    if reduce is not None:
        _check_reduce(reduce, camera.shape)
    table = {name: _numbers(name, value) for name, value in values.items()}
    lengths = {name: len(value) for name, value in table.items() if value.ndim}
    if len(set(lengths.values())) != 1:
        lengths_text = f"have lengths {lengths}" if lengths else "are single numbers, or none"
        raise ValueError(f"values {lengths_text}; allowed: arrays of one length, and single numbers beside them")
    count = next(iter(lengths.values()))
    if not count:
        raise ValueError("values are empty; allowed: one scene or more")
    pixels = camera.shape[0] * camera.shape[1]
    batch = min(max(_PIXELS // pixels, 1) if batch is None else batch, count)
    images = f"{batch} of {count} images" if reduce else f"{count} images"
    advice = "allowed: a smaller batch or shape" if reduce else "allowed: fewer scenes, or reduce= for a part of each"
    require_memory(f"a sweep that holds {images}", pixels * (_BYTES * batch + (0 if reduce else 16 * count)), advice)
    rows = {name: np.broadcast_to(value, count) for name, value in table.items()}
    scenes = [(number, _named(rows, number, lambda row: bench(**row))) for number in range(count)]
    chosen = _for_all([scene for _, scene in scenes], camera, tolerance) if method is None else method
    for number, scene in scenes:
        _named(rows, number, lambda _, scene=scene: chosen.check(scene))
    done = (lambda _: None) if progress is None else lambda steps: progress(steps, 2 * count)
    pictures = []
    for number, scene in scenes:
        pictures.append(_named(rows, number, lambda _, scene=scene: chosen.picture(scene, camera)))
        done(number + 1)
    answers = type(pictures[0]).images(pictures, reduce, batch, lambda computed: done(count + computed))
    return answers if jax.config.read("jax_enable_x64") else jax.tree.map(_rounded, answers)


def _check_reduce(reduce: Callable[[Array], Any], shape: tuple[int, int]) -> None:
    """Raise ValueError for what JAX cannot trace; errors of other kinds are the function's own."""
    try:
        jax.eval_shape(reduce, jax.ShapeDtypeStruct(shape, jnp.result_type(float)))
    except TypeError as error:
        reason = str(error).partition("\n")[0].rstrip(".")[:200]
        raise ValueError(
            f"reduce is {shown(reduce)}; allowed: a function of jax.numpy from an image to arrays ({reason})"
        ) from error


def _numbers(name: str, value) -> np.ndarray:
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(
            f"values: {name} is {shown(value)}; allowed: numbers (give the bench what is none by functools.partial)"
        ) from None
    if numbers.ndim > 1:
        raise ValueError(f"values: {name} has shape {numbers.shape}; allowed: an array of one axis, or a number")
    return numbers


def _row(rows: dict[str, np.ndarray], number: int) -> dict[str, float]:
    return {name: float(value[number]) for name, value in rows.items()}


def _text(row: dict[str, float]) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in row.items())


def _spread(count: int) -> list[int]:
    return np.unique(np.linspace(0, count - 1, min(count, _PLANNED)).round().astype(int)).tolist()


def _named(rows, number: int, call: Callable[[dict[str, float]], Any]) -> Any:
    """What a call makes of the numbers of a scene; what it refuses is refused with these."""
    row = _row(rows, number)
    try:
        return call(row)
    except (TypeError, ValueError) as error:
        raise ValueError(f"scene {number} ({_text(row)}): {error}") from None


def _for_all(scenes: list[Scene], camera: Camera, tolerance: float) -> AbstractMethod:
    """The method that serves every scene's plan: the most general of them."""
    planned = [plan(scenes[number], camera, tolerance).method for number in _spread(len(scenes))]
    return max(planned, key=lambda method: method.generality).for_scenes(planned)


def _rounded(value):
    with x64():
        return value.astype(jnp.float32) if value.dtype == jnp.float64 else value
