"""What a table of rings returns: numbers with their standard deviations, the readings with their flags, a report."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from fitting.parameters import (
    AbstractResult,
    Origin,
    Parameter,
    common_from,
    parameters_from,
    rounded,
    with_sd,
)
from fitting.tables.ring import Ring


@dataclass(frozen=True, repr=False, eq=False)
class RingsResult(AbstractResult):
    """The outcome of `fitting.rings`. Lengths in metres; `None` is what the readings do not give.

    - `status`: "ok", "no-scale" (radii in pixels without a pixel size) or "refused"; `message`: the reason.
    - `measured`: "radius", or "wavelength" where the radius was given; the other of the two is None.
    - `radius`, `radius_sd` (total), `radius_interval` (95 %, Student), `radius_sd_noise` (of the readings).
    - `wavelength`, `wavelength_sd`, `wavelength_interval`: the same where it is measured.
    - `slope`, `slope_sd`: of r² against order [m²], or [px²] without a scale.
    - `order_offset`, `order_offset_sd`: orders by which the line misses the contact's.
    - `gap`: at the centre, known modulo half a wavelength in the gap.
    - `budget`: (source, standard deviation of what is measured); `rings`; `warnings`; `model`.
    - `parameters` by name: what was measured and what was given, with their standard deviations.
    """

    status: str
    message: str = ""
    measured: str = "radius"
    radius: float | None = None
    radius_sd: float | None = None
    radius_interval: tuple[float, float] | None = None
    radius_sd_noise: float | None = None
    wavelength: float | None = None
    wavelength_sd: float | None = None
    wavelength_interval: tuple[float, float] | None = None
    fringe_scale_per_px2: float | None = None
    slope: float | None = None
    slope_sd: float | None = None
    order_offset: float | None = None
    order_offset_sd: float | None = None
    gap: float | None = None
    budget: list[tuple[str, float]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    model: dict[str, str] = field(default_factory=dict)
    rings: list[Ring] = field(default_factory=list)
    unit: str = "m"
    seconds: float = 0.0
    parameters: dict[str, Parameter] = field(default_factory=dict)
    origin: Origin | None = None

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the shell: units in the keys, null for what is not determined."""
        unit = self.unit
        return {
            "status": self.status,
            "message": str(self.message),
            "measured": self.measured,
            "radius_m": self.radius,
            "radius_sd_m": self.radius_sd,
            "radius_interval_m": self.radius_interval and list(self.radius_interval),
            "radius_sd_noise_m": self.radius_sd_noise,
            "wavelength_m": self.wavelength,
            "wavelength_sd_m": self.wavelength_sd,
            "wavelength_interval_m": self.wavelength_interval and list(self.wavelength_interval),
            "fringe_scale_per_px2": self.fringe_scale_per_px2,
            f"slope_{unit}2": self.slope,
            f"slope_sd_{unit}2": self.slope_sd,
            "order_offset": self.order_offset,
            "order_offset_sd": self.order_offset_sd,
            "gap_m": self.gap,
            "budget": [{"source": source, "sd_m": sd} for source, sd in self.budget],
            "model": dict(self.model),
            "rings": [
                {"order": r.order, f"radius_{unit}": r.radius, f"residual_{unit}": r.residual, "flag": r.flag}
                for r in self.rings
            ],
            "parameters": {name: asdict(parameter) for name, parameter in self.parameters.items()},
            "seconds": self.seconds,
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "RingsResult":
        """The result that `to_dict` was called of."""
        unit = "m" if "slope_m2" in saved else "px"
        intervals = {name: saved.get(f"{name}_interval_m") for name in ("radius", "wavelength")}
        status, message, warnings, origin = common_from(saved)
        return cls(
            status,
            message,
            measured=saved.get("measured", "radius"),
            radius=saved["radius_m"],
            radius_sd=saved["radius_sd_m"],
            radius_interval=intervals["radius"] and tuple(intervals["radius"]),
            radius_sd_noise=saved["radius_sd_noise_m"],
            wavelength=saved.get("wavelength_m"),
            wavelength_sd=saved.get("wavelength_sd_m"),
            wavelength_interval=intervals["wavelength"] and tuple(intervals["wavelength"]),
            fringe_scale_per_px2=saved["fringe_scale_per_px2"],
            slope=saved[f"slope_{unit}2"],
            slope_sd=saved[f"slope_sd_{unit}2"],
            order_offset=saved["order_offset"],
            order_offset_sd=saved["order_offset_sd"],
            gap=saved["gap_m"],
            budget=[(row["source"], row["sd_m"]) for row in saved["budget"]],
            warnings=warnings,
            model=dict(saved["model"]),
            rings=[
                Ring(row["order"], row[f"radius_{unit}"], row[f"residual_{unit}"], row["flag"])
                for row in saved["rings"]
            ],
            unit=unit,
            seconds=saved["seconds"],
            parameters=parameters_from(saved),
            origin=origin,
        )

    def figure(self, ax=None) -> Any:
        """r² against order with the fitted line, and the residuals; the reason where there is no line.

        With `ax` the line alone is drawn into these axes. Raises ValueError with `ax` for a result without a line.
        """
        from fitting.tables import figure

        if not self.rings or self.slope is None:
            if ax is not None:
                raise ValueError(f"there is no line to draw: {self.status}: {self.message}")
            return self._reason_figure()
        if ax is not None:
            figure.draw_line(self.rings, self.unit, ax)
            return ax.figure
        value, value_sd, _ = self._answer()
        title = "" if value is None else f"{self.measured} {with_sd(value, value_sd, 'm')}"
        return figure.of_rings(self.rings, self.unit, title)

    def _answer(self) -> tuple[float | None, float | None, tuple[float, float] | None]:
        """What is measured: value, standard deviation, interval."""
        if self.measured == "wavelength":
            return self.wavelength, self.wavelength_sd, self.wavelength_interval
        return self.radius, self.radius_sd, self.radius_interval

    def report(self) -> str:
        """The result as text: the answer, its budget, the readings and what is wrong with them."""
        lines = [f"[[Result]]  {self.status}" + (f": {self.message}" if self.message else "")]
        value, value_sd, interval = self._answer()
        if value is not None:
            lines += [f"    {self.measured} = {with_sd(value, value_sd, 'm')}"]
        if interval is not None:
            low, high = (rounded(end, value_sd) for end in interval)
            lines += [f"    95 %: {low} to {high} m"]
        if self.slope is not None:
            lines += [f"    slope of r² against order = {with_sd(self.slope, self.slope_sd, self.unit + '²')}"]
        if self.order_offset is not None:
            lines += [f"    offset from contact = {with_sd(self.order_offset, self.order_offset_sd, 'orders')}"]
        if self.budget:
            lines += [f"[[Budget]]  standard deviations of the {self.measured} [m]"]
            lines += [f"    {source:<12} {sd:.3g}" for source, sd in self.budget]
        if self.rings:
            lines += [f"[[Rings]]  order, radius [{self.unit}], residual [{self.unit}]"]
            lines += [f"    {r.order:<6g} {r.radius:<12.6g} {r.residual:< 12.2g} {r.flag}".rstrip() for r in self.rings]
        if self.model:
            lines += ["[[Model]]"] + [f"    {part:<12} {why}" for part, why in self.model.items()]
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)
