"""The division that sizes are read to: the last decimal place that a column has."""

import math
from collections.abc import Sequence
from decimal import Decimal, InvalidOperation

import numpy as np

# Numbers of a program are told apart to so many digits; beyond, they hold the rounding of binary numbers.
_DIGITS = 12
# Nobody reads to this share of the largest size: such numbers were calculated.
_CALCULATED = 1e-7


def division(columns: Sequence[Sequence], used: np.ndarray) -> float:
    """The smallest decimal step in columns of cells, in their unit, at most 1; 0 where the numbers were calculated.

    `used` [rows]: the rows that count. A text has the digits that it shows ("3.430": 0.001), a number those it needs.
    """
    numbers = [_decimal(cell) for cells in columns for cell, is_used in zip(cells, used, strict=True) if is_used]
    places = max((_places(number) for number in numbers), default=0)
    largest = max((abs(float(number)) for number in numbers), default=0.0)
    step = 10.0**-places
    return step if step > _CALCULATED * largest else 0.0


def rounding_sd(step: float, kind: str, factor: float) -> float:
    """Standard deviation of a radius by the rounding of its size, evenly spread over a step (GUM, F.2.2.1).

    `factor`: radius over size; `kind`: "left" is the difference of two readings.
    """
    return step / math.sqrt(12) * factor * (math.sqrt(2) if kind == "left" else 1.0)


def _decimal(cell) -> Decimal:
    text = str(cell).strip() if isinstance(cell, str) else f"{float(cell):.{_DIGITS}g}"
    try:
        return Decimal(text)
    except InvalidOperation:
        return Decimal(0)


def _places(number: Decimal) -> int:
    exponent = number.as_tuple().exponent
    return max(-exponent, 0) if isinstance(exponent, int) else 0
