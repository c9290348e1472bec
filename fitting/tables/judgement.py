"""From readings to an answer: the line, what contradicts it, the budget, and the interval."""

from typing import Any

import numpy as np
from scipy import stats

from fitting.parameters import TABLE
from fitting.reasons import Reason
from fitting.tables import words
from fitting.tables.bench import Bench
from fitting.tables.bend import law_through_contact
from fitting.tables.doubts import doubts
from fitting.tables.line import Line, ring_line
from fitting.tables.ring import Ring
from fitting.tables.sample import Sample
from fitting.tables.series import SeriesSpread, are_counted_apart, mixed_sizes, series_in, series_spread
from fitting.tables.sphere import line_on_sphere, on_sphere
from fitting.tables.table import Readings
from newtonjax.numerics import Statement

Outcome = tuple[str, str, dict[str, Any]]


class Judgement:
    """The outcome of a table, with the warnings and the lines of the model that it collects on the way.

    `sds`: standard deviations of what is given, by name; `expected`: a rough radius [m].
    """

    def __init__(self, read: Readings, bench: Bench, sds: dict[str, float], expected: float | None) -> None:
        self.read, self.bench, self.sds, self.expected = read, bench, sds, expected
        self.warnings: list[Statement] = []
        self.model: dict[str, str] = {}
        self.radius = read.radius * bench.scale
        self.sd = None if read.sd is None else read.sd * bench.scale
        self.rounding = read.rounding * bench.scale
        self.series = series_in(read.order, read.radius, read.series, read.series_names)

    def outcome(self) -> Outcome:
        """Status, message and the values of the result by name."""
        if (count := len(np.unique(self.read.order))) < 2:
            return "refused", Reason.ONE_RING(count=count, measured=self.name), {}
        if self.series is not None and (mixed := mixed_sizes(self._flat(), self.series, self.read.column)):
            return "refused", Reason.MIXED_SERIES(series=mixed), {}
        bench, fitted = self.bench, self._line()
        if fitted is None:
            return "refused", Reason.RINGS_BEYOND_LENS(), {}
        line, sample = fitted
        if line.mixture is not None:
            readings = line.mixture.words()
            if bench.needs_scale:
                return "refused", Reason.MIXED_SIZES(mixture=readings), {}
            value = f"{bench.value(line.mixture.slope):.4g}{bench.in_unit}"
            return "refused", Reason.MIXED_SIZES_SET_RIGHT(mixture=readings, measured=self.name, value=value), {}
        # Equal readings leave the rounding of their squares.
        if line.slope * np.ptp(line.order[line.used]) <= 1e-9 * sample.ordinate.max():
            return "refused", Reason.NOT_GROWING(), {}
        values = self._of_line(line, sample)
        value_of = None if bench.needs_scale else bench.value
        quantity = words.Quantity(self.name, value_of, line.slope, bench.power(line.slope), bench.in_unit)
        self.warnings += words.of_line(line, sample, quantity)
        if line.scatter.is_rounding:
            self.warnings.append(Reason.ONLY_ROUNDING(column=self.read.column, division=self.read.division))
        law = None if line.bend else law_through_contact(line.fair, self.radius[line.used], bench.contact)
        self.warnings += words.of_offset(values["order_offset"], values["order_offset_sd"], self.name, law)
        if line.bend is not None and line.bend.forbids:
            return "refused", Reason.NO_LINE(bend=line.bend.words(), measured=self.name), values
        if bench.needs_scale:
            return "no-scale", Reason.NO_PIXEL_SIZE(), values | {"fringe_scale_per_px2": 1 / line.slope}
        return self._answer(line, values)

    @property
    def name(self) -> str:
        """The measured quantity in words."""
        return self.bench.measured.replace("_", " ")

    def _in_brackets(self) -> str:
        return f" [{self.bench.in_unit.strip()}]" if self.bench.in_unit else ""

    def _flat(self) -> Sample:
        """The readings with r² for ordinate."""
        return Sample(self.read.order, self.radius, self.radius**2, self.sd, self.rounding)

    def _line(self) -> tuple[Line, Sample] | None:
        """The line on the sphere whose radius is known or measured; in pixels without a scale that of r²."""
        order, radius, bench, flat = self.read.order, self.radius, self.bench, self._flat()
        apart = self.series is not None and are_counted_apart(flat, self.series)
        number = self.series.number if self.series and apart else None
        if apart:
            self.warnings.append(Reason.OWN_INTERCEPTS())
        if bench.needs_scale:
            return ring_line(flat, bench.contact, number), flat
        if bench.radius is None:
            return line_on_sphere(flat, bench.contact, bench.path() / (bench.wavelength or 1.0), number)
        line, sample, lens = ring_line(flat, bench.contact, number), flat, bench.radius
        # In pixels the lens's radius is known as soon as their size is: a second look is as exact as the readings.
        for _ in range(1 if bench.unit == "m" else 2):
            if bench.unit == "px":
                if line.slope <= 0:
                    return line, sample
                lens = bench.radius / bench.value(line.slope)
            if radius.max() > lens:
                return None
            sample = Sample(order, radius, on_sphere(radius, lens), self.sd, self.rounding)
            line = ring_line(sample, bench.contact, number)
        return line, sample

    def _of_line(self, line: Line, sample: Sample) -> dict[str, Any]:
        bench = self.bench
        offset = line.intercept / line.slope - bench.contact
        wavelength = bench.wavelength or (None if bench.needs_scale else bench.value(line.slope))
        residual = line.residual(sample.ordinate) / (2 * self.radius)
        rows = zip(self.read.order, self.radius, residual, line.flags, strict=True)
        return {
            "slope": line.slope,
            "slope_sd": line.slope_sd,
            "order_offset": offset,
            "order_offset_sd": line.sd_of(-line.intercept / line.slope**2, 1.0 / line.slope),
            "gap": None
            if wavelength is None
            else -(offset - round(offset)) * wavelength / (2 * bench.path(line.slope)),
            "rings": [Ring(float(m), float(r), float(deviation), flag) for m, r, deviation, flag in rows],
        }

    def _answer(self, line: Line, values: dict[str, Any]) -> Outcome:
        """The measured quantity with its budget and interval; refused where the interval reaches zero."""
        name = self.bench.measured
        value = self.bench.value(line.slope)
        low, high = TABLE[name].bounds
        doubted = doubts(name, value, self.expected, self.read.column, self.read.length_unit)
        if not low <= value <= high:
            unit = self.bench.in_unit
            reason = Reason.BEYOND_BOUNDS(measured=self.name, value=value, low=low, high=high, unit=unit)
            if doubted:
                reason = Reason.DOUBTED_BEYOND_BOUNDS(doubt=doubted[0], low=low, high=high, unit=unit)
            return "refused", reason, values
        self.warnings += doubted
        if line.slope_sd is None:
            self.warnings.append(Reason.TWO_READINGS())
            return "ok", "", values | {name: value}
        spread = self._series_spread(line)
        power = abs(self.bench.power(line.slope))
        relative = {"reading": power * line.slope_sd / line.slope}
        freedoms = {"reading": line.scatter.freedom}
        if line.bend is not None:
            # Where along the bend the lens is, nobody knows: half of the change counts as one standard deviation.
            relative["curvature"] = power * abs(line.bend.change) / 2
        if spread is not None:
            relative["series"], freedoms["series"] = power * spread.sd / line.slope, spread.freedom
        budget = [
            (row, value * float(sd))
            for row, sd in {**relative, **self.bench.relative(self.sds, line.slope)}.items()
            if sd or row in freedoms
        ]
        total, half = _total(budget, freedoms)
        if half >= value:
            suspects = [text for text in self.warnings if text.code == Reason.LIKELY_MISREAD.name]
            return (
                "refused",
                words.undetermined(self.name, value, total, value + half, suspects, self.bench.in_unit),
                values,
            )
        return "ok", "", values | {
            name: value,
            f"{name}_sd": total,
            f"{name}_interval": (value - half, value + half),
            **({"radius_sd_noise": budget[0][1]} if name in ("radius", "wavelength") else {}),
            "budget": budget,
        }  # fmt: skip

    def _series_spread(self, line: Line) -> SeriesSpread | None:
        """What the series' own slopes add; said in the model, and in a warning where they differ."""
        if self.series is None:
            return None
        number, names = self.series.number[line.used], self.series.names
        spread = series_spread(line.regression, number, line.scatter.variance, line.scatter.common > 0)
        if spread is None:
            return None
        origin = "by their column" if self.series.by_column else "each beginning anew at the first rings"
        values = [f"{name}: {self.bench.value(slope):.5g}" for name, slope in zip(names, spread.slopes, strict=True)]
        self.model["series"] = f"{len(names)}, {origin}; {self.name}{self._in_brackets()} of each, {', '.join(values)}"
        if spread.is_beyond_chance:
            self.warnings.append(Reason.SERIES_DIFFER(values=", ".join(values) + self.bench.in_unit))
        return spread


def _total(budget: list[tuple[str, float]], freedoms: dict[str, float]) -> tuple[float, float]:
    """Standard deviation of all rows, and half of the 95 % interval.

    Student's t for the effective degrees of freedom of Welch and Satterthwaite (GUM, G.4); rows without are exact.
    """
    total = float(np.sqrt(sum(sd**2 for _, sd in budget)))
    uncertain = sum(sd**4 / freedoms[row] for row, sd in budget if row in freedoms)
    effective = total**4 / uncertain if uncertain > 0 else np.inf
    return total, total * float(stats.norm.ppf(0.975) if np.isinf(effective) else stats.t.ppf(0.975, effective))
