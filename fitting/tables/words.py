"""What is said of a line: readings left out, miscounts, bends, scatter that is not as stated."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from fitting.parameters import with_sd
from fitting.pieces import Piece
from fitting.reasons import Reason
from fitting.tables.breaks import Break
from fitting.tables.line import Line
from fitting.tables.mixture import single_sizes
from fitting.tables.regression import regression
from fitting.tables.sample import Sample
from newtonjax.numerics import Joined, Statement

# Offsets from the contact order that are larger than this are reported [orders].
_OFFSET = 0.3
# Orders that one line lists at most.
_LISTED = 8


@dataclass(frozen=True)
class Quantity:
    """What the slope gives: its name, its value of a slope, None where pixels have no scale; the line's slope.

    `power`: per cent of the value to a per cent of the slope; `in_unit`: what follows a value. Without a scale, text
    says what is the same in any unit: a share of the value.
    """

    name: str
    value_of: Callable[[float], float] | None
    slope: float
    power: float = 1.0
    in_unit: str = " m"

    def of(self, slope: float) -> str:
        """The value that another slope gives: "1.234 m", or "5.2 % larger"."""
        if self.value_of is not None:
            return f"{self.value_of(slope):.4g}{self.in_unit}"
        change = slope / self.slope - 1
        return f"{100 * abs(change):.3g} % {'larger' if change > 0 else 'smaller'}"

    def sd_of(self, slope_sd: float) -> str:
        """The standard deviation by that of the slope: "0.012 m", or "1.2 %"."""
        if self.value_of is not None:
            share = abs(self.power) * slope_sd / self.slope
            return f"{share * self.value_of(self.slope):.2g}{self.in_unit}"
        return f"{100 * slope_sd / self.slope:.2g} %"


def of_line(line: Line, sample: Sample, quantity: Quantity) -> list[Statement]:
    """Warnings on a line. `quantity`: what its slope gives."""
    warnings = _of_readings(line, sample)
    if line.bend is not None and not line.bend.forbids:
        warnings.append(Reason.BENT_LINE(bend=line.bend.words()))
    warnings += [_of_break(step, line, sample, quantity) for step in line.breaks]
    if not line.breaks and line.bend is None:
        warnings += _of_count(line, sample, quantity)
    return warnings + _of_scatter(line, quantity)


def of_offset(offset: float, sd: float | None, measured: str, law: Statement | None) -> list[Statement]:
    """That the line does not go through contact, in orders. `law`: another one that does."""
    if sd is None or abs(offset) <= max(_OFFSET, 3 * sd):
        return []
    if law:
        return [Reason.OTHER_LAW_THROUGH_CONTACT(offset=offset, law=law, measured=measured)]
    miscount = round(offset)
    piece = Piece.COUNTED_TOO_LOW if miscount > 0 else Piece.COUNTED_TOO_HIGH
    count = piece(rings=abs(miscount)) if miscount else ""
    return [Reason.NOT_THROUGH_CONTACT(offset=offset, count=count, measured=measured)]


def undetermined(
    measured: str, value: float, sd: float, highest: float, suspects: list[Statement], in_unit: str = " m"
) -> Statement:
    """Why the readings give no value."""
    # Each of them after a semicolon, the first too.
    text = Joined("; ", ["", *suspects])
    return Reason.INTERVAL_REACHES_ZERO(
        measured=measured, value=with_sd(value, sd, in_unit.strip()), highest=highest, unit=in_unit, suspects=text
    )


def _of_readings(line: Line, sample: Sample) -> list[Statement]:
    warnings = []
    if not line.used.all():
        readings = Counter(sample.order.tolist())
        rejected = Counter(sample.order[~line.used].tolist())
        parts = [
            f"{n} of {readings[m]} of order {m:g}" if readings[m] > 1 else f"order {m:g}" for m, n in rejected.items()
        ]
        listed = ", ".join(parts[:_LISTED]) + (f" and {len(parts) - _LISTED} more" if len(parts) > _LISTED else "")
        reason = Reason.READING_LEFT_OUT if rejected.total() == 1 else Reason.READINGS_LEFT_OUT
        warnings.append(reason(count=rejected.total(), listed=listed))
        level = line.slope * line.order + line.level
        warnings += filter(None, [single_sizes(level, sample.ordinate, line.used, line.slope)])
    if counted := sum(flag.startswith("counted") for flag in line.flags):
        warnings.append(Reason.ORDERS_SET_RIGHT(count=counted))
    suspects = [f"{m:g}" for m, flag in zip(line.order, line.flags, strict=True) if flag.startswith("does not")]
    if suspects:
        warnings.append(Reason.LIKELY_MISREAD(orders=", ".join(suspects)))
    return warnings


def _of_break(step: Break, line: Line, sample: Sample, quantity: Quantity) -> Statement:
    proposals = []
    for rings in step.candidates:
        order = line.order[line.used] + rings * (sample.ordinate[line.used] >= step.first)
        slope = regression(order, sample.ordinate[line.used], sample.weight[line.used]).slope
        plural = "s were" if abs(rings) > 1 else " was"
        what = f"{rings} ring{plural} missed" if rings > 0 else f"{-rings} ring{plural} counted twice"
        radius = f"the {quantity.name} is {quantity.of(slope)}" if len(line.breaks) == 1 else "they lie on one line"
        proposals.append(Piece.RINGS_BETWEEN(rings=what, then=radius))
    return Reason.ORDERS_MISCOUNTED(
        before=step.before,
        after=step.after,
        rings=abs(step.rings),
        sd=step.sd,
        distance="farther" if step.rings > 0 else "less far",
        proposals=Joined("; ", proposals or [Piece.NO_RINGS_BETWEEN()]),
    )


def _of_count(line: Line, sample: Sample, quantity: Quantity) -> list[Statement]:
    doubt = line.uncertain_count(sample.floor)
    if doubt is None:
        return []
    values = " or ".join(
        f"{quantity.of(slope)} ({abs(rings)} {'missed' if rings > 0 else 'counted twice'})"
        for rings, slope in doubt.slopes.items()
    )
    return [Reason.COUNT_NOT_EXCLUDED(before=doubt.before, after=doubt.after, measured=quantity.name, values=values)]


def _of_scatter(line: Line, quantity: Quantity) -> list[Statement]:
    scatter, warnings = line.scatter, []
    if scatter.common:
        warnings.append(Reason.SHARED_RING_ERROR(common=scatter.common))
    if scatter.ratio is None or line.slope_sd is None:
        return warnings
    if scatter.is_above_stated:
        warnings.append(Reason.SCATTER_ABOVE_STATED(ratio=scatter.ratio))
    if scatter.is_below_stated:
        by_scatter, stated = (quantity.sd_of(line.slope_sd * ratio) for ratio in (scatter.ratio, 1.0))
        warnings.append(
            Reason.SCATTER_BELOW_STATED(
                ratio=scatter.ratio, measured=quantity.name, by_scatter=by_scatter, stated=stated
            )
        )
    return warnings
