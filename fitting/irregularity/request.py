"""What a form is asked: the arguments that are numbers, checked, and the sign of all terms."""

from typing import NamedTuple

import numpy as np

from fitting.irregularity.result import Lengths
from fitting.irregularity.zernike import REPORTED, TERMS
from fitting.parameters import number
from fitting.reasons import Reason
from newtonjax.numerics import shown

# Of a smaller aperture no form is seen [px].
LEAST_RADIUS = 24.0
# Of a term within so many standard deviations of zero the sign decides nothing.
_SIGN_SDS = 3.0


class Request(NamedTuple):
    """The arguments of `form` that are numbers, but for the light and the pixels, which are `lengths`."""

    lengths: Lengths
    pupil: tuple[float, float, float] | None
    pupil_sd: float | None
    terms: int | None
    sign: int | None
    distortion_sd: float

    def check(self) -> None:
        """Raises ValueError for what cannot be meant."""
        if self.pupil is not None:
            places = list(np.atleast_1d(np.asarray(self.pupil, dtype=object)))
            circle = [number("pupil", value) for value in places] if len(places) == 3 else [0.0]
            if circle[-1] < LEAST_RADIUS:
                least = f"{LEAST_RADIUS:g} pixels and more"
                raise ValueError(
                    f"pupil is {shown(self.pupil)}; allowed: column, row and radius of a circle of {least}"
                )
        for name, value, most in (("pupil_sd", self.pupil_sd, np.inf), ("distortion_sd", self.distortion_sd, 0.3)):
            if value is not None and not 0 <= number(name, value) <= most:
                raise ValueError(f"{name} is {value}; allowed: 0 to {most:g}")
        if self.terms is not None and self.terms not in REPORTED:
            raise ValueError(f"terms is {self.terms}; allowed: {', '.join(map(str, REPORTED))}")
        if self.sign is not None and not 2 <= abs(self.sign) <= TERMS:
            raise ValueError(f"sign is {self.sign}; allowed: the number of a term, 2 to {TERMS}, or minus that")


def flip_of(form: np.ndarray, sds: np.ndarray, sign: int | None) -> tuple[float, list[str]]:
    """The sign of all terms, that which is given, else power positive; and what is to be said of it."""
    term, target = (4, 1) if sign is None else (abs(sign), np.sign(sign))
    value = form[term - 1] if term <= len(form) else 0.0
    texts: list[str] = [Reason.FORM_SIGN_OPEN()] if sign is None else []
    if sign is not None and not abs(value) >= _SIGN_SDS * (sds[term - 1] if term <= len(form) else np.inf):
        texts.append(Reason.FORM_SIGN_UNDECIDED(term=term))
    return (float(target) if value >= 0 else -float(target)), texts
