"""What positions of straight fringes return: the angle of a wedge, and its thickness, with standard deviations."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from fitting.parameters import AbstractMeasurement, Origin, Parameter, between, common_from, with_sd

# Numbers of the result, by the unit in their keys.
_UNITS = {"spacing": "m", "wedge_angle": "rad", "thickness": "m"}


class Fringe(NamedTuple):
    """One reading: its order, position and residual [m], and what is wrong with it, or ""."""

    order: float
    position: float
    residual: float
    flag: str


@dataclass(frozen=True, repr=False, eq=False)
class WedgeResult(AbstractMeasurement):
    """The outcome of `fitting.wedge`. Lengths in metres, the angle in radians; `None` is what is not determined.

    - `status`: "ok", or "refused" with a `message`.
    - `spacing` of the fringes; `wedge_angle`; `thickness` at the end of the length that was given, None without; each
      with its standard deviation `..._sd` and 95 % interval `..._interval`.
    - `budget`: (source, relative standard deviation of the angle); `fringes`; `warnings`; `model`.
    """

    status: str
    message: str = ""
    spacing: float | None = None
    spacing_sd: float | None = None
    wedge_angle: float | None = None
    wedge_angle_sd: float | None = None
    wedge_angle_interval: tuple[float, float] | None = None
    thickness: float | None = None
    thickness_sd: float | None = None
    thickness_interval: tuple[float, float] | None = None
    budget: list[tuple[str, float]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    model: dict[str, str] = field(default_factory=dict)
    fringes: list[Fringe] = field(default_factory=list)
    origin: Origin | None = None

    @property
    def parameters(self) -> dict[str, Parameter]:
        """What was measured, by name; empty for a refusal."""
        rows = {name: (getattr(self, name), getattr(self, f"{name}_sd"), unit) for name, unit in _UNITS.items()}
        return {
            name: Parameter(value, sd, False, name, unit)
            for name, (value, sd, unit) in rows.items()
            if value is not None
        }

    def headline(self) -> str:
        """The thickness, or else the angle, in one line, or why there is none."""
        name = "wedge_angle" if self.thickness is None else "thickness"
        value, sd = getattr(self, name), getattr(self, f"{name}_sd")
        if self.status != "ok" or value is None:
            return super().headline()
        return f"{name.replace('_', ' ')} = {with_sd(value, sd, _UNITS[name])}"

    def budgets(self) -> dict[str, list[tuple[str, float]]]:
        """The budget of the angle, relative to it; of a thickness with a row for the length."""
        if not self.budget or self.thickness is None or self.wedge_angle is None:
            return {"wedge angle, relative": self.budget} if self.budget else {}
        total = (self.thickness_sd or 0.0) / self.thickness
        of_angle = (self.wedge_angle_sd or 0.0) / self.wedge_angle
        of_length = max(total**2 - of_angle**2, 0.0) ** 0.5
        return {"thickness, relative": [*self.budget, ("length", of_length)]}

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the shell: units in the keys, null for what is not determined."""
        numbers: dict[str, Any] = {}
        for name, unit in _UNITS.items():
            numbers |= {f"{name}_{unit}": getattr(self, name), f"{name}_sd_{unit}": getattr(self, f"{name}_sd")}
            if name != "spacing":
                ends = getattr(self, f"{name}_interval")
                numbers[f"{name}_interval_{unit}"] = ends and list(ends)
        return {
            "status": self.status,
            "message": self.message,
            **numbers,
            "budget": [{"source": source, "relative_sd": sd} for source, sd in self.budget],
            "model": dict(self.model),
            "fringes": [
                {"order": f.order, "position_m": f.position, "residual_m": f.residual, "flag": f.flag}
                for f in self.fringes
            ],
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "WedgeResult":
        """The result that `to_dict` was called of."""
        status, message, warnings, origin = common_from(saved)
        numbers: dict[str, Any] = {}
        for name, unit in _UNITS.items():
            numbers |= {name: saved[f"{name}_{unit}"], f"{name}_sd": saved[f"{name}_sd_{unit}"]}
            if name != "spacing":
                ends = saved[f"{name}_interval_{unit}"]
                numbers[f"{name}_interval"] = ends and tuple(ends)
        return cls(
            status,
            message,
            **numbers,
            budget=[(row["source"], row["relative_sd"]) for row in saved["budget"]],
            warnings=warnings,
            model=dict(saved["model"]),
            fringes=[
                Fringe(row["order"], row["position_m"], row["residual_m"], row["flag"]) for row in saved["fringes"]
            ],
            origin=origin,
        )

    def figure(self, ax=None) -> Any:
        """Position against order with the line; the reason where there is none.

        Raises ValueError with `ax` for a result without a line.
        """
        if not self.fringes or self.wedge_angle is None:
            if ax is not None:
                raise ValueError(f"there is no line to draw: {self.status}: {self.message}")
            return self._reason_figure()
        if ax is None:
            from matplotlib.figure import Figure

            ax = Figure(figsize=(7, 4.2), layout="constrained").subplots()
        order = [fringe.order for fringe in self.fringes]
        ax.plot(order, [1e3 * fringe.position for fringe in self.fringes], "o", ms=4, color="0.3", label="readings")
        line = [1e3 * (fringe.position - fringe.residual) for fringe in self.fringes]
        ax.plot(order, line, color="tab:red", lw=1, label="line")
        ax.set(xlabel="order", ylabel="position [mm]", title=with_sd(self.wedge_angle, self.wedge_angle_sd, "rad"))
        ax.legend()
        return ax.figure

    def report(self) -> str:
        """The result as text: the answer, its budget, the readings and what is wrong with them."""
        lines = [f"[[Result]]  {self.status}" + (f": {self.message}" if self.message else "")]
        for name, unit in _UNITS.items():
            value, sd = getattr(self, name), getattr(self, f"{name}_sd")
            if value is None:
                continue
            text = f"    {name.replace('_', ' ')} = {with_sd(value, sd, unit)}"
            if (ends := getattr(self, f"{name}_interval", None)) is not None:
                text += f" (95 %: {between(ends, sd, unit)})"
            lines.append(text)
        if self.budget:
            lines += ["[[Budget]]  relative standard deviations of the wedge angle"]
            lines += [f"    {source:<12} {sd:.2g}" for source, sd in self.budget]
        if self.fringes:
            lines += ["[[Fringes]]  order, position [m], residual [m]"]
            lines += [
                f"    {f.order:<6g} {f.position:<12.6g} {f.residual:< 12.2g} {f.flag}".rstrip() for f in self.fringes
            ]
        if self.model:
            lines += ["[[Model]]"] + [f"    {part:<12} {why}" for part, why in self.model.items()]
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)
