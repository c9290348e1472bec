"""What is said of a line: readings left out, miscounts, bends, scatter that is not as stated."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from fitting.parameters import with_sd
from fitting.tables.breaks import Break
from fitting.tables.line import Line
from fitting.tables.mixture import single_sizes
from fitting.tables.regression import regression
from fitting.tables.sample import Sample

# Offsets from the contact order that are larger than this are reported [orders].
_OFFSET = 0.3
# Orders that one line lists at most.
_LISTED = 8


@dataclass(frozen=True)
class Quantity:
    """What the slope gives: its name, its value [m] of a slope, None where pixels have no scale; the line's slope.

    Without a scale, text says what is the same in any unit: a share of the value.
    """

    name: str
    metres: Callable[[float], float] | None
    slope: float

    def of(self, slope: float) -> str:
        """The value that another slope gives: "1.234 m", or "5.2 % larger"."""
        if self.metres is not None:
            return f"{self.metres(slope):.4g} m"
        change = slope / self.slope - 1
        return f"{100 * abs(change):.3g} % {'larger' if change > 0 else 'smaller'}"

    def sd_of(self, slope_sd: float) -> str:
        """The standard deviation by that of the slope: "0.012 m", or "1.2 %"."""
        if self.metres is not None:
            return f"{self.metres(slope_sd):.2g} m"
        return f"{100 * slope_sd / self.slope:.2g} %"


def of_line(line: Line, sample: Sample, quantity: Quantity) -> list[str]:
    """Warnings on a line. `quantity`: what its slope gives."""
    warnings = _of_readings(line, sample)
    if line.bend is not None and not line.bend.forbids:
        warnings.append(f"{line.bend.words()}: half of that change is in the budget; check orders and readings")
    warnings += [_of_break(step, line, sample, quantity) for step in line.breaks]
    if not line.breaks and line.bend is None:
        warnings += _of_count(line, sample, quantity)
    return warnings + _of_scatter(line, quantity)


def of_offset(offset: float, sd: float | None, measured: str, law: str) -> list[str]:
    """That the line does not go through contact, in orders. `law`: another one that does."""
    if sd is None or abs(offset) <= max(_OFFSET, 3 * sd):
        return []
    if law:
        return [
            f"the line does not pass through the contact order (offset {offset:+.2g} orders), and {law}: "
            f"with a gap the {measured} is right, with "
            "that law there is none; read more rings"
        ]
    miscount = round(offset)
    count = (
        f"the orders may be counted {abs(miscount)} too {'low' if miscount > 0 else 'high'}, or " if miscount else ""
    )
    return [
        f"the line does not pass through the contact order (offset {offset:+.2g} orders): {count}the surfaces do not "
        f"touch; the {measured} comes from the slope and is not affected"
    ]


def of_rounding(division: str, column: str) -> str:
    """That the standard deviation is that of the rounding."""
    return (
        f"the readings lie closer to their line than {column}, read to {division}, can tell: the standard deviation is "
        "that of the rounding, once for equal repeats of a ring"
    )


def undetermined(measured: str, value: float, sd: float, highest: float, suspects: list[str]) -> str:
    """Why the readings give no value."""
    reason = "".join(f"; {text}" for text in suspects)
    return (
        f"the readings do not determine the {measured}: {with_sd(value, sd, 'm')}, and the 95 % interval reaches "
        f"zero; it is below {highest:.3g} m{reason}; read more rings, or state the readings' sd"
    )


def _of_readings(line: Line, sample: Sample) -> list[str]:
    warnings = []
    if not line.used.all():
        readings = Counter(sample.order.tolist())
        rejected = Counter(sample.order[~line.used].tolist())
        parts = [
            f"{n} of {readings[m]} of order {m:g}" if readings[m] > 1 else f"order {m:g}" for m, n in rejected.items()
        ]
        listed = ", ".join(parts[:_LISTED]) + (f" and {len(parts) - _LISTED} more" if len(parts) > _LISTED else "")
        single = rejected.total() == 1
        verbs = ("reading", "lies", "was") if single else ("readings", "lie", "were")
        warnings.append(
            f"{rejected.total()} {verbs[0]} ({listed}) {verbs[1]} off the line of the others and {verbs[2]} left out"
        )
        level = line.slope * line.order + line.level
        warnings += filter(None, [single_sizes(level, sample.ordinate, line.used, line.slope)])
    if counted := sum(flag.startswith("counted") for flag in line.flags):
        warnings.append(f"{counted} orders were miscounted by a whole ring and set right; see their flags")
    suspects = [f"{m:g}" for m, flag in zip(line.order, line.flags, strict=True) if flag.startswith("does not")]
    if suspects:
        warnings.append(
            f"the readings do not lie on a line; order {', '.join(suspects)} is the likeliest to be misread"
        )
    return warnings


def _of_break(step: Break, line: Line, sample: Sample, quantity: Quantity) -> str:
    distance = "farther" if step.rings > 0 else "less far"
    text = (
        f"the readings up to order {step.before:g} and from order {step.after:g} on lie on lines of one slope that are "
        f"{abs(step.rings):.2g} +/- {step.sd:.1g} orders {distance} apart than counted"
    )
    proposals = []
    for rings in step.candidates:
        order = line.order[line.used] + rings * (sample.ordinate[line.used] >= step.first)
        slope = regression(order, sample.ordinate[line.used], sample.weight[line.used]).slope
        plural = "s were" if abs(rings) > 1 else " was"
        what = f"{rings} ring{plural} missed" if rings > 0 else f"{-rings} ring{plural} counted twice"
        radius = f"the {quantity.name} is {quantity.of(slope)}" if len(line.breaks) == 1 else "they lie on one line"
        proposals.append(f"if {what} between them, {radius}")
    proposed = "".join(f"; {text}" for text in proposals) or "; no whole number of rings explains it"
    return f"{text}{proposed}; the answer is the slope of the two sides alone"


def _of_count(line: Line, sample: Sample, quantity: Quantity) -> list[str]:
    doubt = line.uncertain_count(sample.floor)
    if doubt is None:
        return []
    values = " or ".join(
        f"{quantity.of(slope)} ({abs(rings)} {'missed' if rings > 0 else 'counted twice'})"
        for rings, slope in doubt.slopes.items()
    )
    return [
        f"the readings do not exclude a miscount between orders {doubt.before:g} and {doubt.after:g}: then the "
        f"{quantity.name} would be {values}; read the rings between them"
    ]


def _of_scatter(line: Line, quantity: Quantity) -> list[str]:
    scatter, warnings = line.scatter, []
    if scatter.common:
        warnings.append(
            f"readings of one ring agree {scatter.common:.2g} times better than the rings lie on the line: they share "
            "its error, so the rings are counted and not the readings"
        )
    if scatter.ratio is None or line.slope_sd is None:
        return warnings
    if scatter.is_above_stated:
        warnings.append(
            f"the readings scatter {scatter.ratio:.2g} times as far as their stated sd: the scatter's was used"
        )
    if scatter.is_below_stated:
        warnings.append(
            f"the readings scatter {scatter.ratio:.2g} times as far as their stated sd, which was used: by their "
            f"scatter the {quantity.name}'s sd is {quantity.sd_of(line.slope_sd * scatter.ratio)} and not "
            f"{quantity.sd_of(line.slope_sd)}"
        )
    return warnings
