"""What a table of rings returns: numbers with their standard deviations, the readings with their flags, a report."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Ring:
    """One reading: radius and residual [m], or [px] without a scale; `flag` says what is wrong with it, or is ""."""

    order: float
    radius: float
    residual: float
    flag: str


@dataclass(frozen=True)
class RingsResult:
    """The outcome of `fitting.rings`. Lengths in metres; `None` is what the readings do not give.

    - `status`: "ok", "no-scale" (radii in pixels without a pixel size) or "refused"; `message`: the reason.
    - `radius`, `radius_sd` (total), `radius_interval` (95 %, Student), `radius_sd_noise` (of the readings).
    - `slope`, `slope_sd`: of r² against order [m²], or [px²] without a scale.
    - `order_offset`, `order_offset_sd`: orders by which the line misses the contact's.
    - `gap`: at the centre, known modulo half a wavelength in the gap.
    - `budget`: (source, standard deviation of the radius); `rings`; `warnings`; `model`.
    """

    status: str
    message: str = ""
    radius: float | None = None
    radius_sd: float | None = None
    radius_interval: tuple[float, float] | None = None
    radius_sd_noise: float | None = None
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

    def as_dict(self) -> dict:
        """The JSON object of the shell: units in the keys, null for what is not known."""
        unit = self.unit
        return {
            "status": self.status,
            "message": self.message,
            "radius_m": self.radius,
            "radius_sd_m": self.radius_sd,
            "radius_interval_m": self.radius_interval and list(self.radius_interval),
            "radius_sd_noise_m": self.radius_sd_noise,
            "fringe_scale_per_px2": self.fringe_scale_per_px2,
            f"slope_{unit}2": self.slope,
            f"slope_sd_{unit}2": self.slope_sd,
            "order_offset": self.order_offset,
            "order_offset_sd": self.order_offset_sd,
            "gap_m": self.gap,
            "budget": [{"source": source, "sd_m": sd} for source, sd in self.budget],
            "warnings": list(self.warnings),
            "model": dict(self.model),
            "rings": [
                {"order": r.order, f"radius_{unit}": r.radius, f"residual_{unit}": r.residual, "flag": r.flag}
                for r in self.rings
            ],
            "seconds": self.seconds,
        }

    def report(self) -> str:
        """The result as text: the answer, its budget, the readings and what is wrong with them."""
        lines = [f"[[Result]]  {self.status}" + (f": {self.message}" if self.message else "")]
        if self.radius is not None:
            sd = "" if self.radius_sd is None else f" +/- {self.radius_sd:.2g}"
            lines += [f"    radius = {self.radius:.6g}{sd} m"]
        if self.radius_interval is not None:
            lines += [f"    95 %: {self.radius_interval[0]:.6g} to {self.radius_interval[1]:.6g} m"]
        if self.slope is not None:
            sd = "" if self.slope_sd is None else f" +/- {self.slope_sd:.2g}"
            lines += [f"    slope of r² against order = {self.slope:.6g}{sd} {self.unit}²"]
        if self.order_offset is not None:
            sd = "" if self.order_offset_sd is None else f" +/- {self.order_offset_sd:.2g}"
            lines += [f"    offset from contact = {self.order_offset:.3g}{sd} orders"]
        if self.budget:
            lines += ["[[Budget]]  standard deviations of the radius [m]"]
            lines += [f"    {source:<12} {sd:.3g}" for source, sd in self.budget]
        if self.rings:
            lines += [f"[[Rings]]  order, radius [{self.unit}], residual [{self.unit}]"]
            lines += [f"    {r.order:<6g} {r.radius:<12.6g} {r.residual:< 12.2g} {r.flag}".rstrip() for r in self.rings]
        if self.model:
            lines += ["[[Model]]"] + [f"    {part:<12} {why}" for part, why in self.model.items()]
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)
