"""What a comparison of several results returns: one value with its budget, and each result beside the first."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from fitting.parameters import TABLE, AbstractMeasurement, Origin, Parameter, between, common_from, with_sd, with_unit


class Compared(NamedTuple):
    """One result: its name, value and sd, and its ratio to the first one with an sd of what does not cancel in it."""

    name: str
    value: float
    sd: float | None
    ratio: float
    ratio_sd: float | None


@dataclass(frozen=True, repr=False, eq=False)
class Comparison(AbstractMeasurement):
    """The outcome of `fitting.compare`, in SI units.

    - `of`: the quantity; `value`, `sd`, `interval` (95 %); `budget`: (source, standard deviation of the value).
    - `rows`: each result; of an index the ratios are those of the slopes in air to the ones in the liquid.
    """

    status: str
    message: str
    of: str
    value: float
    sd: float
    interval: tuple[float, float]
    budget: list[tuple[str, float]]
    rows: list[Compared]
    warnings: list[str] = field(default_factory=list)
    origin: Origin | None = None

    @property
    def parameters(self) -> dict[str, Parameter]:
        """The quantity, and the same of each result by its name."""
        unit = TABLE[self.of].unit
        rows = [(self.of, self.value, self.sd)]
        rows += [(f"{self.of} of {row.name}", row.value, row.sd) for row in self.rows]
        return {name: Parameter(value, sd, False, name, unit) for name, value, sd in rows}

    @property
    def model(self) -> dict[str, str]:
        """How the results are put together."""
        return {"ratios": "over the first result; what all share cancels in them"}

    def headline(self) -> str:
        """The answer in one line."""
        return f"{self.of.replace('_', ' ')} = {with_sd(self.value, self.sd, TABLE[self.of].unit)}"

    def budgets(self) -> dict[str, list[tuple[str, float]]]:
        """The budget of the quantity."""
        return {with_unit(self.of.replace("_", " "), TABLE[self.of].unit): self.budget}

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the shell: units in the keys."""
        spec = TABLE[self.of]
        return {
            "status": self.status,
            "message": str(self.message),
            "of": self.of,
            spec.key(): self.value,
            spec.key("sd"): self.sd,
            spec.key("interval"): list(self.interval),
            "budget": [{"source": source, spec.sd_key: sd} for source, sd in self.budget],
            "results": [row._asdict() for row in self.rows],
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "Comparison":
        """The comparison that `to_dict` was called of."""
        spec = TABLE[saved["of"]]
        status, message, warnings, origin = common_from(saved)
        low, high = saved[spec.key("interval")]
        return cls(
            status,
            message,
            saved["of"],
            saved[spec.key()],
            saved[spec.key("sd")],
            (low, high),
            [(row["source"], row[spec.sd_key]) for row in saved["budget"]],
            [Compared(**row) for row in saved["results"]],
            warnings,
            origin,
        )

    def figure(self, ax=None) -> Any:
        """Each result with its standard deviation, and the value with its own; with `ax` drawn into these axes."""
        if ax is None:
            from matplotlib.figure import Figure

            ax = Figure(figsize=(7, 1.5 + 0.35 * len(self.rows)), layout="constrained").subplots()
        for place, row in enumerate(self.rows):
            ax.errorbar(row.value, -place, xerr=row.sd or 0.0, fmt="o", ms=4, color="0.3")
        ax.axvline(self.value, color="tab:red", lw=1)
        ax.axvspan(self.value - self.sd, self.value + self.sd, color="tab:red", alpha=0.15)
        ax.set_yticks([-place for place in range(len(self.rows))], [row.name for row in self.rows])
        ax.set_xlabel(f"{self.of.replace('_', ' ')} {f'[{TABLE[self.of].unit}]' if TABLE[self.of].unit else ''}")
        return ax.figure

    def report(self) -> str:
        """The comparison as text."""
        unit, name = TABLE[self.of].unit, self.of.replace("_", " ")
        lines = [
            f"[[Result]]  {self.status}",
            f"    {name} = {with_sd(self.value, self.sd, unit)}",
            f"    95 %: {between(self.interval, self.sd, unit)}",
            f"[[Budget]]  standard deviations of the {name} [{unit or 1}]",
            *(f"    {source:<12} {sd:.3g}" for source, sd in self.budget),
            f"[[Results]]  {name}, and over the first one (what they share cancels)",
        ]
        for row in self.rows:
            value = with_sd(row.value, row.sd, unit) if row.sd else with_sd(row.value, None, unit)
            lines.append(f"    {row.name:<24} {value:<28} {with_sd(row.ratio, row.ratio_sd) if row.ratio_sd else '1'}")
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)
