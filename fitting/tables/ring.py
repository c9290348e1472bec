"""One reading of a table of rings, beside the line."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Ring:
    """One reading: radius and residual [m], or [px] without a scale; `flag` says what is wrong with it, or is ""."""

    order: float
    radius: float
    residual: float
    flag: str
