"""What a photograph of a ruled grid says of the pixels."""

from dataclasses import dataclass, field

import numpy as np

from fitting.photo import Photograph
from fitting.reticle.grid import Grid


@dataclass(frozen=True)
class Scale:
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
    photograph: Photograph | None = field(default=None, repr=False)
    grid: Grid | None = field(default=None, repr=False)

    def as_dict(self) -> dict:
        """The JSON object of the shell, which `fit --scale-from` reads: units in the keys."""
        return {
            "status": self.status,
            "message": self.message,
            "pixel_size_m": self.pixel_size,
            "pixel_size_sd_m": self.pixel_size_sd,
            "pixel_size_x_m": self.pixel_size_x,
            "pixel_size_y_m": self.pixel_size_y,
            "angle_rad": self.angle,
            "skew_rad": self.skew,
            "distortion": self.distortion,
            "distortion_sd": self.distortion_sd,
            "lines": self.lines and list(self.lines),
            "division_m": self.division,
            "division_sd_m": self.division_sd,
            "warnings": list(self.warnings),
        }

    def report(self) -> str:
        """The scale as text."""
        lines = [f"[[Scale]]  {self.status}" + (f": {self.message}" if self.message else "")]
        if self.pixel_size is not None and self.lines is not None:
            lines += [
                f"    pixel size   {self.pixel_size:.6g} +/- {self.pixel_size_sd:.2g} m on the object",
                f"    along x, y   {self.pixel_size_x:.6g}, {self.pixel_size_y:.6g} m",
                f"    grid         turned by {np.degrees(self.angle or 0.0):.3g}°, "
                f"{np.degrees(self.skew or 0.0):.2g}° off a right angle",
                f"    distortion   {self.distortion:.2g}{_deviation(self.distortion_sd)} at the corners",
                f"    lines        {self.lines[0]:.0f} and {self.lines[1]:.0f} divisions of {self.division:.4g} m",
            ]
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)


def _deviation(sd: float | None) -> str:
    return "" if sd is None else f" +/- {sd:.1g}"
