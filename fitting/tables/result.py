"""What a table of rings returns: numbers with their standard deviations, the readings with their flags, a report."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from fitting.parameters import (
    TABLE,
    AbstractMeasurement,
    Origin,
    Parameter,
    between,
    common_from,
    length_unit,
    parameters_from,
    with_sd,
    with_unit,
)
from fitting.tables.bench import MEASURED
from fitting.tables.ring import Ring


@dataclass(frozen=True, repr=False, eq=False)
class RingsResult(AbstractMeasurement):
    """The outcome of `fitting.rings`. Lengths in metres; `None` is what the readings do not give.

    - `status`: "ok", "no-scale" (radii in pixels without a pixel size) or "refused"; `message`: the reason.
    - `measured`: "radius", "wavelength" where the radius was given, "pixel_size" or "gap_index" where both were; what
      is not measured is None.
    - `radius`, `radius_sd` (total), `radius_interval` (95 %, Student), `radius_sd_noise` (of the readings).
    - `wavelength`, `pixel_size`, `gap_index`, each with `..._sd` and `..._interval`: the same where they are measured.
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
    pixel_size: float | None = None
    pixel_size_sd: float | None = None
    pixel_size_interval: tuple[float, float] | None = None
    gap_index: float | None = None
    gap_index_sd: float | None = None
    gap_index_interval: tuple[float, float] | None = None
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
        unit, numbers = self.unit, {}
        for name in MEASURED:
            ends = getattr(self, f"{name}_interval")
            key = TABLE[name].key
            numbers |= {key(): getattr(self, name), key("sd"): getattr(self, f"{name}_sd")}
            numbers[key("interval")] = ends and list(ends)
        sd_key = TABLE[self.measured].sd_key
        return {
            "status": self.status,
            "message": str(self.message),
            "measured": self.measured,
            **numbers,
            "radius_sd_noise_m": self.radius_sd_noise,
            "fringe_scale_per_px2": self.fringe_scale_per_px2,
            f"slope_{unit}2": self.slope,
            f"slope_sd_{unit}2": self.slope_sd,
            "order_offset": self.order_offset,
            "order_offset_sd": self.order_offset_sd,
            "gap_m": self.gap,
            "budget": [{"source": source, sd_key: sd} for source, sd in self.budget],
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
        numbers = {}
        for name in MEASURED:
            key = TABLE[name].key
            ends = saved.get(key("interval"))
            numbers |= {name: saved.get(key()), f"{name}_sd": saved.get(key("sd"))}
            numbers[f"{name}_interval"] = ends and tuple(ends)
        status, message, warnings, origin = common_from(saved)
        return cls(
            status,
            message,
            measured=saved.get("measured", "radius"),
            **numbers,
            radius_sd_noise=saved["radius_sd_noise_m"],
            fringe_scale_per_px2=saved["fringe_scale_per_px2"],
            slope=saved[f"slope_{unit}2"],
            slope_sd=saved[f"slope_sd_{unit}2"],
            order_offset=saved["order_offset"],
            order_offset_sd=saved["order_offset_sd"],
            gap=saved["gap_m"],
            budget=[(row["source"], row.get("sd_m", row.get("sd"))) for row in saved["budget"]],
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
        title = "" if value is None else f"{self._name()} {with_sd(value, value_sd, TABLE[self.measured].unit)}"
        return figure.of_rings(self.rings, self.unit, title)

    def headline(self) -> str:
        """The answer in one line, or why there is none."""
        value, sd, _ = self._answer()
        if self.status != "ok" or value is None:
            return super().headline()
        return f"{self._name()} = {with_sd(value, sd, TABLE[self.measured].unit)}"

    def budgets(self) -> dict[str, list[tuple[str, float]]]:
        """The budget of what is measured."""
        return {with_unit(self._name(), TABLE[self.measured].unit): self.budget} if self.budget else {}

    def _answer(self) -> tuple[float | None, float | None, tuple[float, float] | None]:
        """What is measured: value, standard deviation, interval."""
        return tuple(getattr(self, f"{self.measured}{part}") for part in ("", "_sd", "_interval"))  # pyright: ignore

    def _name(self) -> str:
        return self.measured.replace("_", " ")

    def report(self) -> str:
        """The result as text: the answer, its budget, the readings and what is wrong with them."""
        lines = [f"[[Result]]  {self.status}" + (f": {self.message}" if self.message else "")]
        value, value_sd, interval = self._answer()
        unit = TABLE[self.measured].unit
        if value is not None:
            lines += [f"    {self._name()} = {with_sd(value, value_sd, unit)}"]
        if interval is not None:
            lines += [f"    95 %: {between(interval, value_sd, unit)}"]
        if self.slope is not None:
            lines += [f"    slope of r² against order = {with_sd(self.slope, self.slope_sd, self.unit + '²')}"]
        if self.order_offset is not None:
            lines += [f"    offset from contact = {with_sd(self.order_offset, self.order_offset_sd, 'orders')}"]
        if self.budget:
            factor, unit = length_unit(value, unit=unit)
            lines += [f"[[Budget]]  standard deviations of the {self._name()} [{unit or 1}]"]
            lines += [f"    {source:<12} {sd * factor:.3g}" for source, sd in self.budget]
        if self.rings:
            lines += [f"[[Rings]]  order, radius [{self.unit}], residual [{self.unit}]"]
            lines += [f"    {r.order:<6g} {r.radius:<12.6g} {r.residual:< 12.2g} {r.flag}".rstrip() for r in self.rings]
        if self.model:
            lines += ["[[Model]]"] + [f"    {part:<12} {why}" for part, why in self.model.items()]
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)
