"""The rival "another law": r² against order is no straight line."""

from dataclasses import dataclass

import numpy as np

from fitting.pieces import Piece
from fitting.tables.regression import Regression, regression
from fitting.tables.sample import chance_of
from newtonjax.numerics import Statement

# Chance that honest readings are taken for bent.
ALARM = 0.005
# A slope that changes by this share of its mean over the table gives no radius.
_NO_RADIUS = 0.3
# Other powers of the radius that grow straight with the order of something that is not rings of a sphere.
_LAWS = {1: "equidistant fringes, as of a wedge", 4: "a surface of the fourth power"}
_POWERS = {1: "r", 4: "r⁴"}


@dataclass(frozen=True)
class Bend:
    """A parabola in place of the line: curvature over its sd, change of slope over the table over the mean slope.

    `law`: what the readings look like instead, "" where no other law fits better; `gain`: the fall of chi².
    """

    deviations: float
    change: float
    law: str
    gain: float

    @property
    def forbids(self) -> bool:
        """Whether there is no radius in such readings."""
        return bool(abs(self.change) > _NO_RADIUS)

    def words(self) -> Statement:
        """What the readings show, and what they look like."""
        law = Piece.BEND_BY_LAW(law=self.law) if self.law else ""
        return Piece.BEND(deviations=self.deviations, change=self.change, law=law)


def bend(line: Regression, radius: np.ndarray, floor: float) -> Bend | None:
    """The bend that no honest table shows by chance; None without. `radius`: of the line's readings."""
    if line.freedom < 2 or line.slope <= 0:
        return None
    # About each group's mean, so that no table is too long or begins too far out.
    parabola = line.added(line.centred**2)
    variance = max((line.chi2 - parabola.gain) / (line.freedom - 1), floor)
    deviations = parabola.coefficient / (parabola.unit_sd * np.sqrt(variance))
    if chance_of(deviations, line.freedom - 1) > ALARM:
        return None
    by_law = {power: _chi2_of(power, line, radius) for power in _LAWS}
    power = min(by_law, key=lambda p: by_law[p])
    chi2 = min(by_law[power], line.chi2 - parabola.gain)
    # A law is named where it fits as well as the parabola, which has a number more.
    is_law = by_law[power] < 1.5 * max(line.chi2 - parabola.gain, floor * line.freedom)
    change = 2 * parabola.coefficient * float(np.ptp(line.centred)) / line.slope
    return Bend(
        float(deviations), change, f"{_POWERS[power]} is one: {_LAWS[power]}" if is_law else "", line.chi2 - chi2
    )


def law_through_contact(line: Regression, radius: np.ndarray, contact: float) -> Statement | None:
    """Another law that goes through contact and fits no worse than the line, which does not; None without one."""
    order = line.order + contact
    for power, law in _LAWS.items():
        ordinate, weight = _power_of(power, line, radius)
        slope = float(weight * order @ ordinate) / float(weight @ order**2)
        chi2 = float(weight @ (ordinate - slope * order) ** 2)
        if line.freedom > 0 and chi2 / (line.freedom + 1) < line.chi2 / line.freedom:
            return Piece.ANOTHER_LAW(power=_POWERS[power], law=law)
    return None


def _chi2_of(power: int, line: Regression, radius: np.ndarray) -> float:
    """chi² of a straight line of a power of the radius."""
    ordinate, weight = _power_of(power, line, radius)
    return regression(line.order, ordinate, weight, line.group).chi2


def _power_of(power: int, line: Regression, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A power of the radius over the largest, with weights: each reading as certain as in the line of r²."""
    size = radius / radius.max()
    return size**power, line.weight * (2 * radius * radius.max() * size / (power * size**power)) ** 2
