"""What is known of the bench that rings were read on, and what the slope of their line gives of it."""

from dataclasses import dataclass

import numpy as np

from fitting.parameters import TABLE

# What a line of rings can measure.
MEASURED = ("radius", "wavelength", "pixel_size", "gap_index")


@dataclass(frozen=True)
class Bench:
    """What is known of the bench: wavelength, radius [m], the gap's index; None for what is not.

    The slope of r² against order, times the pixel size squared, is R λ / sqrt(n² - sin² θ). `contact`: its intercept in
    orders; `scale`: metres (or pixels) to a unit of the readings; `unit`: of the radii then.
    """

    wavelength: float | None
    radius: float | None
    gap_index: float | None
    view_angle: float
    contact: float
    scale: float
    unit: str

    @property
    def measured(self) -> str:
        """The quantity that the slope gives."""
        if self.wavelength is None:
            return "wavelength"
        if self.radius is None:
            return "radius"
        return "pixel_size" if self.gap_index is not None else "gap_index"

    @property
    def needs_scale(self) -> bool:
        """Whether readings in pixels leave the measured quantity open."""
        return self.unit == "px" and self.measured != "pixel_size"

    @property
    def in_unit(self) -> str:
        """What follows the measured quantity's values."""
        return TABLE[self.measured].in_unit

    def path(self, slope: float | None = None) -> float:
        """Optical path over thickness, halved: sqrt(n² - sin² θ); by the slope [m²] where the index is measured."""
        if self.gap_index is None:
            return (self.radius or 0.0) * (self.wavelength or 0.0) / (slope or 1.0)
        return float(np.sqrt(self.gap_index**2 - np.sin(self.view_angle) ** 2))

    def value(self, slope: float) -> float:
        """The measured quantity of a slope [m², or px² without a scale]."""
        match self.measured:
            case "pixel_size":
                square = (self.radius or 0.0) * (self.wavelength or 0.0) / (self.path() * slope)
                return float(np.sqrt(square)) if square > 0 else 0.0
            case "gap_index":
                return float(np.hypot(self.path(slope), np.sin(self.view_angle)))
            case _:
                return slope * self.path() / (self.wavelength or self.radius or 1.0)

    def power(self, slope: float) -> float:
        """By how many per cent the measured quantity changes with a per cent of the slope."""
        match self.measured:
            case "pixel_size":
                return -0.5
            case "gap_index":
                return -float((self.path(slope) / self.value(slope)) ** 2)
            case _:
                return 1.0

    def relative(self, sds: dict[str, float], slope: float) -> dict[str, float]:
        """Relative standard deviations of the measured quantity by those of what is given, by name.

        `sds`: in the units of what is given, 0 for what has none.
        """
        path = self.path(slope)
        of_slope = {
            "pixel_size": 2 * sds["pixel_size"] / self.scale,
            "wavelength": sds["wavelength"] / (self.wavelength or 1.0),
            "radius": sds["radius"] / (self.radius or 1.0),
            "view_angle": abs(np.sin(self.view_angle) * np.cos(self.view_angle)) / path**2 * sds["view_angle"],
            "gap_index": (self.gap_index or 0.0) / path**2 * sds["gap_index"],
        }
        return {name: abs(self.power(slope)) * float(sd) for name, sd in of_slope.items()}
