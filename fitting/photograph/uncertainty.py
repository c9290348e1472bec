"""What a model leaves out, as deviations of the first number: the bench, sodium's second line, the field's halves."""

from dataclasses import replace

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from fitting.estimate import Fitted, Normal, bends, eliminate, evaluate, normal_equations, sums
from fitting.model import (
    BACKGROUND,
    GapModel,
    Microscope,
    anchors_of,
    degrees,
    gap_phase,
    microscope_on,
    numbers_of,
)
from fitting.parameters import NUMBERS, Numbers, Quantities
from fitting.photograph.remainder import paraboloid
from newtonjax.benches import ARGUMENTS

# A difference between two halves of the field beyond so many standard deviations is the model's, not the noise's.
_APART = 3.0
# Relative differences below this are rounding and unfinished steps.
_ROUNDING = 1e-7
# Middle of sodium's D lines in air, and their distance [m]: a wavelength between them may be either line or both.
_SODIUM, _LINES = 589.294e-9, 0.597e-9
# A visibility that falls by less tells nothing, and moves no radius.
_FADING = 0.003
# Nodes that a visibility is told from; below this share of the largest one it is its polynomial's error.
_FEWEST_NODES, _FAINT = 10, 0.05
# Half of (kurtosis - 1) of a disc out of focus along a line.
_OF_DISC = 0.5
# What is assumed of it: arguments of the ready bench, and standard deviations of these. The index of the glass that is
# looked through (fused silica has 1.46, heavy flint 1.7), its thickness, as a share, and the whole waves of a gap that
# dust holds open [m]: the root mean square of 0 to 5 um.
_BENCH = {argument.name: argument.default for argument in ARGUMENTS}
_INDEX, _THICKNESS, _GAP = 0.1, 0.5, 3e-6
_GLASS, GAP_WAVES = "glass looked through", "whole waves of the gap"
# Of their variance the mean's square: no gap is below 0, so all pictures' are too small together.
COMMON_WAVES = 0.75


def of_assumptions(fit: Fitted, known: Quantities) -> list[tuple[str, float]]:
    """Rows of what the gap formula assumes of the bench: changes of the first number by a deviation of each.

    A bench given as a scene says all that, contact or a held gap the whole waves in the gap.
    """
    model, numbers = fit.model, Numbers(*fit.numbers)
    if not isinstance(model, GapModel) or not np.any(model.microscope.sphere):
        return []
    microscope, x, y = model.microscope, model.frame.x, model.frame.y
    glass = "lens" if microscope.touching else "plate"

    def change(view: Microscope, reference: Microscope = microscope) -> np.ndarray:
        phases = (gap_phase.phase(replace(model, microscope=at), x, y, fit.numbers) for at in (view, reference))
        return np.subtract(*phases)

    variants = (
        {f"{glass}_index": _BENCH[f"{glass}_index"] + _INDEX},
        {f"{glass}_thickness": _BENCH[f"{glass}_thickness"] * (1 + _THICKNESS)},
    )
    rows = {_GLASS: [change(microscope_on(known, numbers, model.frame, microscope, **variant)) for variant in variants]}
    if microscope.modulo and not anchors_of(fit.parts):
        values = known.values(float(numbers.curvature) / model.frame.unit**2)
        waves = 2 * values["gap_index"] * _GAP / values["wavelength"]
        closed, held_open = (microscope._replace(modulo=0.0, touching=numbers.phase - turns) for turns in (0.0, waves))
        rows[GAP_WAVES] = [change(held_open, closed)]
    crossed = {name: bends(fit.solution, np.stack(changes, axis=1))[0] for name, changes in rows.items()}
    return [(name, float(np.linalg.norm(Numbers(*fit.matrix.shift(at)).curvature))) for name, at in crossed.items()]


def of_doublet(fit: Fitted, wavelength: float | None) -> float:
    """Change of the first number if the light is sodium's doublet, 2 : 1, as far as the fringes fade as its do.

    Nothing for a wavelength [m] that is not sodium's.

    The mean fringe of both lines is a cosine whose phase bends off the mean line's as the third power of the order,
    and whose visibility falls as the second: the share of that fall which is seen is the share of the change that
    counts.
    """
    if wavelength is None or abs(wavelength - _SODIUM) >= 0.6 * _LINES:
        return 0.0
    order = fit.solution.fields.phase - float(Numbers(*fit.numbers).phase)
    apart = 2 * np.pi * order * _LINES / _SODIUM
    both = (2 * np.exp(1j * apart / 3) + np.exp(-2j * apart / 3)) / 3
    share = _faded(fit, np.abs(both))
    if share == 0:
        return 0.0
    bend = np.angle(both) / (2 * np.pi)
    crossed = bends(fit.solution, bend[:, None])[0][:, 0]
    return share * abs(float(Numbers(*fit.matrix.shift(crossed)).curvature))


def _faded(fit: Fitted, wanted: np.ndarray) -> float:
    """How much of a visibility's fall, given at the nodes, the fringes show: 0 to 1."""
    used, visibility = _visibility(fit)
    if used.sum() < _FEWEST_NODES or np.ptp(wanted[used]) < _FADING:
        return 0.0
    fall = wanted[used] - wanted[used].mean()
    return float(np.clip((fall @ visibility) / (fall @ fall) / visibility.max(), 0.0, 1.0))


def of_blur(fit: Fitted) -> float:
    """Change of the first number by a blur or motion of the picture, as far as fringes fade where they are fine.

    A kernel of second moments S [px²] makes visibility exp(-2π² g·S g) of fringes of frequency g = 2 k r, and moves
    the phase of r² fringes of scale k by k tr S - 4π² c k |S g|² turns: the convolution to the lowest order that bends
    them, with half of its kernel's kurtosis less one for c: 1 of a Gaussian, 0.5 of a disc out of focus, 0.4 of motion.
    S is the least squares of the logarithm of visibility over background: an upper bound where anything else takes
    contrast from fine fringes.
    """
    used, visibility = _visibility(fit)
    if used.sum() < _FEWEST_NODES or not np.ptp(visibility) > _FADING:
        return 0.0
    scale, centre = paraboloid(fit)
    frequency = 2 * scale * np.stack([at - c for at, c in zip(fit.reduced.grid.nodes, centre, strict=True)], axis=1)
    x, y = frequency[used].T
    design = np.stack([np.ones_like(x), x * x, 2 * x * y, y * y], axis=1)
    logarithm = np.log(np.maximum(visibility, _FAINT * visibility.max()))
    xx, xy, yy = np.linalg.lstsq(design, logarithm, rcond=None)[0][1:] / (-2 * np.pi**2)
    squares, axes = np.linalg.eigh([[xx, xy], [xy, yy]])
    # Contrast that rises along an axis is no blur's.
    moments = (axes * np.maximum(squares, 0.0)) @ axes.T
    bend = -4 * np.pi**2 * _OF_DISC * scale * np.square(frequency @ moments).sum(axis=1)
    crossed = bends(fit.solution, bend[:, None])[0][:, 0]
    return abs(float(Numbers(*fit.matrix.shift(crossed)).curvature))


def _visibility(fit: Fitted) -> tuple[np.ndarray, np.ndarray]:
    """Nodes that are used and lit [nodes], and of these the fringes' half swing over the background."""
    grid, (x, y) = fit.reduced.grid, fit.reduced.grid.nodes
    rows, columns = (np.abs(at[:, None] - blocks).argmin(axis=1) for at, blocks in ((y, grid.y), (x, grid.x)))
    used = fit.left.weights[rows, columns] > 0
    low = degrees(BACKGROUND)
    along_y, along_x = (chebvander(grid.scaled(at, axis), BACKGROUND) for axis, at in enumerate((y, x)))
    smooth = (along_y[:, low[:, 0]] * along_x[:, low[:, 1]]) @ fit.solution.point.background + fit.reduced.offset
    used &= smooth > 0.2 * np.max(smooth)
    return used, np.abs(fit.solution.point.modulus)[used] / smooth[used]


def halves_apart(fit: Fitted, variance: float) -> float:
    """How far the first number is from that of the better half of the field, beyond what noise explains; 0 for nothing.

    The field is halved at its middle order, column and row. In each half one step of Gauss and Newton's method from
    the optimum moves curvature, centre, phase and illumination; the parts' numbers are held. Without a misfit the
    difference has the sum of both variances (Hausman's test, 1978); the whole field's number lies between the halves'
    as their variances say. The largest of the three ways to halve counts.
    """
    moving = fit.solution.problem.moving & ~np.isin(NUMBERS, numbers_of(fit.parts))
    worst = 0.0
    for first, second in _halvings(fit):
        one, other = _step(fit, first, moving), _step(fit, second, moving)
        if one is None or other is None:
            continue
        apart, noise = (one[0] - other[0]) ** 2, (one[1] + other[1]) * variance
        if apart > max(_APART**2 * noise, (_ROUNDING * Numbers(*fit.numbers).curvature) ** 2):
            worst = max(worst, np.sqrt(apart - noise) * min(one[1], other[1]) / (one[1] + other[1]))
    return float(worst)


def _halvings(fit: Fitted) -> list[tuple[Normal, Normal]]:
    """Moments of the field's two halves by order, column and row."""
    grid, used, weights = fit.reduced.grid, fit.reduced.used, fit.left.weights
    tables = [fit.phase, np.broadcast_to(grid.x, used.shape), np.broadcast_to(grid.y[:, None], used.shape)]
    phase, at = fit.solution.fields.phase, fit.solution.problem.phase.edges(fit.numbers)
    of_all = sums(replace(fit.reduced, weights=weights), phase, at)
    halves = []
    for table in tables:
        inside = np.where(table <= np.median(table[used]), weights, np.float32(0))
        first = sums(replace(fit.reduced, weights=inside), phase, at)
        second = of_all._replace(table=of_all.table - first.table, square=of_all.square - first.square)
        halves.append((normal_equations(first), normal_equations(second)))
    return halves


def _step(fit: Fitted, normal: Normal, moving: np.ndarray) -> tuple[float, float] | None:
    """The first number's step in part of the field, and its variance per unit of the noise's; None without either."""
    problem, fields = fit.solution.problem, fit.solution.fields
    point = evaluate(eliminate(normal, problem.degrees[0]), fields, problem.degrees[1])
    matrix = point.matrix[np.ix_(moving, moving)]
    size = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    if not np.all(size > 0):
        return None
    value, vector = np.linalg.eigh(matrix / np.outer(size, size))
    if value[0] < 1e-12 * value[-1]:
        return None
    inverse = (vector / value) @ vector.T / np.outer(size, size)
    return float(inverse[0] @ point.gradient[moving]), float(inverse[0, 0])
