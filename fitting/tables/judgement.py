"""From readings to an answer: the line, what contradicts it, the budget, and the interval."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from fitting.parameters import TABLE
from fitting.reasons import Reason
from fitting.tables import words
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


@dataclass(frozen=True)
class Bench:
    """What is known of the bench: wavelength or radius [m], path over thickness, the contact's intercept in orders.

    `scale`: metres (or pixels) to a unit of the readings; `unit`: of the radii then.
    """

    wavelength: float | None
    radius: float | None
    path: float
    contact: float
    scale: float
    unit: str

    @property
    def measured(self) -> str:
        """The quantity that the slope gives."""
        return "wavelength" if self.wavelength is None else "radius"

    def value(self, slope: float) -> float:
        """The measured quantity [m] of a slope [m²]."""
        return slope * self.path / (self.wavelength or self.radius or 1.0)


class Judgement:
    """The outcome of a table, with the warnings and the lines of the model that it collects on the way.

    `relative`: relative standard deviations of what is given, by name; `expected`: a rough radius [m].
    """

    def __init__(self, read: Readings, bench: Bench, relative: dict[str, float], expected: float | None) -> None:
        self.read, self.bench, self.relative, self.expected = read, bench, relative, expected
        self.warnings: list[Statement] = []
        self.model: dict[str, str] = {}
        self.radius = read.radius * bench.scale
        self.sd = None if read.sd is None else read.sd * bench.scale
        self.rounding = read.rounding * bench.scale
        self.series = series_in(read.order, read.radius, read.series, read.series_names)

    def outcome(self) -> Outcome:
        """Status, message and the values of the result by name."""
        if (count := len(np.unique(self.read.order))) < 2:
            return "refused", Reason.ONE_RING(count=count, measured=self.bench.measured), {}
        if self.series is not None and (mixed := mixed_sizes(self._flat(), self.series, self.read.column)):
            return "refused", Reason.MIXED_SERIES(series=mixed), {}
        bench, fitted = self.bench, self._line()
        if fitted is None:
            return "refused", Reason.RINGS_BEYOND_LENS(), {}
        line, sample = fitted
        if line.mixture is not None:
            readings = line.mixture.words()
            if bench.unit != "m":
                return "refused", Reason.MIXED_SIZES(mixture=readings), {}
            value = bench.value(line.mixture.slope)
            return "refused", Reason.MIXED_SIZES_SET_RIGHT(mixture=readings, measured=bench.measured, value=value), {}
        # Equal readings leave the rounding of their squares.
        if line.slope * np.ptp(line.order[line.used]) <= 1e-9 * sample.ordinate.max():
            return "refused", Reason.NOT_GROWING(), {}
        values = self._of_line(line, sample)
        metres = None if bench.unit == "px" else bench.value
        self.warnings += words.of_line(line, sample, words.Quantity(bench.measured, metres, line.slope))
        if line.scatter.is_rounding:
            self.warnings.append(Reason.ONLY_ROUNDING(column=self.read.column, division=self.read.division))
        law = None if line.bend else law_through_contact(line.fair, self.radius[line.used], bench.contact)
        self.warnings += words.of_offset(values["order_offset"], values["order_offset_sd"], bench.measured, law)
        if line.bend is not None and line.bend.forbids:
            return "refused", Reason.NO_LINE(bend=line.bend.words(), measured=bench.measured), values
        if bench.unit == "px":
            return "no-scale", Reason.NO_PIXEL_SIZE(), values | {"fringe_scale_per_px2": 1 / line.slope}
        return self._answer(line, values)

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
        if bench.unit == "px":
            return ring_line(flat, bench.contact, number), flat
        if bench.wavelength is not None:
            return line_on_sphere(flat, bench.contact, bench.path / bench.wavelength, number)
        if radius.max() > (bench.radius or 0.0):
            return None
        sample = Sample(order, radius, on_sphere(radius, bench.radius or 1.0), self.sd, self.rounding)
        return ring_line(sample, bench.contact, number), sample

    def _of_line(self, line: Line, sample: Sample) -> dict[str, Any]:
        bench = self.bench
        offset = line.intercept / line.slope - bench.contact
        wavelength = bench.wavelength or (None if bench.unit == "px" else bench.value(line.slope))
        residual = line.residual(sample.ordinate) / (2 * self.radius)
        rows = zip(self.read.order, self.radius, residual, line.flags, strict=True)
        return {
            "slope": line.slope,
            "slope_sd": line.slope_sd,
            "order_offset": offset,
            "order_offset_sd": line.sd_of(-line.intercept / line.slope**2, 1.0 / line.slope),
            "gap": None if wavelength is None else -(offset - round(offset)) * wavelength / (2 * bench.path),
            "rings": [Ring(float(m), float(r), float(deviation), flag) for m, r, deviation, flag in rows],
        }

    def _answer(self, line: Line, values: dict[str, Any]) -> Outcome:
        """The measured quantity with its budget and interval; refused where the interval reaches zero."""
        name = self.bench.measured
        value = self.bench.value(line.slope)
        low, high = TABLE[name].bounds
        doubted = doubts(name, value, self.expected, self.read.column, self.read.length_unit)
        if not low <= value <= high:
            reason = Reason.BEYOND_BOUNDS(measured=name, value=value, low=low, high=high)
            if doubted:
                reason = Reason.DOUBTED_BEYOND_BOUNDS(doubt=doubted[0], low=low, high=high)
            return "refused", reason, values
        self.warnings += doubted
        if line.slope_sd is None:
            self.warnings.append(Reason.TWO_READINGS())
            return "ok", "", values | {name: value}
        spread = self._series_spread(line)
        relative = {"reading": line.slope_sd / line.slope}
        freedoms = {"reading": line.scatter.freedom}
        if line.bend is not None:
            # Where along the bend the lens is, nobody knows: half of the change counts as one standard deviation.
            relative["curvature"] = abs(line.bend.change) / 2
        if spread is not None:
            relative["series"], freedoms["series"] = spread.sd / line.slope, spread.freedom
        budget = [
            (row, value * float(sd)) for row, sd in {**relative, **self.relative}.items() if sd or row in freedoms
        ]
        total, half = _total(budget, freedoms)
        if half >= value:
            suspects = [text for text in self.warnings if text.code == Reason.LIKELY_MISREAD.name]
            return "refused", words.undetermined(name, value, total, value + half, suspects), values
        return "ok", "", values | {
            name: value,
            f"{name}_sd": total,
            f"{name}_interval": (value - half, value + half),
            "radius_sd_noise": budget[0][1],
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
        self.model["series"] = f"{len(names)}, {origin}; {self.bench.measured} [m] of each, {', '.join(values)}"
        if spread.is_beyond_chance:
            self.warnings.append(Reason.SERIES_DIFFER(values=", ".join(values)))
        return spread


def _total(budget: list[tuple[str, float]], freedoms: dict[str, float]) -> tuple[float, float]:
    """Standard deviation of all rows, and half of the 95 % interval.

    Student's t for the effective degrees of freedom of Welch and Satterthwaite (GUM, G.4); rows without are exact.
    """
    total = float(np.sqrt(sum(sd**2 for _, sd in budget)))
    uncertain = sum(sd**4 / freedoms[row] for row, sd in budget if row in freedoms)
    effective = total**4 / uncertain if uncertain > 0 else np.inf
    return total, total * float(stats.norm.ppf(0.975) if np.isinf(effective) else stats.t.ppf(0.975, effective))
