"""What a photograph of a ruled grid says of the pixels."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from fitting.parameters import AbstractMeasurement, Origin, Parameter, common_from, with_sd
from fitting.photo import Photograph
from fitting.reticle.grid import Grid

# Attributes by their keys in JSON.
_KEYS = {
    "pixel_size_m": "pixel_size",
    "pixel_size_sd_m": "pixel_size_sd",
    "pixel_size_x_m": "pixel_size_x",
    "pixel_size_y_m": "pixel_size_y",
    "pixel_size_x_sd_m": "pixel_size_x_sd",
    "pixel_size_y_sd_m": "pixel_size_y_sd",
    "stretch": "stretch",
    "stretch_sd": "stretch_sd",
    "shear": "shear",
    "shear_sd": "shear_sd",
    "angle_rad": "angle",
    "skew_rad": "skew",
    "distortion": "distortion",
    "distortion_sd": "distortion_sd",
    "half_diagonal_px": "half_diagonal",
    "division_m": "division",
    "division_sd_m": "division_sd",
    "diameter_m": "diameter",
    "diameter_sd_m": "diameter_sd",
}
# Units of its parameters.
_UNITS = {
    "pixel_size": "m", "pixel_size_x": "m", "pixel_size_y": "m", "stretch": "", "shear": "", "angle": "rad",
    "skew": "rad", "distortion": "", "division": "m", "diameter": "m",
}  # fmt: skip
# What files of earlier versions do not have.
_LATER = (
    *("pixel_size_x_sd", "pixel_size_y_sd", "stretch", "stretch_sd", "shear", "shear_sd", "half_diagonal"),
    *("diameter", "diameter_sd"),
)


@dataclass(frozen=True, repr=False, eq=False)
class Scale(AbstractMeasurement):
    """What a photograph of a grid, a ruler or a disc says of the pixels, in metres on the object.

    - `status`: "ok", or "refused" with a `message`.
    - `pixel_size`: geometric mean of both axes in the middle of the image, with `pixel_size_sd` (its scatter over the
      field, the division's own, and half of the stretch where noise does not explain that); `pixel_size_x`,
      `pixel_size_y` along the image's axes, with `pixel_size_x_sd`, `pixel_size_y_sd`.
    - `stretch` a and `shear` b of the pixels, as the fit's oblique view has them: offsets on the object are
      exp([[a, b], [b, -a]] / 2) times those of square pixels, a = ln(pixel_size_x / pixel_size_y) without a skew;
      `stretch_sd`, `shear_sd`.
    - `angle` of the grid against the image, `skew` of its two directions from a right angle [rad].
    - `distortion`: κ of r (1 + κ r²), r in half diagonals from the middle, as in the fit; `distortion_sd`;
      `half_diagonal` of the image from the middle of its corner pixels [px].
    - `lines` [2]: how many were seen along either direction; `division` or `diameter` and its deviation as given.
    - `marks` [mark, point, (x, y)]: lines of a ruler, or the edge of a disc, as measured, in pixels.
    """

    status: str
    message: str = ""
    pixel_size: float | None = None
    pixel_size_sd: float | None = None
    pixel_size_x: float | None = None
    pixel_size_y: float | None = None
    pixel_size_x_sd: float | None = None
    pixel_size_y_sd: float | None = None
    stretch: float | None = None
    shear: float | None = None
    stretch_sd: float | None = None
    shear_sd: float | None = None
    angle: float | None = None
    skew: float | None = None
    distortion: float | None = None
    distortion_sd: float | None = None
    half_diagonal: float | None = None
    lines: tuple[float, float] | None = None
    division: float | None = None
    division_sd: float | None = None
    diameter: float | None = None
    diameter_sd: float | None = None
    warnings: list[str] = field(default_factory=list)
    photograph: Photograph | None = None
    grid: Grid | None = None
    marks: np.ndarray | None = None
    origin: Origin | None = None

    @property
    def parameters(self) -> dict[str, Parameter]:
        """What was measured and given, by name, with units and standard deviations; empty for a refusal."""
        rows = {name: (unit, getattr(self, name), getattr(self, f"{name}_sd", None)) for name, unit in _UNITS.items()}
        return {
            name: Parameter(value, sd, name in ("division", "diameter"), name, unit)
            for name, (unit, value, sd) in rows.items()
            if value is not None
        }

    @property
    def budget(self) -> list[tuple[str, float]]:
        """Source and standard deviation of the pixel size [m]: what was given, and the picture; empty for a refusal."""
        if self.pixel_size is None or not self.pixel_size_sd:
            return []
        total, sizes = self.pixel_size_sd, (("division", self.division), ("diameter", self.diameter))
        rows = [
            (name, self.pixel_size * sd / size) for name, size in sizes if size and (sd := getattr(self, f"{name}_sd"))
        ]
        stated = sum(sd**2 for _, sd in rows)
        source = "picture" if self.division or self.diameter else "two points and their distance"
        return [*rows, (source, float(np.sqrt(max(total**2 - stated, 0.0))))]

    @property
    def model(self) -> dict[str, str]:
        """What was taken for measured; empty for a refusal."""
        if self.pixel_size is None:
            return {}
        if self.diameter is not None:
            return {"disc": "an ellipse with a blurred edge"}
        if self.lines is None:
            return {"points": "two places and their distance; pixels taken for square"}
        if not self.lines[1]:
            return {"ruler": f"{self.lines[0]:.0f} divisions one way, with a distortion; pixels taken for square"}
        return {"grid": f"{self.lines[0]:.0f} and {self.lines[1]:.0f} divisions, with stretch, shear and a distortion"}

    def headline(self) -> str:
        """The pixel size in one line, or why there is none."""
        if self.status != "ok" or self.pixel_size is None:
            return super().headline()
        return f"pixel size = {with_sd(self.pixel_size, self.pixel_size_sd, 'm')} on the object"

    def budgets(self) -> dict[str, list[tuple[str, float]]]:
        """The budget of the pixel size."""
        return {"pixel size [m]": self.budget} if self.budget else {}

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the shell, which `fit --scale-from` reads: units in the keys."""
        numbers = {key: getattr(self, name) for key, name in _KEYS.items()}
        return {
            "status": self.status,
            "message": str(self.message),
            **numbers,
            "lines": self.lines and list(self.lines),
            "parameters": {name: asdict(parameter) for name, parameter in self.parameters.items()},
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "Scale":
        """The scale that `to_dict` was called of."""
        lines = saved["lines"]
        status, message, warnings, origin = common_from(saved)
        fields: dict[str, Any] = {name: saved[key] for key, name in _KEYS.items() if name not in _LATER}
        later: dict[str, Any] = {name: saved.get(key) for key, name in _KEYS.items() if name in _LATER}
        return cls(
            status,
            message,
            **fields,
            **later,
            lines=lines and (lines[0], lines[1]),
            warnings=warnings,
            origin=origin,
        )

    def figure(self, ax=None) -> Any:
        """The photograph with the measured lines, or two points by themselves; with `ax` drawn into these axes.

        Raises ValueError where there are none, as in a loaded result.
        """
        from fitting.reticle import figure

        if self.photograph is None and self.marks is not None:
            return figure.of_points(self.marks[0], self.headline(), ax)
        if self.photograph is None or (self.grid is None and self.marks is None):
            raise ValueError(f"there are no lines to draw ({self.status}); a loaded result has no photograph")
        title = f"pixel size {with_sd(self.pixel_size or 0.0, self.pixel_size_sd, 'm')}, the lines as measured"
        measured = self.marks if self.grid is None else self.grid
        if ax is None:
            return figure.of_lines(self.photograph, measured, title)
        figure.draw(self.photograph, measured, title, ax)
        return ax.figure

    def report(self) -> str:
        """The scale as text."""
        lines = [f"[[Scale]]  {self.status}" + (f": {self.message}" if self.message else "")]
        if self.pixel_size is not None and self.lines is None:
            lines.append(f"    pixel size   {with_sd(self.pixel_size, self.pixel_size_sd, 'm')} on the object")
        elif self.pixel_size is not None and self.lines is not None and not self.lines[1]:
            lines += [
                f"    pixel size   {with_sd(self.pixel_size, self.pixel_size_sd, 'm')} on the object",
                f"    distortion   {with_sd(self.distortion or 0.0, self.distortion_sd)} of u (1 + κ u²)",
                f"    lines        {self.lines[0]:.0f} divisions of {self.division:.4g} m",
            ]
        elif self.pixel_size is not None and self.lines is not None:
            unit = f"u in half diagonals of {self.half_diagonal or 0.0:.5g} px"
            sides = (self.pixel_size_x, self.pixel_size_x_sd), (self.pixel_size_y, self.pixel_size_y_sd)
            along = ", ".join(with_sd(size or 0.0, sd, "m") for size, sd in sides)
            lines += [
                f"    pixel size   {with_sd(self.pixel_size, self.pixel_size_sd, 'm')} on the object",
                f"    along x, y   {along}",
                f"    grid         turned by {np.degrees(self.angle or 0.0):.3g}°, "
                f"{np.degrees(self.skew or 0.0):.2g}° off a right angle",
                f"    distortion   {with_sd(self.distortion or 0.0, self.distortion_sd)} of u (1 + κ u²), {unit}",
                f"    lines        {self.lines[0]:.0f} and {self.lines[1]:.0f} divisions of {self.division:.4g} m",
            ]
        if self.diameter is not None:
            lines.append(f"    disc         {self.diameter:.5g} m across")
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)
