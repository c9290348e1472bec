"""Which quantity a fit measures: n s² / (R λ) is one number, so three of the four must be given."""

from dataclasses import dataclass

import numpy as np

# ln k = Σ exponent ln quantity, for the fringe scale k = n s² / (R λ).
EXPONENTS = {"radius": -1, "wavelength": -1, "pixel_size": 2, "index": 1}


@dataclass(frozen=True)
class Quantities:
    """What is given (SI units), with standard deviations, and the one that is measured (None: not enough given)."""

    given: dict[str, float]
    sd: dict[str, float]
    unknown: str | None

    @property
    def measured(self) -> str:
        """The unknown quantity. Raises ValueError where too little is given to measure one."""
        if self.unknown is None:
            missing = ", ".join(name for name in EXPONENTS if name not in self.given)
            raise ValueError(f"{missing} are not given; one quantity can be measured when the other three are given")
        return self.unknown

    def solve(self, scale: float) -> float:
        """The unknown quantity for a fringe scale [1/px²]."""
        exponent = EXPONENTS[self.measured]
        known = sum(EXPONENTS[name] * np.log(value) for name, value in self.given.items())
        return float(np.exp((np.log(scale) - known) / exponent))

    def values(self, scale: float) -> dict[str, float]:
        """All four quantities for a fringe scale."""
        return {**self.given, self.measured: self.solve(scale)}

    def sphere(self, scale: float) -> tuple[float, float]:
        """Factor and power of the sphere's curvature in 1/px, factor scale^power; factor 0 where it is not known.

        s/R is k λ/(n s) where the radius is measured, sqrt(k λ/(n R)) where the pixel size is, and given elsewhere.
        """
        if self.unknown is None:
            return 0.0, 1.0
        values, power = self.values(scale), {"radius": 1.0, "pixel_size": 0.5}.get(self.unknown, 0.0)
        return values["pixel_size"] / values["radius"] / scale**power, power


def quantities(given: dict[str, float | None], sd: dict[str, float | None], free: tuple[str, ...]) -> Quantities:
    """Sort what is given from what is to be measured.

    Raises ValueError for values that are not positive, and where nothing is left to measure.
    """
    for kind, table in (("", given), (" standard deviation", sd)):
        for name, value in table.items():
            bad = value is not None and not (np.isfinite(value) and (value > 0 or (kind and value == 0)))
            if bad:
                raise ValueError(f"{name}{kind} is {value}; allowed: a positive number in SI units")
    known = {name: float(value) for name, value in given.items() if value is not None and name not in free}
    missing = [name for name in EXPONENTS if name not in known]
    if not missing:
        raise ValueError(
            "radius, wavelength, pixel_size and index are all given: nothing is left to measure; "
            "leave one out, or name it in free"
        )
    return Quantities(
        known,
        {name: float(value) for name, value in sd.items() if value and name in known},
        missing[0] if len(missing) == 1 else None,
    )
