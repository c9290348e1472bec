"""Standard deviations under one unknown light from how the sectors of each picture's rings differ among each other."""

import numpy as np
from jaxtyping import Float

from fitting.colour.amplitudes import Channel
from fitting.colour.profiles import SECTORS
from fitting.colour.unknown_problem import SharedProblem
from fitting.colour.waveform import Curve

# Of the information of the richest sector: one that has less says nothing.
_LEAST = 1e-3
# Of a shifted centre, and of an ellipse.
_ANGLES = np.outer(2 * np.pi * (np.arange(SECTORS) + 0.5) / SECTORS, np.arange(3))
_HARMONICS = np.concatenate([np.cos(_ANGLES), np.sin(_ANGLES[:, 1:])], axis=1)


def log_scales(
    problem: SharedProblem, curves: tuple[Curve, ...], answers: list[Channel]
) -> tuple[Float[np.ndarray, " pictures"], Float[np.ndarray, "pictures numbers"]]:
    """Logarithms of the fringe scales of the mean wave [turns per px²], and their gradients.

    The mean wave is that of the middle one of the channels' mean wavenumbers. Gradients are in what is free, then in
    the amplitudes and backgrounds of each channel.
    """
    wavenumbers = 1 / problem.light.wavelengths
    means = [float(answer.amplitudes @ wavenumbers / answer.amplitudes.sum()) for answer in answers]
    middle = int(np.argsort(means)[len(means) // 2])
    free, waves, each = _sizes(problem)
    gradient = np.zeros((len(curves), free + len(answers) * each))
    for place, number in enumerate(problem.free):
        if number.name == "log_rate":
            gradient[list(number.pictures), place] = 1.0
    of_light = (wavenumbers / means[middle] - 1) / answers[middle].amplitudes.sum()
    gradient[:, free + middle * each : free + middle * each + waves] = of_light
    return np.array([np.log(2 * means[middle]) + curve.log_rate for curve in curves]), gradient


def deviations(
    problem: SharedProblem,
    curves: tuple[Curve, ...],
    answers: list[Channel],
    gradients: Float[np.ndarray, "rows numbers"],
) -> Float[np.ndarray, " rows"]:
    """Standard deviations of quantities of these gradients: by the sectors, and no less than their white noise.

    Each sector pulls a quantity by its influence, as in `scatter.py`; sectors of different pictures are independent.
    """
    design = _design(problem, curves, answers)
    normal = _held(problem, answers)
    for k, columns in enumerate(design):
        normal += columns.T @ (columns * problem.weights(k)[:, None])
    direction = np.linalg.lstsq(normal, gradients.T, rcond=1e-13)[0]
    variance, white = np.zeros(len(gradients)), np.maximum((gradients.T * direction).sum(axis=0), 0.0)
    ends = np.cumsum([0, *(len(single.squares) for single in problem.profiles)])
    for picture, single in enumerate(problem.profiles):
        bins = slice(ends[picture], ends[picture + 1])
        influence, information = np.zeros((2, SECTORS, len(gradients)))
        for k, (columns, answer) in enumerate(zip(design, answers, strict=True)):
            along, weights = columns[bins] @ direction, single.weights[k] / problem.variances[picture, k]
            influence += (weights * (single.values[k] - answer.model[bins])) @ along
            information += weights @ along**2
        variance += [_variance(*pair) for pair in zip(influence.T, information.T, strict=True)]
    return np.sqrt(np.maximum(variance, white))


def _variance(influence: Float[np.ndarray, " sectors"], information: Float[np.ndarray, " sectors"]) -> float:
    """Variance of a quantity by the scatter of its sectors.

    What a shifted centre or an ellipse makes of these, harmonics of the angle, is beside their mean where the sectors
    go round; where they do not, the mean has a part of it: as a bias, and as more variance of a mean beside harmonics.
    """
    used = information > _LEAST * information.max(initial=0.0)
    count, terms = int(used.sum()), _HARMONICS.shape[1]
    if count < 2:
        return 0.0
    harmonics = _HARMONICS[used, : terms if count >= 2 * terms else 1]
    shares = information[used] / information[used].sum()
    local = influence[used] / shares
    inverse = np.linalg.pinv(harmonics.T @ (harmonics * shares[:, None]))
    fitted = inverse @ (harmonics.T @ (shares * local))
    scatter = float(shares @ (local - harmonics @ fitted) ** 2) / (count - harmonics.shape[1])
    # Each harmonic by itself: that they cancel in the mean of this picture's sectors is how the mean was made.
    biases = fitted * (shares @ harmonics)
    return float(biases @ biases + scatter * inverse[0, 0])


def _sizes(problem: SharedProblem) -> tuple[int, int, int]:
    """Numbers that are free, waves, and numbers of each channel: its amplitudes and backgrounds."""
    waves = len(problem.light.wavelengths)
    return len(problem.free), waves, waves + problem.smooth.shape[1]


def _design(
    problem: SharedProblem, curves: tuple[Curve, ...], answers: list[Channel]
) -> list[Float[np.ndarray, "bins numbers"]]:
    """Derivatives of each channel's bins in all numbers."""
    free, waves, each = _sizes(problem)
    design = []
    for k, answer in enumerate(answers):
        first = free + k * each
        changes = problem.changes(curves, answer.amplitudes, k)
        columns = np.zeros((len(changes), free + len(answers) * each))
        columns[:, :free] = changes
        columns[:, first : first + waves] = problem.waves(curves, problem.channels[k])
        columns[:, first + waves : first + each] = problem.smooth
        design.append(columns)
    return design


def _held(problem: SharedProblem, answers: list[Channel]) -> Float[np.ndarray, "numbers numbers"]:
    """What is known of all numbers before, as a normal matrix.

    A wave that is absent may have been as strong as the strongest: of neighbours noise chooses a few.
    """
    free, waves, each = _sizes(problem)
    total = free + len(answers) * each
    normal = np.zeros((total, total))
    normal[range(free), range(free)] = problem.widths**-2.0
    for k, answer in enumerate(answers):
        amplitudes = range(free + k * each, free + k * each + waves)
        strongest = max(float(answer.amplitudes.max()), 1e-9)
        normal[np.ix_(amplitudes, amplitudes)] += problem.light.held.T @ problem.light.held
        normal[amplitudes, amplitudes] += np.where(answer.amplitudes > 0, 0.0, strongest**-2.0)
    return normal
