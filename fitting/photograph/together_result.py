"""What a fit of several photographs returns: each picture's number, their ratios, and what the pictures share."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from fitting.parameters import TABLE, AbstractMeasurement, Origin, Parameter, common_from, interval, with_sd, with_unit
from fitting.photograph.result import FitResult
from fitting.photograph.shared_gap import SharedGap


class PictureRow(NamedTuple):
    """One picture: its number together with all others and alone, and its ratio to the first, in which errors cancel.

    `contradiction`: by how many standard deviations it disagrees with the others in what they share; None for nothing
    shared.
    """

    name: str
    value: float
    sd: float
    alone: float
    alone_sd: float
    ratio: float
    ratio_sd: float | None
    contradiction: float | None


@dataclass(frozen=True, repr=False, eq=False)
class Together(AbstractMeasurement):
    """The outcome of `fitting.fit_together` and `fitting.ratio`, in SI units.

    - `status`: "ok", "no-scale" (ratios alone), or "refused" where fewer than two pictures can be used.
    - `measured`: "radius" or another quantity, "fringe_scale" without a scale; `members`: a row of each picture. Ratios
      are then those of the radii, as far as wavelength and index are given.
    - `value`, `sd`, `interval` (95 %): of the one quantity where the pictures share it, else None.
    - `ratio`, `ratio_sd`, `ratio_interval`: of the second picture's radius, or other quantity, over the first's.
    - `budget`: (source, standard deviation) of `value`, or of `ratio` where none is shared.
    - `shared`: the camera's numbers, by name (value, standard deviation), in half diagonals of the first picture.
    - `covariance`: of the logarithms of the members' values; `fits`: the pictures' single fits.
    - `gap` [m]: at the centre of one lens in several wavelengths, with its orders; None where it is not shared.
    """

    status: str
    message: str = ""
    measured: str = "radius"
    value: float | None = None
    sd: float | None = None
    ratio: float | None = None
    ratio_sd: float | None = None
    budget: list[tuple[str, float]] = field(default_factory=list)
    members: list[PictureRow] = field(default_factory=list)
    shared: dict[str, tuple[float, float]] = field(default_factory=dict)
    covariance: np.ndarray | None = None
    warnings: list[str] = field(default_factory=list)
    fits: list[FitResult] = field(default_factory=list)
    origin: Origin | None = None
    gap: SharedGap | None = None

    @property
    def interval(self) -> tuple[float, float] | None:
        """95 % of the quantity that the pictures share, None without one."""
        return interval(self.value, self.sd) if self.value and self.sd else None

    @property
    def ratio_interval(self) -> tuple[float, float] | None:
        """95 % of the ratio of the second picture to the first."""
        return interval(self.ratio, self.ratio_sd) if self.ratio and self.ratio_sd else None

    @property
    def parameters(self) -> dict[str, Parameter]:
        """The number of all, the ratio, each picture's number, and the camera's; empty for a refusal."""
        unit = TABLE[self.measured].unit
        rows = {self.measured: (self.value, self.sd, unit), "ratio": (self.ratio, self.ratio_sd, "")}
        rows |= {f"{self.measured} of {row.name}": (row.value, row.sd, unit) for row in self.members}
        rows |= {f"ratio of {row.name}": (row.ratio, row.ratio_sd, "") for row in self.members[1:]}
        rows |= {f"{name}, shared": (value, sd, "") for name, (value, sd) in self.shared.items()}
        rows |= {} if self.gap is None else {"gap": (self.gap.value, self.gap.sd, "m")}
        return {
            name: Parameter(value, sd, False, name, unit)
            for name, (value, sd, unit) in rows.items()
            if value is not None
        }

    @property
    def model(self) -> dict[str, str]:
        """The parts of each picture's own fit, and why."""
        names = [member.name for member in self.members]
        fits = dict(zip(names, self.fits, strict=False)) if len(names) == len(self.fits) else {}
        return {f"{part}, {name}": why for name, fit in fits.items() for part, why in fit.model.items()}

    def headline(self) -> str:
        """The number of all, else the ratio, in one line, or why there is none."""
        if self.status != "refused" and self.value is not None:
            return f"{self._name()} of all = {with_sd(self.value, self.sd, TABLE[self.measured].unit)}"
        if self.status != "refused" and self.ratio is not None:
            return f"ratio, second over first = {with_sd(self.ratio, self.ratio_sd)}"
        return super().headline()

    def budgets(self) -> dict[str, list[tuple[str, float]]]:
        """The budget of the number of all, or of the ratio."""
        of_all = with_unit(self._name(), TABLE[self.measured].unit)
        budgets = {"ratio" if self.value is None else of_all: self.budget} if self.budget else {}
        return budgets | ({"gap [m]": self.gap.budget} if self.gap is not None and self.gap.budget else {})

    def _name(self) -> str:
        return self.measured.replace("_", " ")

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the shell: units in the keys, null for what is not determined."""
        spec = TABLE[self.measured]
        return {
            "status": self.status,
            "message": str(self.message),
            "measured": self.measured,
            spec.key(): self.value,
            spec.key("sd"): self.sd,
            spec.key("interval"): self.interval and list(self.interval),
            "ratio": self.ratio,
            "ratio_sd": self.ratio_sd,
            "ratio_interval": self.ratio_interval and list(self.ratio_interval),
            "budget": [{"source": source, "sd": sd} for source, sd in self.budget],
            "members": [member._asdict() for member in self.members],
            "shared": {name: {"value": value, "sd": sd} for name, (value, sd) in self.shared.items()},
            "covariance_of_logarithms": None if self.covariance is None else self.covariance.tolist(),
            "gap": self.gap and self.gap.to_dict(),
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "Together":
        """The result that `to_dict` was called of, without the single fits."""
        spec = TABLE[saved["measured"]]
        status, message, warnings, origin = common_from(saved)
        covariance = saved["covariance_of_logarithms"]
        return cls(
            status,
            message,
            saved["measured"],
            saved[spec.key()],
            saved[spec.key("sd")],
            saved["ratio"],
            saved["ratio_sd"],
            [(row["source"], row["sd"]) for row in saved["budget"]],
            [PictureRow(**row) for row in saved["members"]],
            {name: (row["value"], row["sd"]) for name, row in saved["shared"].items()},
            None if covariance is None else np.array(covariance, float),
            warnings,
            origin=origin,
            gap=SharedGap.from_dict(saved["gap"]) if saved.get("gap") else None,
        )

    def figure(self, ax=None) -> Any:
        """Each picture's number with its standard deviation, together and alone; with `ax` drawn into these axes."""
        if ax is None:
            if not self.members:
                return self._reason_figure()
            from matplotlib.figure import Figure

            ax = Figure(figsize=(7, 1.5 + 0.4 * len(self.members)), layout="constrained").subplots()
        for place, member in enumerate(self.members):
            ax.errorbar(member.alone, 0.12 - place, xerr=member.alone_sd, fmt="o", ms=4, color="0.6")
            ax.errorbar(member.value, -place - 0.12, xerr=member.sd, fmt="o", ms=4, color="tab:red")
        ax.set_yticks([-place for place in range(len(self.members))], [member.name for member in self.members])
        unit = _unit_of(self.measured)
        ax.set_xlabel(f"{self.measured.replace('_', ' ')}{f' [{unit}]' if unit else ''}, grey: alone, red: together")
        return ax.figure

    def report(self) -> str:
        """The result as text."""
        name, unit = self.measured.replace("_", " "), _unit_of(self.measured)
        lines = [f"[[Result]]  {self.status}" + (f": {self.message}" if self.message else "")]
        if self.value is not None:
            lines += [f"    {name} of all = {with_sd(self.value, self.sd, unit)}"]
        if self.ratio is not None:
            lines += [f"    ratio, second over first = {with_sd(self.ratio, self.ratio_sd)}"]
        lines += [] if self.gap is None else self.gap.report_lines()
        if self.budget:
            of = name if self.value is not None else "ratio"
            lines += [f"[[Budget]]  standard deviations of the {of}"]
            lines += [f"    {source:<24} {sd:.2g}" for source, sd in self.budget]
        if self.members:
            lines += [f"[[Pictures]]  {name} together; alone; over the first"]
        for member in self.members:
            pair = with_sd(member.value, member.sd, unit), with_sd(member.alone, member.alone_sd, unit)
            ratio = with_sd(member.ratio, member.ratio_sd) if member.ratio_sd else "1"
            lines.append(f"    {member.name:<24} {pair[0]:<26} {pair[1]:<26} {ratio}")
        if self.shared:
            lines += ["[[Camera]]  shared by all pictures, in half diagonals"]
            lines += [f"    {number} = {with_sd(*pair)}" for number, pair in self.shared.items()]
        return "\n".join(
            lines + (["[[Warnings]]"] + [f"    {text}" for text in self.warnings] if self.warnings else [])
        )


def _unit_of(name: str) -> str:
    """The unit of a quantity as a reader writes it."""
    return TABLE[name].unit.replace("per_px2", "per px²")
