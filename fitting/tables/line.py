"""The line r² against order: its slope with covariance, and the readings that do not lie on it.

Straight-line fits and externally studentized residuals as in Draper and Smith, Applied Regression Analysis (1998),
chapters 1 and 8.
"""

from dataclasses import dataclass

import numpy as np
from scipy import stats

# Chance of flagging anything in a table of honest readings.
_ALARM = 0.01
# A reading this far off the line, in orders, is no reading error: half an order is another ring.
_FAR = 0.4


@dataclass(frozen=True)
class Line:
    """Slope and intercept of y against order, with covariance; `freedom` is that of the scatter (0: none is known).

    `used` [readings]: which were used; `flags` [readings]: what is wrong with each, or "".
    """

    slope: float
    intercept: float
    covariance: np.ndarray
    freedom: float
    order: np.ndarray
    used: np.ndarray
    flags: list[str]

    def residual(self, y: np.ndarray) -> np.ndarray:
        """What is left of y over the line [readings]."""
        return y - self.slope * self.order - self.intercept

    def sd_of(self, slope: float, intercept: float) -> float:
        """Standard deviation of a number that changes so much with the slope and the intercept."""
        gradient = np.array([slope, intercept])
        return float(np.sqrt(gradient @ self.covariance @ gradient))


def straight_line(order: np.ndarray, y: np.ndarray, sd: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """(slope, intercept) and inverse normal matrix, by least squares weighted with 1/sd² (1 without `sd`)."""
    root = 1 / sd if sd is not None else np.ones_like(y)
    design = np.stack([order, np.ones_like(order)], axis=1) * root[:, None]
    inverse = np.linalg.inv(design.T @ design)
    return inverse @ design.T @ (y * root), inverse


def ring_line(order: np.ndarray, y: np.ndarray, sd: np.ndarray | None, expected: float) -> Line:
    """The line through the readings that belong to it; `expected` is the contact's intercept, in orders.

    Without `sd` the scatter gives the covariance; with `sd` it does where it is larger than they say. Orders counted
    wrong by a whole number from some ring on are set right; readings off the line are left out where at least four
    remain, and flagged in any case.
    """
    flags, used = [""] * len(y), np.ones(len(y), bool)
    order = _recounted(order, y, sd, flags)
    while True:
        worst = _outlier(order, y, sd, used)
        if worst is None:
            break
        distance = _distance_from_others(order, y, sd, used, worst)
        flags[worst] = f"off the line of the others by {distance:+.2g} orders: misread or miscounted"
        used[worst] = False
    if not any(flags):
        suspect = _suspect(order, y, sd, expected)
        if suspect is not None:
            flags[suspect] = "does not fit the other readings; with so few it cannot be left out: read more rings"
    (slope, intercept), inverse = straight_line(order[used], y[used], None if sd is None else sd[used])
    freedom = float(used.sum() - 2)
    residual = (y - slope * order - intercept)[used] / (1 if sd is None else sd[used])
    scatter = float(residual @ residual) / freedom if freedom else np.nan
    if sd is not None:
        freedom = freedom if scatter > 1 else np.inf
        scatter = np.fmax(scatter, 1.0)
    return Line(float(slope), float(intercept), inverse * scatter, freedom, order, used, flags)


def _outlier(order, y, sd, used) -> int | None:
    """The reading whose externally studentized residual no honest table has; None where there is none to leave out."""
    count = int(used.sum())
    if count < 5 or (~used).sum() >= 0.25 * len(y):
        return None
    at = np.flatnonzero(used)
    root = 1 / sd[at] if sd is not None else np.ones(count)
    (slope, intercept), inverse = straight_line(order[at], y[at], None if sd is None else sd[at])
    design = np.stack([order[at], np.ones(count)], axis=1) * root[:, None]
    leverage = np.einsum("ij,jk,ik->i", design, inverse, design)
    residual = (y[at] - slope * order[at] - intercept) * root
    free = np.clip(1 - leverage, 1e-12, None)
    variance = (residual @ residual - residual**2 / free) / (count - 3)
    if sd is not None:
        variance = np.maximum(variance, 1.0)
    elif np.all(variance <= 1e-24 * np.mean(y**2)):
        return None  # rounding of readings that lie on a line
    size = np.abs(residual) / np.sqrt(np.maximum(variance, 1e-300) * free)
    worst = int(np.argmax(size))
    chance = 2 * stats.t.sf(size[worst], count - 3) * count
    # A reading at the end of a short line pulls it: what counts is how far it lies from the others' line.
    distance = abs(_distance_from_others(order, y, sd, used, int(at[worst])))
    return (
        int(at[worst])
        if chance < _ALARM and distance > 0.1 and len(np.unique(np.delete(order[at], worst))) > 1
        else None
    )


def _distance_from_others(order, y, sd, used, reading: int) -> float:
    """Distance of a reading from the line of the other ones, in orders."""
    without = used.copy()
    without[reading] = False
    (slope, intercept), _ = straight_line(order[without], y[without], None if sd is None else sd[without])
    difference = y[reading] - slope * order[reading] - intercept
    # On a level line no reading has an order.
    return float(difference / slope) if slope else float(np.sign(difference)) * np.inf if difference else 0.0


def _recounted(order, y, sd, flags: list[str]) -> np.ndarray:
    """Orders with a skipped or doubled count set right: a step of whole orders that the readings show beyond doubt."""
    order = order.copy()
    for _ in range(3):
        best = None
        for first in np.unique(y)[2:-1]:
            step, error, freedom = _step(order, y, sd, y >= first)
            miscount = round(step)
            if miscount == 0 or freedom < 2 or abs(step - miscount) > min(0.3, max(3 * error, 0.02)):
                continue
            chance = 2 * stats.t.sf(abs(step) / max(error, 1e-12), freedom) * len(order)
            if chance < 0.1 * _ALARM and (best is None or chance < best[0]):
                best = chance, first, miscount
        if best is None:
            return order
        _, first, miscount = best
        later = y >= first
        for k in np.flatnonzero(later):
            flags[k] = (
                f"counted {abs(miscount)} too {'low' if miscount > 0 else 'high'}: taken as {order[k] + miscount:g}"
            )
        order[later] += miscount
    return order


def _step(order, y, sd, later: np.ndarray) -> tuple[float, float, int]:
    """Step of the orders from some reading on, its standard deviation, and the scatter's degrees of freedom."""
    freedom = len(y) - 3
    if freedom < 2 or len(np.unique(order[~later])) < 2 or len(np.unique(order[later])) < 2:
        return 0.0, np.inf, 0
    root = 1 / sd if sd is not None else np.ones_like(y)
    design = np.stack([order, np.ones_like(order), later.astype(float)], axis=1) * root[:, None]
    inverse = np.linalg.inv(design.T @ design)
    best = inverse @ design.T @ (y * root)
    residual = y * root - design @ best
    variance = residual @ residual / freedom if sd is None else max(residual @ residual / freedom, 1.0)
    return float(best[2] / best[0]), float(np.sqrt(variance * inverse[2, 2]) / abs(best[0])), freedom


def _suspect(order, y, sd, expected: float) -> int | None:
    """Of a few readings that do not lie on a line, the one without which the others come closest to contact."""
    count = len(y)
    if count < 3 or len(np.unique(order)) < 3:
        return None
    (slope, intercept), _ = straight_line(order, y, sd)
    residual = y - slope * order - intercept
    is_misread = np.abs(residual) > _FAR * abs(slope)
    if sd is not None:
        is_misread &= np.abs(residual) > 3 * sd
    if not is_misread.any() or count > 6:
        return None
    distances = []
    for reading in range(count):
        without = np.arange(count) != reading
        if len(np.unique(order[without])) < 2:
            distances.append(np.inf)
            continue
        (a, b), _ = straight_line(order[without], y[without], None if sd is None else sd[without])
        distances.append(abs(b / a - expected) if a > 0 else np.inf)
    return int(np.argmin(distances))
