"""Whether an answer makes sense: sizes of rings mistaken for others, and units for others."""

from collections.abc import Iterator

import numpy as np

from fitting.parameters import TABLE
from fitting.pieces import Piece
from fitting.reasons import Reason
from fitting.tables.headers import METRES
from newtonjax.numerics import Statement

# By this share a value may be beyond them: at a limit rounding does not decide.
_ROUNDED = 1e-9
# Where no rough value is known, a proposal lies where most lenses and lamps are.
_USUAL = {"radius": (5e-3, 100.0), "wavelength": (380e-9, 1100e-9), "gap_index": (1.0, 1.9)}
# The index falls with the square of the sizes, the others grow with it.
_POWERS = {"gap_index": -1.0}


def doubts(measured: str, value: float, expected: float | None, column: str, unit: str) -> list[Statement]:
    """Warnings on a radius or wavelength [m], or an index, that is not as expected, or not as any is.

    They say what would explain it. `column`: what sizes were read from; `unit`: in which unit.
    """
    if expected is None:
        low, high = TABLE[measured].sensible
        if low * (1 - _ROUNDED) <= value <= high * (1 + _ROUNDED):
            return []
        usual = _USUAL[measured]
        power = _POWERS.get(measured, 1.0)
        slips = [(factor**power, words) for factor, words in _slips(column, unit)]
        slips = [(factor, words) for factor, words in slips if usual[0] <= value * factor <= usual[1]]
        slips.sort(key=lambda slip: abs(np.log(slip[0])))
        slip = _likeliest(slips, measured, value)
        name, in_unit = measured.replace("_", " "), _unit(measured)
        return [Reason.BEYOND_SENSIBLE(measured=name, value=value, low=low, high=high, unit=in_unit, slip=slip)]
    ratio = value / expected
    slips = sorted(_slips(column, unit), key=lambda slip: abs(np.log(ratio * slip[0])))[:1]
    # Where nothing explains a difference, one by a factor of two is worth a word.
    nearest = abs(np.log(ratio * slips[0][0])) if slips else np.log(2)
    if abs(np.log(ratio)) <= nearest:
        return []
    slip = _likeliest([slip for slip in slips if abs(np.log(ratio * slip[0])) < np.log(2)], measured, value)
    return [Reason.NOT_AS_EXPECTED(measured=measured, ratio=ratio, slip=slip)]


def _likeliest(slips: list[tuple[float, Statement]], measured: str, value: float) -> Statement | str:
    """What the first of the slips would explain; nothing without one."""
    if not slips:
        return ""
    factor, look = slips[0]
    return Piece.SLIP(look=look, measured=measured.replace("_", " "), value=value * factor, unit=_unit(measured))


def _unit(measured: str) -> str:
    return "" if measured == "gap_index" else " m"


def _slips(column: str, unit: str) -> Iterator[tuple[float, Statement]]:
    """Factors of the answer, which goes with the square of the sizes, and what would be the reason."""
    called, look = ("radii", "diameters") if column.startswith("radius") else ("diameters", "radii")
    if not column.startswith("left"):
        factor = 0.25 if called == "radii" else 4.0
        yield factor, Piece.SIZES_LOOK_LIKE(called=called, look=look)
    for true_unit, metres in METRES.items() if unit in METRES else ():
        if true_unit != unit:
            factor = (metres / METRES[unit]) ** 2
            yield factor, Piece.UNIT_LOOKS_LIKE(unit=unit, look=true_unit)
