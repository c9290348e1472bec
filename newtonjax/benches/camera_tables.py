"""The lens of a camera and the response of its channels, as a table and as words of a TOML file."""

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from newtonjax.scene import CameraLens, Response, cie_1931

_NUMBERS, _VECTORS = ("distortion", "fifth_order", "principal_distance_px", "vignette"), ("axis_px", "tilt")
LENS = msgspec.defstruct(
    "CameraLens",
    [
        *((name, float | None, None) for name in _NUMBERS),
        *((name, tuple[float, float] | None, None) for name in _VECTORS),
        ("magnifications", tuple[float, ...] | None, None),
    ],
    forbid_unknown_fields=True,
    omit_defaults=True,
)


def lens_of(table: Any) -> CameraLens | None:
    """The lens in a table. Raises ValueError for one that does not exist."""
    return None if table is None else CameraLens(**msgspec.structs.asdict(table))


def table_of_lens(lens: CameraLens, plain: Callable[[Any], Any]) -> Any:
    """`lens_of` the other way; `plain` makes Python's own numbers."""
    return LENS(**{name: plain(getattr(lens, name)) for name in LENS.__struct_fields__})


def words_of_response(response: Response) -> str:
    """The words that `camera_response` takes. Raises ValueError for curves that have no name."""
    if not (response.white == 1 and np.array_equal(response.curves, cie_1931().curves)):
        raise ValueError("camera.response of other curves; allowed in a file that is written: cie_1931(), or None")
    return "cie_1931"
