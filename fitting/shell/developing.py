"""What the verb `render` writes: an image over white, or a photograph of it."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import jax
import numpy as np

import newtonjax as nj
from fitting.parameters import png
from newtonjax.methods import Splatted, why_unpaired
from newtonjax.scene import window

_FILL = 0.8  # of the full well, by the brightest pixel, where no camera file says how long to expose

Blocks = Iterable[tuple[int, np.ndarray]]


def brightest(parts: Blocks, splatted: Splatted | None) -> float:
    """Of an image in blocks of rows, in its middle channel. Raises ValueError where it is dark everywhere."""
    peak = 0.0
    for _, part in parts:
        middle = part[..., part.shape[2] // 2] if part.ndim == 3 else part
        peak = max(peak, float(middle.max()))
    if not peak > 0 and splatted and splatted.unpaired.any():
        raise ValueError(f"the image is dark everywhere: {why_unpaired(splatted)}")
    if not peak > 0:
        raise ValueError("the image is dark everywhere: no beam reaches it; change the scene or the camera")
    return peak


def exposing(camera: nj.Camera, peak: float, from_file: bool) -> nj.Camera:
    """The camera as it exposes: as its file says, or so that the brightest pixel nearly fills its well."""
    return camera if from_file else replace(camera, exposure=_FILL * float(camera.full_well) / peak)


def has_own_codes(camera: nj.Camera) -> bool:
    """Whether its photographs are more than noise in one channel, over the full well."""
    colours = (camera.response, camera.mosaic)
    codes = (camera.jpeg, camera.black_level, camera.full_scale)
    has_more = any(part is not None for part in colours + codes)
    return has_more or camera.transfer != "linear"


def photograph(parts: Blocks, camera: nj.Camera, seed: int, bits: int) -> Any:
    """The codes of a whole photograph, of 8 or 16 bits: a mosaic and a JPEG know no blocks."""
    rows = [part for _, part in parts]
    image = rows[0] if len(rows) == 1 else np.concatenate(rows)
    return np.asarray(replace(camera, bits=bits).expose(image, jax.random.key(seed)))


def over_white(
    parts: Blocks, camera: nj.Camera, seed: int | None, peak: float, bits: int
) -> Iterator[tuple[int, np.ndarray]]:
    """Blocks of values to be coded, white being 1: the brightest pixel, or the full well of a photograph.

    Three channels have the file's curve.
    """
    if camera.response is not None:
        of_device = png.to_srgb if bits == 8 else np.asarray
        curve = nj.to_srgb if _is_the_eye(camera.response) else of_device
        return ((first, np.asarray(curve(part / peak))) for first, part in parts)
    if seed is None:
        return ((first, part / peak) for first, part in parts)
    key = jax.random.key(seed)

    def exposed(first: int, part: np.ndarray) -> np.ndarray:
        of_rows = replace(window(camera, first, len(part)), bits=16)
        own_key = jax.random.fold_in(key, first) if first else key
        return np.asarray(of_rows.expose(part, own_key)) / 65535

    return ((first, exposed(first, part)) for first, part in parts)


def _is_the_eye(response: nj.Response) -> bool:
    return np.array_equal(response.curves, nj.cie_1931().curves)


def noise_of(camera: nj.Camera, seed: int | None) -> str:
    """What noise there is, in words."""
    if seed is None:
        is_grey = camera.response is None
        return "none (add --expose for a photograph)" if is_grey else "none (colours)"
    return (
        f"shot noise at {float(camera.exposure):.4g} photoelectrons per incident irradiance, "
        f"read noise of {float(camera.read_noise):g}, seed {seed}"
    )
