"""The best curve under light whose spectrum is given in each channel, and how well that goes with the rings."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fitting.colour.amplitudes import background
from fitting.colour.given_light import GivenLight
from fitting.colour.lamp_fit import LampFit, followed
from fitting.colour.profiles import Profiles
from fitting.colour.solver import optimum
from fitting.colour.starts import Start, rates_about
from fitting.colour.waveform import PRIORS, Curve, View

# Gaps at the centre that are tried, and steps of the table of path differences [m].
_GAPS, _STEP = np.arange(-0.6e-6, 4e-6, 40e-9), 10e-9
# Curves that are followed further.
_FOLLOWED = 6
# The largest misfit of curves that are right, a little off, and further off, or such only after a large change; and the
# relative standard deviation of the wavelengths that goes with each (experiments/truth/colour_pairs.py).
_CLASSES = (
    ((2.5e-5, np.inf, 3.5), 1e-4),
    ((np.inf, 3e-4, 3.5), 0.008),
    ((np.inf, 2e-3, 3.5), 0.03),
    ((np.inf, 3e-4, 8.0), 0.03),
)


def best_given_fit(
    profiles: Profiles, light: GivenLight, scale: float, view: View, channels: tuple[int, ...]
) -> LampFit:
    """The best curve of given light; `scale`: of the search's rings [turns per px²]."""
    return followed(profiles, light, _starts(profiles, light, scale, view, channels), view, channels, _FOLLOWED)


def with_likeness(fit: LampFit) -> LampFit:
    """A fit whose channels are weighed as if only as many bins counted as are independent.

    What given curves are off by leaves smooth residuals over, against which the priors of the curves are weighed.
    """
    problem = replace(fit.problem, variances=fit.problem.variances * fit.correlations)
    return LampFit(problem, optimum(problem, fit.optimum.curve))


def _starts(profiles: Profiles, light: GivenLight, scale: float, view: View, channels: tuple[int, ...]) -> list[Start]:
    """The likeliest curves of a grid of rates and gaps at the centre, whatever the amplitudes are."""
    squares = profiles.squares
    rates = rates_about(light.middles, scale, float(squares.max()))
    longest = float(rates.max() * squares.max() + _GAPS.max())
    paths = 2 * np.arange(_GAPS.min() - _STEP, longest + _STEP, _STEP)
    phases = np.cos(2 * np.pi * paths[:, None] / light.wavelengths)
    smooth = background(squares, 3)
    unexplained = np.zeros((len(rates), len(_GAPS)))
    for k, channel in enumerate(channels):
        table = view.sign * phases @ light.powers[channel]
        root = np.sqrt(profiles.weight[k])
        basis = np.linalg.qr(smooth * root[:, None])[0]
        target = profiles.means[k] * root
        target = target - basis @ (basis.T @ target)
        for row, rate in enumerate(rates):
            at = 2 * (rate * squares + _GAPS[:, None])
            columns = np.interp(at, paths, table) * root
            columns -= columns @ basis @ basis.T
            along = np.maximum(columns @ target, 0.0)
            unexplained[row] += 1 - along**2 / np.maximum((columns**2).sum(axis=1), 1e-30) / (target @ target)
    candidates: list[Start] = []
    for place in np.argsort(unexplained, axis=None):
        row, column = np.unravel_index(place, unexplained.shape)
        around = unexplained[max(0, row - 3) : row + 4, max(0, column - 3) : column + 4]
        # One of each valley, or all that are followed would lie in one.
        if unexplained[row, column] <= around.min():
            curve = Curve(float(np.log(rates[row])), 1e6 * float(_GAPS[column]))
            candidates.append(Start(curve, float(unexplained[row, column])))
        if len(candidates) == _FOLLOWED:
            break
    return candidates


class Misfit(NamedTuple):
    """How far given curves are from those of the rings.

    - `worst`: share of the fringes' variance that is left over beyond white noise in the worst channel; `share`: in the
      median one, for a channel that is lit by the end of a curve alone says little of the others.
    - `change`: the largest tilt or curvature that the rings ask for, in standard deviations of what is expected.
    """

    worst: float
    share: float
    change: float

    @property
    def wavelength_sd(self) -> float | None:
        """Relative standard deviation of the wavelengths, by the rings; None where the curves are others than theirs.

        It is at least that: an error that all wavelengths have in common leaves the rings as they are.
        """
        for limit, sd in _CLASSES:
            if all(size <= most for size, most in zip(self, limit, strict=True)):
                return sd
        return None


def misfit(fit: LampFit) -> Misfit:
    """Of a fit under given light."""
    problem, curve = fit.problem, fit.optimum.curve
    profiles = problem.profiles
    rests = profiles.means - np.stack([answer.model for answer in problem.solved(curve)])
    ratios = np.mean(profiles.weight * rests**2, axis=1) / profiles.noise_of(rests)
    shares = fit.unexplained * np.maximum(1 - 1 / ratios, 0.0)
    names = [name for name in problem.free if name.startswith(("tilt", "curvature"))]
    changes = [abs(getattr(curve, name)) / (PRIORS[name] or np.inf) for name in names]
    return Misfit(float(shares.max()), float(np.median(shares)), max(changes))
