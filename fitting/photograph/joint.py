"""Several pictures of one camera in one likelihood: linear algebra on the normal matrices of their single fits.

What the pictures share (the camera's distortion and its axis) is one set of numbers with one prior; each picture has
its curvature and its own parts. The answer is the mean over all sets of parts, as that of one picture (`averaging`):
the camera's parts are there in all pictures or in none. No set takes a pass over an image.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fitting.estimate import pseudo_inverse
from fitting.model import AXIS, PARTS, numbers_of
from fitting.parameters import NUMBERS, Numbers
from fitting.photograph.averaging import Averaging, Member, Parts, eliminated

# The parts that a camera brings, and its numbers.
CAMERA = ("distortion", "fifth_order")
CAMERA_NUMBERS = numbers_of(CAMERA)
# Sets of parts of all pictures that are carried on from one picture to the next, for each set of the camera's.
_CARRIED = 24
_RANK = 1e-10


class Linear(NamedTuple):
    """A picture's chi-squared xᵀ T x - 2 pull·x + square in the numbers x of all parts that may be there.

    - `curvature` - `slope`·x is the curvature; `noise`: its variance for given x; `absent`: values without the part.
    - `centre`, `precision`: of the priors.
    """

    names: tuple[str, ...]
    matrix: np.ndarray
    pull: np.ndarray
    square: float
    curvature: float
    slope: np.ndarray
    noise: float
    absent: np.ndarray
    centre: np.ndarray
    precision: np.ndarray


class View(NamedTuple):
    """One picture: what may be there, as (parts, chi-squared of its fit with all of them).

    - `ratio`: of the data's variance by clusters of residuals to what the correlation of neighbours says.
    - `temper`: the divisor of logarithms of weights; `half_diagonal` [px] and `shape` of the frame.
    """

    options: tuple[tuple[Parts, Linear], ...]
    ratio: float
    temper: float
    half_diagonal: float
    shape: tuple[int, ...]


class Joint(NamedTuple):
    """The mean over all sets: curvatures [pictures] and covariance, and what is shared.

    - `shared`: by number (value, standard deviation), in half diagonals of the first picture.
    - `of_camera`: covariance of the curvatures that the camera's numbers bring.
    """

    curvatures: np.ndarray
    covariance: np.ndarray
    shared: dict[str, tuple[float, float]]
    of_camera: np.ndarray


class _Hypothesis(NamedTuple):
    """Sets of parts of some pictures, in their order, and what follows from them."""

    options: tuple[tuple[Parts, Linear], ...]
    evidence: float
    curvatures: np.ndarray
    covariance: np.ndarray
    shared: np.ndarray
    shared_covariance: np.ndarray
    of_camera: np.ndarray


def view_of(averaging: Averaging, variance: float, ratio: float, shape: tuple[int, ...]) -> View:
    """A picture of a shape, from its single fits; `variance`: of the light per unit weight, correlation included."""
    options = []
    for member in averaging.members:
        linear = _linear(member, variance)
        options += [(parts, linear) for parts in member.sets]
    temper = max(1.0, float(np.sqrt(min(member.fit.correlation for member in averaging.members))))
    return View(tuple(options), ratio, temper, float(np.hypot(shape[0] - 1, shape[1] - 1) / 2), shape)


def _linear(member: Member, variance: float) -> Linear:
    rest = eliminated(member, variance)
    matrix, values = rest.matrix / variance, member.fit.matrix.values[rest.slots]
    pull = rest.pull / variance
    prior = np.array([member.priors.numbers[name] for name in rest.names]).reshape(-1, 2)
    place = int(np.flatnonzero(rest.core == NUMBERS.index("curvature"))[0])
    slope = rest.slope[place]
    step = float(rest.step[place])
    return Linear(
        rest.names,
        matrix,
        matrix @ values + pull,
        float(values @ matrix @ values + 2 * pull @ values) + member.misfit / variance,
        float(Numbers(*member.fit.numbers).curvature) + step + float(slope @ values),
        slope,
        variance * float(rest.inverse[place, place]),
        np.where(np.isin(rest.names, AXIS), values, 0.0),
        prior[:, 0],
        1 / np.square(prior[:, 1]),
    )


def joined(views: Sequence[View], forced: bool = False) -> Joint:
    """The pictures in one likelihood; `forced`: with all parts of the camera that may be there."""
    sets = _camera_sets(views)[-1 if forced else 0 :]
    hypotheses = [hypothesis for camera in sets for hypothesis in _grown(views, camera)]
    temper = max(view.temper for view in views)
    evidence = np.array([hypothesis.evidence for hypothesis in hypotheses]) / temper
    weights = np.exp(evidence - evidence.max())
    weights /= weights.sum()
    curvatures, covariance = _mixture(
        weights, [case.curvatures for case in hypotheses], [case.covariance for case in hypotheses]
    )
    shared, spread = _mixture(
        weights, [case.shared for case in hypotheses], [case.shared_covariance for case in hypotheses]
    )
    names = _shared_names(views, sets[-1])
    sds = np.sqrt(np.clip(np.diag(spread), 0, None))
    return Joint(
        curvatures,
        covariance,
        {name: (float(shared[k]), float(sds[k])) for k, name in enumerate(CAMERA_NUMBERS) if name in names},
        np.tensordot(weights, [hypothesis.of_camera for hypothesis in hypotheses], 1),
    )


def contradiction(views: Sequence[View], place: int) -> float:
    """By how many standard deviations one picture's camera differs from that of the others, at most."""
    beside = [view for k, view in enumerate(views) if k != place]
    own, rest = joined(views[place : place + 1], forced=True), joined(beside, forced=True)
    apart = [0.0]
    for name in (name for name in own.shared if name in rest.shared and name not in AXIS):
        (value, sd), (mean, mean_sd) = own.shared[name], rest.shared[name]
        scale = _factor(name, views[place], beside[0])
        apart.append(abs(value - scale * mean) / float(np.hypot(sd, scale * mean_sd)))
    return max(apart)


def _camera_sets(views: Sequence[View]) -> list[Parts]:
    """The sets of the camera's parts that all pictures may have that may have any; the largest last."""
    by_view = [{parts & set(CAMERA) for parts, _ in view.options} for view in views]
    of_camera = [sets for sets in by_view if any(sets)] or [{frozenset()}]
    return sorted(frozenset.intersection(*map(frozenset, of_camera)) or of_camera[0], key=lambda s: (len(s), sorted(s)))


def _grown(views: Sequence[View], camera: Parts) -> list[_Hypothesis]:
    """The most probable sets of parts of all pictures with the camera's parts."""
    carried: list[tuple[tuple[Parts, Linear], ...]] = [()]
    grown: list[_Hypothesis] = []
    for count, view in enumerate(views, 1):
        options = [option for option in view.options if _agrees(option[0], view, camera)]
        grown = [_evaluated(views[:count], (*before, option), camera) for before in carried for option in options]
        grown.sort(key=lambda hypothesis: -hypothesis.evidence)
        del grown[_CARRIED:]
        carried = [hypothesis.options for hypothesis in grown]
    return grown


def _agrees(parts: Parts, view: View, camera: Parts) -> bool:
    if not any(options & set(CAMERA) for options, _ in view.options):
        return True
    return parts & set(CAMERA) == camera


def _factor(name: str, view: View, reference: View) -> float:
    """A camera's number in half diagonals of one picture, by that in those of another with the same pixels."""
    size = view.half_diagonal / reference.half_diagonal
    part = next(part for part in PARTS.values() if name in part.parameters)
    return 1 / size if name in part.axis else size ** (2 * part.radial_power)


class _System(NamedTuple):
    """Normal equations of the shared and the own numbers of all pictures, the `shared` ones first.

    - `blocks`, `pulls`: by picture; `prior`, `of_prior`: precisions, and times their centres; `cost`: at zero.
    - `rows`, `offsets`: the curvatures by the numbers; `noise`: their variance for given numbers.
    """

    shared: int
    blocks: list[np.ndarray]
    pulls: list[np.ndarray]
    prior: np.ndarray
    of_prior: np.ndarray
    cost: float
    rows: np.ndarray
    offsets: np.ndarray
    noise: np.ndarray


def _evaluated(views: Sequence[View], options: tuple[tuple[Parts, Linear], ...], camera: Parts) -> _Hypothesis:
    """Least squares in all numbers, and the logarithm of the evidence."""
    shared = _shared_names(views, camera)
    system = _system(views, options, shared)
    matrix = np.sum(system.blocks, axis=0) + np.diag(system.prior)
    target = np.sum(system.pulls, axis=0) + system.of_prior
    inverse = np.linalg.inv(matrix)
    numbers = inverse @ target
    determinant = float(np.linalg.slogdet(matrix)[1] - np.log(system.prior).sum())
    ratios = np.array([view.ratio for view in views])
    # The optimum stays where it is: that of the data as they are, whose variance is larger than they say.
    ratios = ratios * _disagreement(system, numbers, ratios)
    weighted = np.tensordot(ratios, np.stack(system.blocks), 1) + np.diag(system.prior)
    spread = inverse @ weighted @ inverse
    slots = [CAMERA_NUMBERS.index(name) for name in shared]
    values, covariance = np.zeros(len(CAMERA_NUMBERS)), np.zeros((len(CAMERA_NUMBERS),) * 2)
    count, rows = len(shared), system.rows
    values[slots], covariance[np.ix_(slots, slots)] = numbers[:count], spread[:count, :count]
    held = np.linalg.inv(matrix[count:, count:])
    held = held @ weighted[count:, count:] @ held
    total = rows @ spread @ rows.T
    return _Hypothesis(
        options,
        -0.5 * (system.cost - float(target @ numbers) + determinant),
        system.offsets + rows @ numbers,
        total + np.diag(ratios * system.noise),
        values,
        covariance,
        total - rows[:, count:] @ held @ rows[:, count:].T,
    )


def _system(views: Sequence[View], options: tuple[tuple[Parts, Linear], ...], shared: list[str]) -> _System:
    own = [
        [name for name in linear.names if name in numbers_of(parts) and name not in shared] for parts, linear in options
    ]
    size, begin = len(shared) + sum(map(len, own)), len(shared)
    prior, of_prior, cost = np.zeros(size), np.zeros(size), 0.0
    rows, offsets, blocks, pulls = np.zeros((len(views), size)), np.zeros(len(views)), [], []
    for place, (view, (_, linear), names) in enumerate(zip(views, options, own, strict=True)):
        design, fixed = np.zeros((len(linear.names), size)), linear.absent.copy()
        columns = {name: k for k, name in enumerate(shared)} | {name: begin + k for k, name in enumerate(names)}
        for k, name in enumerate(linear.names):
            if (column := columns.get(name)) is None:
                continue
            scale = _factor(name, view, views[0]) if name in shared else 1.0
            design[k, column], fixed[k] = scale, 0.0
            if not prior[column]:
                prior[column] = scale**2 * linear.precision[k]
                of_prior[column] = scale * linear.precision[k] * linear.centre[k]
                cost += linear.precision[k] * linear.centre[k] ** 2
        blocks.append(design.T @ linear.matrix @ design)
        pulls.append(design.T @ (linear.pull - linear.matrix @ fixed))
        cost += float(fixed @ linear.matrix @ fixed - 2 * linear.pull @ fixed) + linear.square
        rows[place], offsets[place] = -linear.slope @ design, linear.curvature - linear.slope @ fixed
        begin += len(names)
    noise = np.array([linear.noise for _, linear in options])
    return _System(len(shared), blocks, pulls, prior, of_prior, cost, rows, offsets, noise)


def _disagreement(system: _System, numbers: np.ndarray, ratios: np.ndarray) -> float:
    """By how much the pictures' own values of what they share scatter beyond their variances, 1 at least.

    Chi-squared over its degrees of freedom (Birge 1932, Phys. Rev. 40, 207); `ratios`: as those of the views.
    """
    count, pictures = system.shared, len(system.blocks)
    if not count or pictures < 2:
        return 1.0
    square, freedom, own = 0.0, 0.0, np.diag(system.prior[count:])
    total = np.zeros((count, count))
    for block, pull, ratio in zip(system.blocks, system.pulls, ratios, strict=True):
        share = np.linalg.solve(block[count:, count:] + own, block[count:, :count]).T
        matrix = block[:count, :count] - share @ block[count:, :count]
        target = pull[:count] - share @ (pull[count:] + system.of_prior[count:])
        residual = target - matrix @ numbers[:count]
        inverse = pseudo_inverse(matrix, _RANK)
        square += float(residual @ inverse @ residual) / ratio
        freedom += float(np.trace(inverse @ matrix))
        total += matrix
    # The common values take less where a prior holds them.
    freedom -= float(np.trace(np.linalg.solve(total + np.diag(system.prior[:count]), total)))
    return max(1.0, square / max(freedom, 1.0))


def _shared_names(views: Sequence[View], camera: Parts) -> list[str]:
    """The camera's numbers that are one for all pictures; where its axis is, only of frames of one shape."""
    alike = len({view.shape[:2] for view in views}) < 2
    return [name for name in numbers_of(camera) if alike or name not in AXIS]


def _mixture(
    weights: np.ndarray, means: list[np.ndarray], covariances: list[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    mean = np.tensordot(weights, means, 1)
    apart = np.stack(means) - mean
    return mean, np.tensordot(weights, covariances, 1) + (apart.T * weights) @ apart
