"""What `tradeoff` returns: time, memory and errors of every method, as text, JSON and picture."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from fitting.parameters import AbstractResult, Origin, common_from


@dataclass(frozen=True)
class MethodTiming:
    """Time and errors of one method for a scene.

    - `name`: of the method; `tolerance`: for which it was planned, None for none.
    - `seconds`: of one image, compiled; `bytes`: of the image, and of what `render` makes in NumPy on the way.
    - `phase_error`: largest [turns]; `intensity_error`: largest over the peak; `predicted`: the plan's estimate of it.
    - `radius_bias`: relative, of a fit with this method as the model to the reference's image; None without a phase or
      a curved face.
    - `note`: why something is missing, or what the method ignores.
    """

    name: str
    seconds: float | None
    bytes: int | None
    phase_error: float | None
    intensity_error: float | None
    predicted: float | None
    radius_bias: float | None
    tolerance: float | None = None
    note: str = ""


@dataclass(frozen=True, repr=False, eq=False)
class Tradeoff(AbstractResult):
    """Every method for a scene, the fastest first, methods without a time last.

    - `timings`: by method; "Traced" is the reference.
    - `shape`, `pixel_size` [m]: of the camera.
    """

    timings: tuple[MethodTiming, ...]
    shape: tuple[int, int]
    pixel_size: float
    status: str = "ok"
    message: str = ""
    warnings: list[str] = field(default_factory=list)
    origin: Origin | None = None

    def figure(self, ax=None) -> Any:
        """Time against error of intensity and against the bias of the radius, as a matplotlib figure.

        With `ax` the error of intensity alone.
        """
        from fitting.studies.tradeoff_figure import of_timings

        return of_timings(self.timings, ax)

    def to_dict(self) -> dict[str, Any]:
        """The result for JSON: units in the keys; None for what a method does not have."""
        return {
            "status": self.status,
            "message": str(self.message),
            "shape": list(self.shape),
            "pixel_size_m": self.pixel_size,
            "timings": [asdict(timing) for timing in self.timings],
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "Tradeoff":
        """The result that `to_dict` was called of."""
        rows, columns = saved["shape"]
        return cls(
            tuple(MethodTiming(**timing) for timing in saved["timings"]),
            (rows, columns),
            saved["pixel_size_m"],
            *common_from(saved),
        )

    def report(self) -> str:
        """A table; "chosen for" is the loosest tolerance at which `plan` takes the method."""
        names = "method", "chosen for", "time", "memory", "phase", "intensity", "radius bias"
        units = "", "up to", "ms", "MB", "turns", "of peak", "ppm"
        lines = ["{:<14} {:>10} {:>9} {:>8} {:>9} {:>9} {:>12}".format(*head).rstrip() for head in (names, units)]
        for timing in self.timings:
            bias = None if timing.radius_bias is None else timing.radius_bias * 1e6
            lines.append(
                f"{timing.name:<14} {_short(timing.tolerance):>10} {_short(timing.seconds, 1e3):>9} "
                f"{_short(timing.bytes, 1e-6):>8} {_short(timing.phase_error):>9} "
                f"{_short(timing.intensity_error):>9} {_short(bias):>12}  {timing.note}".rstrip()
            )
        return "\n".join(lines)


def _short(value: float | int | None, factor: float = 1.0) -> str:
    return "" if value is None else f"{value * factor:.2g}"
