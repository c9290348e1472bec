"""The log-posterior of a fit as a function, for samplers and optimizers of the user's own."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from fitting.parameters import Quantities
from fitting.photograph import FitResult
from fitting.sampling.density import Posterior, draws, in_blocks, log_density, posterior
from newtonjax.numerics import require, x64


@dataclass(frozen=True)
class LogPosterior:
    """The logarithm of a fit's posterior density, up to a constant, of many points at once.

    A point's coordinates are about standard deviations from the optimum, which is at 0: of the model's free numbers,
    then of each given quantity that has a standard deviation. `values` has the same points in units.

    - `names`: of the columns of `values`, in SI units, centres in pixels, the gap's phase in turns.
    - `dimensions`: numbers to a point.
    """

    target: Posterior
    fitted: object
    quantities: Quantities
    names: tuple[str, ...]

    @property
    def dimensions(self) -> int:
        """Numbers to a point."""
        return self.target.dimensions

    def __call__(self, points: Float[np.ndarray, "n dimensions"]) -> Float[np.ndarray, " n"]:
        """Log-density at points, -inf where the likelihood is not accurate (0.4 turns from the fit)."""
        points = self._checked(points)
        with x64():
            return np.asarray(in_blocks(log_density, self.target, points))

    def values(self, points: Float[np.ndarray, "n dimensions"]) -> dict[str, Float[np.ndarray, " n"]]:
        """The numbers at points, by name."""
        points = self._checked(points)
        with x64():
            names, columns = draws(self.target, self.fitted, self.quantities, points)  # pyright: ignore[reportArgumentType]  # a fit, which only this room may name
        return dict(zip(names, columns.T, strict=True))

    def _checked(self, points: Any) -> np.ndarray:
        allowed = f"an array of real numbers [points, {self.dimensions}], one point or more"
        require("points", points, allowed, lambda _: True)
        if np.ndim(points) != 2 or np.shape(points)[1] != self.dimensions or not len(points):
            raise ValueError(f"points has shape {np.shape(points)}; allowed: {allowed}")
        return np.asarray(points, float)


def log_posterior(result: FitResult) -> LogPosterior:
    """The log-posterior of a fit: the likelihood of every pixel, background and contrast integrated over.

    Free are the numbers that the fit measured, and every given quantity that has a standard deviation, which is its
    normal prior; priors of the others are flat. It is what `sample` draws from.

    Raises ValueError for a result without a fit, and for a fit with a plate radius.
    """
    fitted, quantities, variance, covariance, *_ = evidence_of(result)
    with x64():
        target = posterior(fitted, quantities, variance, covariance)
        names, _ = draws(target, fitted, quantities, np.zeros((1, target.dimensions)))
    return LogPosterior(target, fitted, quantities, names)


def evidence_of(result: FitResult):
    """What a posterior is made of. Raises ValueError for a result that has none."""
    if not isinstance(result, FitResult):
        raise ValueError(f"result is a {type(result).__name__}; allowed: what fitting.fit returned")
    if result.evidence is None:
        raise ValueError(f"the fit has no posterior: it is {result.status}; {result.message}")
    if result.evidence.known.plate is not None:
        raise ValueError("a posterior cannot include plate_radius; fit without it, and correct the radius afterwards")
    return result.evidence
