"""Elliptic rings as a lens with two radii: what a view at a known angle leaves of their stretch.

With m the logarithm of the rings' stretch as a vector of twice its angle, a view's m of size -ln cos θ and the form's
add. The determinant of view times form is that of the form alone, so R = sqrt(R₁ R₂) does not depend on the view, and
R₁ = R exp(-m), R₂ = R exp(m), with m of the form; the radius of the mean curvature (1/R₁ + 1/R₂)/2 is R / cosh m.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fitting.model import STRETCHES
from fitting.parameters import Numbers, Parameter, absolute_sd, block_of, number
from fitting.photograph.priors import StatedPrior
from newtonjax.numerics import shown

# Views at more than this are not meant [rad].
_STEEPEST = np.pi / 4
# A lens whose radii differ by 20 %: one standard deviation of the prior where the view is known.
_FORM = 0.1
# Logarithms of radii of most lenses differ by less: the width of a Cauchy distribution in two dimensions.
_GOOD = 0.005
# Points of the quadrature over the view's direction, and over its angle, to so many standard deviations.
_DIRECTIONS, _ANGLES, _WIDTH = 720, 25, 3.0
# A direction of which nothing is known: even over half a turn.
_ANY_AXIS = np.pi / np.sqrt(12)


class View(NamedTuple):
    """Angle of the view against the normal, and its standard deviation [rad]."""

    angle: float
    sd: float

    @property
    def words(self) -> str:
        """As in "a view at 15 degrees"."""
        sd = f" ± {np.degrees(self.sd):.2g}" if self.sd else ""
        return f"a view at {np.degrees(self.angle):.4g}{sd} degrees"

    def priors(self) -> dict[str, StatedPrior]:
        """Of the components of the rings' stretch, whose direction nobody knows."""
        largest = -np.log(np.cos(min(self.angle + self.sd, _STEEPEST)))
        sd = float(np.hypot(largest / np.sqrt(2), _FORM))
        prior = StatedPrior(0.0, sd, "user", f"{self.words}, of a lens whose two radii may differ by 20 %")
        return dict.fromkeys(STRETCHES[0], prior)


def checked_view(angle: Any, sd: Any) -> View:
    """What is given of the view [rad]. Raises ValueError for what is no angle below 45 degrees, or no deviation."""
    if angle is None:
        raise ValueError("view_angle_sd is given without view_angle; give both, or neither")
    if not 0 <= number("view_angle", angle) < _STEEPEST:
        raise ValueError(f"view_angle is {float(f'{angle:.6g}')}; allowed: 0 to pi/4 radians, which is 45 degrees")
    deviation = absolute_sd("view_angle", sd, angle) or 0.0
    if deviation > _STEEPEST:
        raise ValueError(f"view_angle_sd is {shown(sd)}; allowed: 0 to pi/4 radians")
    return View(float(angle), deviation)


@dataclass(frozen=True)
class Meridians:
    """The form's share m of elliptic rings: mean and covariance; `is_known`: whether the view's angle is given.

    Otherwise the stretch is either the view's or the lens's: the mean is half of it, and so is the standard deviation.
    """

    mean: np.ndarray
    covariance: np.ndarray
    is_known: bool

    @property
    def size(self) -> float:
        """Half of the difference of the radii's logarithms."""
        return float(np.hypot(*self.mean))

    @property
    def size_sd(self) -> float:
        return float(np.sqrt(self._direction @ self.covariance @ self._direction))

    @property
    def _direction(self) -> np.ndarray:
        return self.mean / max(self.size, 1e-300) if self.size else np.array([1.0, 0.0])

    @property
    def flattening(self) -> tuple[float, float]:
        """Ln cosh m, by which the mean curvature's radius is smaller than the geometric mean, and its deviation."""
        spread = float(np.trace(self.covariance))
        square = (np.tanh(self.size) * self.size_sd) ** 2 + float(np.trace(self.covariance @ self.covariance)) / 2
        return float(np.log(np.cosh(np.sqrt(self.size**2 + spread)))), float(np.sqrt(square))

    @property
    def axis(self) -> tuple[float, float]:
        """Angle of the steeper meridian, from the image's x axis towards its y axis, 0 to pi, and its deviation."""
        x, y = self._direction
        across = np.array([-y, x])
        spread = float(np.sqrt(across @ self.covariance @ across))
        return float(np.arctan2(y, x) / 2 % np.pi), min(spread / max(2 * self.size, 1e-300), _ANY_AXIS)

    def parameters(self, radius: float, sd: float) -> dict[str, Parameter]:
        """The two radii [m] and their axis, for the geometric mean of the radii and its standard deviation."""
        relative = float(np.hypot(sd / radius, self.size_sd))
        sizes = {"radius_along": radius * np.exp(-self.size), "radius_across": radius * np.exp(self.size)}
        radii = {name: Parameter(float(size), float(size) * relative, False, name, "m") for name, size in sizes.items()}
        return {**radii, "astigmatism_axis": Parameter(*self.axis, False, "astigmatism_axis", "rad")}


def meridians_of(numbers: np.ndarray, covariance: np.ndarray, view: View | None) -> Meridians:
    """What a fit's stretch says of the lens, for its numbers and their covariance."""
    stretch = np.array([getattr(Numbers(*numbers), name) for name in STRETCHES[0]])
    spread = block_of(covariance, STRETCHES[0])
    if view is None:
        return Meridians(stretch / 2, spread / 2 + np.outer(stretch, stretch) / 4, False)
    width = _WIDTH * view.sd
    angles = view.angle + (np.linspace(-width, width, _ANGLES) if width else np.zeros(1))
    directions = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    likely = np.exp(-0.5 * ((angles - view.angle) / (view.sd or 1.0)) ** 2)
    sizes = -np.log(np.cos(np.clip(np.abs(angles), 0.0, 1.5)))
    ways = np.stack([np.cos(directions), np.sin(directions)], axis=-1)
    forms = (stretch - sizes[:, None, None] * ways).reshape(-1, 2)
    scale2 = _GOOD**2 + float(np.trace(spread)) / 2
    weights = np.repeat(likely, _DIRECTIONS) * (1 + (forms**2).sum(axis=1) / scale2) ** -1.5
    weights /= weights.sum()
    mean = weights @ forms
    apart = forms - mean
    return Meridians(mean, spread + (apart * weights[:, None]).T @ apart, True)
