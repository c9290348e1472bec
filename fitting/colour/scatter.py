"""The standard deviation of a curve's rate from how the sectors of the rings differ among each other."""

import numpy as np

from fitting.colour.amplitudes import background
from fitting.colour.profiles import SECTORS
from fitting.colour.solver import STEPS, Optimum, Problem
from fitting.colour.waveform import PRIORS, waves

# Of the strongest component: what an absent one may have been, at least.
_LEAST = 0.01


def deviation_of_rate(problem: Problem, optimum: Optimum) -> float:
    """Relative standard deviation of the rate: by the sectors, and no less than their white noise.

    Each sector pulls the rate by its influence, H⁻¹ g of its own residuals (the infinitesimal jackknife: B. Efron,
    The Jackknife, the Bootstrap and Other Resampling Plans, 1982, section 6.3). What a shifted centre or an ellipse
    makes of these, harmonics of the angle, moves no mean and is taken out.
    """
    design, rests, widths = _linearized(problem, optimum)
    profiles = problem.profiles
    size = design[0].shape[1]
    normal, pulls = np.zeros((size, size)), np.zeros((SECTORS, size))
    for k, columns in enumerate(design):
        weights = profiles.weights[k] / problem.variances[k]
        normal += columns.T @ (columns * weights.sum(axis=0)[:, None])
        pulls += (weights * rests[k]) @ columns
    precisions = widths**-2.0
    normal[range(size), range(size)] += precisions
    direction = np.linalg.lstsq(normal, np.eye(size)[0], rcond=1e-12)[0]
    influence = pulls @ direction
    angle = 2 * np.pi * (np.arange(SECTORS) + 0.5) / SECTORS
    harmonics = np.stack([np.ones(SECTORS), np.cos(angle), np.sin(angle), np.cos(2 * angle), np.sin(2 * angle)], axis=1)
    used = profiles.weights.sum(axis=(0, 2)) > 0
    if used.sum() < 2 * harmonics.shape[1]:
        return optimum.deviation()
    harmonics, influence = harmonics[used], influence[used]
    residual = influence - harmonics @ np.linalg.lstsq(harmonics, influence, rcond=1e-9)[0]
    sectors = len(influence)
    by_sectors = sectors / (sectors - harmonics.shape[1]) * float((residual**2).sum())
    by_priors = float(precisions[: len(problem.free)] @ direction[: len(problem.free)] ** 2)
    return max(float(np.sqrt(by_sectors + by_priors)), optimum.deviation())


def _linearized(problem: Problem, optimum: Optimum) -> tuple[list[np.ndarray], list[np.ndarray], np.ndarray]:
    """Derivatives of each channel's bins in all numbers, the free ones first, and the residuals of its sectors.

    With them how wide all numbers are known before: a component that is absent may have been as strong as the channel's
    strongest band, for of bands that look alike noise chooses a few.
    """
    profiles, free = problem.profiles, problem.free
    answers = problem.solved(optimum.curve)
    smooth = background(profiles.squares, problem.degree)
    components, lines = len(answers[0].amplitudes), problem.palette.lines
    each = components + smooth.shape[1]
    total = len(free) + len(answers) * each
    widths = np.full(total, np.inf)
    widths[: len(free)] = [PRIORS[name] or np.inf for name in free]
    design, rests, first = [], [], len(free)
    for k, (answer, channel) in enumerate(zip(answers, problem.channels, strict=True)):

        def at(curve, channel=channel):
            return waves(problem.palette, curve, profiles.squares, profiles.width, channel, problem.view)

        columns = np.zeros((len(profiles.squares), total))
        unmoved = at(optimum.curve)
        for j, name in enumerate(free):
            next_curve = optimum.curve._replace(**{name: getattr(optimum.curve, name) + STEPS[name]})
            columns[:, j] = (at(next_curve) - unmoved) @ answer.amplitudes / STEPS[name]
        columns[:, first : first + each] = np.concatenate([unmoved, smooth], axis=1)
        strongest = max(
            float(answer.amplitudes[lines:].max(initial=0.0)), _LEAST * float(answer.amplitudes.max()), 1e-9
        )
        widths[first : first + components] = np.where(answer.amplitudes > 0, np.inf, strongest)
        first += each
        design.append(columns)
        rests.append(profiles.values[k] - answer.model)
    return design, rests, widths
