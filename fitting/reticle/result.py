"""What a photograph of a ruled grid says of the pixels."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fitting.parameters import AbstractResult, Origin, origin_from, rounded, with_sd
from fitting.photo import Photograph
from fitting.reticle.grid import Grid

# Attributes by their keys in JSON.
_KEYS = {
    "status": "status",
    "message": "message",
    "pixel_size_m": "pixel_size",
    "pixel_size_sd_m": "pixel_size_sd",
    "pixel_size_x_m": "pixel_size_x",
    "pixel_size_y_m": "pixel_size_y",
    "angle_rad": "angle",
    "skew_rad": "skew",
    "distortion": "distortion",
    "distortion_sd": "distortion_sd",
    "division_m": "division",
    "division_sd_m": "division_sd",
}


@dataclass(frozen=True, repr=False, eq=False)
class Scale(AbstractResult):
    """What a photograph of a ruled grid says of the pixels, in metres on the object.

    - `status`: "ok", or "refused" with a `message`.
    - `pixel_size`: geometric mean of both axes in the middle of the image, with `pixel_size_sd` (its scatter over the
      field, and the division's own); `pixel_size_x`, `pixel_size_y` along the image's axes.
    - `angle` of the grid against the image, `skew` of its two directions from a right angle [rad].
    - `distortion`: κ of r (1 + κ r²), r in half diagonals from the middle, as in the fit; `distortion_sd`.
    - `lines` [2]: how many were seen along either direction; `division` and its deviation as given.
    """

    status: str
    message: str = ""
    pixel_size: float | None = None
    pixel_size_sd: float | None = None
    pixel_size_x: float | None = None
    pixel_size_y: float | None = None
    angle: float | None = None
    skew: float | None = None
    distortion: float | None = None
    distortion_sd: float | None = None
    lines: tuple[float, float] | None = None
    division: float | None = None
    division_sd: float | None = None
    warnings: list[str] = field(default_factory=list)
    photograph: Photograph | None = None
    grid: Grid | None = None
    origin: Origin | None = None

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the shell, which `fit --scale-from` reads: units in the keys."""
        numbers = {key: getattr(self, name) for key, name in _KEYS.items()}
        return {
            **numbers,
            "lines": self.lines and list(self.lines),
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "Scale":
        """The scale that `to_dict` was called of."""
        lines = saved["lines"]
        return cls(
            **{name: saved[key] for key, name in _KEYS.items()},
            lines=lines and (lines[0], lines[1]),
            warnings=list(saved["warnings"]),
            origin=origin_from(saved),
        )

    def figure(self, ax=None) -> Any:
        """The photograph with the measured lines; with `ax` drawn into these axes.

        Raises ValueError where there are none, as in a loaded result.
        """
        from fitting.reticle import figure

        if self.photograph is None or self.grid is None:
            raise ValueError(f"there are no lines to draw ({self.status}); a loaded result has no photograph")
        title = f"pixel size {with_sd(self.pixel_size or 0.0, self.pixel_size_sd, 'm')}, the lines as measured"
        if ax is None:
            return figure.of_grid(self.photograph, self.grid, title)
        figure.draw_lines(self.photograph, self.grid, title, ax)
        return ax.figure

    def report(self) -> str:
        """The scale as text."""
        lines = [f"[[Scale]]  {self.status}" + (f": {self.message}" if self.message else "")]
        if self.pixel_size is not None and self.lines is not None:
            sizes = self.pixel_size_x or 0.0, self.pixel_size_y or 0.0
            along = ", ".join(rounded(size, self.pixel_size_sd) for size in sizes)
            lines += [
                f"    pixel size   {with_sd(self.pixel_size, self.pixel_size_sd, 'm')} on the object",
                f"    along x, y   {along} m",
                f"    grid         turned by {np.degrees(self.angle or 0.0):.3g}°, "
                f"{np.degrees(self.skew or 0.0):.2g}° off a right angle",
                f"    distortion   {with_sd(self.distortion or 0.0, self.distortion_sd)} at the corners",
                f"    lines        {self.lines[0]:.0f} and {self.lines[1]:.0f} divisions of {self.division:.4g} m",
            ]
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)
