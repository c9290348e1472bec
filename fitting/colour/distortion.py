"""Whether a camera's distortion is in a colour photograph: its evidence, and what the rate owes to it."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fitting.colour.lamp_fit import LampFit, weighed
from fitting.colour.solver import optimum
from fitting.colour.waveform import PRIORS

_NAME = "bend"


class Distortion(NamedTuple):
    """A distortion beside a fit without one.

    - `probability`: of it, by the evidence; the fit has it from one half on.
    - `shift`: of the log rate by it; `noise`: standard deviation of that by noise alone.
    """

    probability: float
    shift: float
    noise: float

    @property
    def is_in(self) -> bool:
        """Whether the fit has it."""
        return self.probability > 0.5

    @property
    def spread(self) -> float:
        """Standard deviation of the log rate by the choice: the root of the mean square over both."""
        if self.is_in:
            return float(np.sqrt(1 - self.probability)) * abs(self.shift)
        return float(np.sqrt(self.probability * (self.shift**2 + self.noise**2)))


def with_distortion(fit: LampFit, deviation: float) -> tuple[LampFit, Distortion]:
    """The fit with a distortion where there is evidence for one; `deviation` of its log rate by the sectors.

    The odds are Laplace's: what it explains beyond the fit, over the noise of independent bins, and how much of its
    prior the picture leaves (D. J. C. MacKay, Information Theory, Inference, and Learning Algorithms, section 28.1).
    """
    prior, white = PRIORS[_NAME] or np.inf, fit.optimum.deviation()
    inflation = deviation / max(white, 1e-30)
    bent = replace(fit.problem, free=(*fit.problem.free, _NAME))
    best = optimum(bent, fit.optimum.curve)
    variances = np.diag(np.linalg.pinv(best.matrix))
    left_over = min(prior, inflation * float(np.sqrt(max(variances[-1], 0.0))))
    gain = max(fit.optimum.chi2 - best.chi2, 0.0) / (2 * inflation**2)
    log_odds = gain + float(np.log(max(left_over, 1e-30) / prior))
    probability = float(1 / (1 + np.exp(-np.clip(log_odds, -700, 700))))
    noise = inflation * float(np.sqrt(max(variances[0] - white**2, 0.0)))
    distortion = Distortion(probability, best.curve.log_rate - fit.optimum.curve.log_rate, noise)
    return (weighed(bent, best.curve) if distortion.is_in else fit), distortion
