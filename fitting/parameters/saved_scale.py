"""What a measured scale says of the camera, for another photograph: pixel size, distortion and sides of the pixels."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fitting.parameters.fringe_scale import number
from fitting.parameters.result import AbstractResult
from fitting.reasons import Reason
from newtonjax.numerics import shown

_WAYS = ("stretch", "shear")
# Half diagonals of one camera's pictures agree to this [px], whatever the rounding.
_SAME_SIZE = 0.6


@dataclass(frozen=True)
class CameraScale:
    """The scale that `fitting.scale` measured, or `fitting.fit` by a lens of known radius: that one is a size alone.

    - `pixel_size`, `pixel_size_sd` [m].
    - `distortion`: κ and its standard deviation, None where it was not measured; u (1 + κ |u|²), u in `half_diagonal`s
      from the middle of the grid's picture [px], None where the file does not say.
    - `stretches` [a and b] of the pixels and their variances.
    """

    pixel_size: float
    pixel_size_sd: float
    distortion: tuple[float, float] | None
    half_diagonal: float | None
    stretches: np.ndarray
    variances: np.ndarray

    def prior_distortion(self, shape: tuple[int, ...]) -> tuple[float, float] | None:
        """κ and its standard deviation in half diagonals of a picture [rows, columns] of the same pixels."""
        if self.distortion is None:
            return None
        scale = 1.0 if self.half_diagonal is None else (_half_diagonal(shape) / self.half_diagonal) ** 2
        return self.distortion[0] * scale, self.distortion[1] * scale

    def size_warning(self, shape: tuple[int, ...]) -> list[str]:
        """That a picture [rows, columns] is of another size than the grid's; a larger one is no cut of that."""
        half_diagonal = _half_diagonal(shape)
        if self.half_diagonal is None or abs(half_diagonal - self.half_diagonal) < _SAME_SIZE:
            return []
        if half_diagonal > self.half_diagonal:
            return [Reason.LARGER_THAN_GRID()]
        return [Reason.PICTURE_OF_OTHER_SIZE(picture=half_diagonal, grid=self.half_diagonal)]


def _half_diagonal(shape: tuple[int, ...]) -> float:
    return float(np.hypot(shape[0] - 1, shape[1] - 1) / 2)


def camera_scale(scale: Any) -> CameraScale:
    """The scale of a result of `fitting.scale`, or of a fit that measured the pixel size, or in the JSON file of one.

    Raises FileNotFoundError, and ValueError for what holds no pixel size.
    """
    if isinstance(scale, AbstractResult):
        return _from_json(scale.to_dict(), f"a {type(scale).__name__} of status {scale.status!r}")
    if not isinstance(scale, str | Path):
        raise ValueError(f"scale is {shown(scale)}; allowed: a result of fitting.scale, or the path of its JSON")
    path = Path(scale)
    if not path.is_file():
        raise FileNotFoundError(f"{path} is not a file; give the JSON that `newtonjax scale` wrote")
    try:
        saved = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path} is no JSON; give what `newtonjax scale` wrote") from error
    return _from_json(saved, str(path))


def _from_json(saved: Any, name: str) -> CameraScale:
    try:
        size, sd = (number(key, saved[key]) for key in ("pixel_size_m", "pixel_size_sd_m"))
        half_diagonal, distortion = saved.get("half_diagonal_px"), saved.get("distortion")
        distortion_sd = saved.get("distortion_sd")
        measured = None if not distortion_sd else (number("distortion", distortion), number("its sd", distortion_sd))
        return CameraScale(*_with_sides(saved, size, sd), measured, half_diagonal, *_stretches(saved, size, sd))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(saved, Mapping) and saved.get("status") == "refused":
            why = saved.get("message") or "no reason is given"
            raise ValueError(f"{name} holds no pixel_size_m: the scale was refused ({why})") from error
        way = "make it by `newtonjax scale`, or by `newtonjax fit --radius` of a lens of known radius"
        text = f"{name} holds no pixel_size_m with pixel_size_sd_m; {way}"
        raise ValueError(text) from error


def _with_sides(saved: Mapping[str, Any], size: float, sd: float) -> tuple[float, float]:
    """The pixel size and its deviation, which in files of earlier versions lacks half of the sides' difference."""
    stretch = _stretches(saved, size, sd)[0][0]
    return size, sd if saved.get("stretch") is not None else float(np.hypot(sd, size * stretch / 2))


def _stretches(saved: Mapping[str, Any], size: float, sd: float) -> tuple[np.ndarray, np.ndarray]:
    """Stretch and shear with their variances; of earlier versions' files from the sides, whose deviations are as sd.

    These say nothing of the shear. A lens of known radius says of neither what is the camera's and what its own.
    """
    if saved.get("kind") == "FitResult":
        return np.zeros(2), np.ones(2)
    if saved.get("stretch") is not None:
        values, sds = ([number(way + end, saved[way + end]) for way in _WAYS] for end in ("", "_sd"))
        return np.array(values), np.square(sds)
    sides = [number(key, saved.get(key) or size) for key in ("pixel_size_x_m", "pixel_size_y_m")]
    return np.array([np.log(sides[0] / sides[1]), 0.0]), np.array([2 * (sd / size) ** 2, 1.0])
