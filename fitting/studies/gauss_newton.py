"""Fits of an image to a bench by Gauss and Newton's method, in NumPy: several side by side, and nothing is compiled.

A fit holds some numbers of the bench off the scene's own. They move there in stages, so that the fringes move by half a
turn at most in each, and the fit follows them (continuation: Allgower and Georg 2003, Introduction to Numerical
Continuation Methods, chapter 2). Where the misfit's gradient is zero the numbers' derivatives are those of
`fitting.studies.implicit`.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from fitting.parameters import Knob
from fitting.studies.electrons import Moves, moved, tables, weights
from fitting.studies.pixel_sums import Equations, equations, image_of, slopes_of
from newtonjax.methods import Chebyshev, unreached
from newtonjax.numerics import jets
from newtonjax.scene import Camera, Scene

# Stages at most; steps of Gauss and Newton in each; of a stage the last step, over what the numbers have moved, or, for
# numbers that the image hardly determines and rounding moves by more, over their standard deviations.
STAGES, STEPS = 8, 12
SETTLED, UNSEEN = 1e-9, 1e-7
# Of normal equations with a unit diagonal the least eigenvalue, over their number, that is no rounding.
ROUNDING = 1e-13
# Rays that go side by side, about: their tangents stay in the cache.
_RAYS = 1 << 10


class Problem(NamedTuple):
    """What the fits of a bench share.

    - `scene`, `camera`: where the search starts; `moves`, `scales`: of its numbers; the first `free` of them are found.
    - `positive`: values of the free numbers of which only ratios mean something, in their scales; 0 for the others.
    - `nodes`: to a side; `image`: the scene's own, without noise [photoelectrons]; `weight`: of the pixels.
    """

    scene: Scene
    camera: Camera
    moves: Moves
    scales: Float[np.ndarray, " numbers"]
    free: int
    positive: Float[np.ndarray, " free"]
    nodes: int
    image: Float[np.ndarray, "rows columns"]
    weight: Float[np.ndarray, "rows columns"]


class Solution(NamedTuple):
    """Where fits end: steps of the free numbers in their scales, misfit, and whether the fit converged.

    `ended`: False of a fit that was left when another one had failed.
    """

    steps: Float[np.ndarray, "fits free"]
    misfit: Float[np.ndarray, " fits"]
    converged: Bool[np.ndarray, " fits"]
    ended: Bool[np.ndarray, " fits"]


class Slopes(NamedTuple):
    """Derivatives of a fit's steps and of its misfit, by the image [photoelectrons] and by the held numbers' steps."""

    steps_by_image: Float[Any, "free rows columns"]
    steps_by_held: Float[Any, "free held"]
    misfit_by_image: Float[Any, "rows columns"]
    misfit_by_held: Float[Any, " held"]


def perfect_image(scene: Scene, camera: Camera, nodes: int) -> Float[np.ndarray, "rows columns"]:
    """The noise-free image [photoelectrons]. Raises ValueError where beams miss a node."""
    table, reached = tables([(scene, camera, {})], nodes, 1)
    if not reached.all():
        raise unreached(Chebyshev(nodes))
    return image_of(table.value[0], camera.shape)


def problem(
    scene: Scene, camera: Camera, numbers: Sequence[Knob], free: int, noise: float | None, nodes: int
) -> Problem:
    """The fit of the first `free` numbers, weighted by the noise of the scene's own image."""
    moves = tuple((number.name, number.move) for number in numbers)
    scales = np.array([number.scale for number in numbers])
    image = perfect_image(scene, camera, nodes)
    positive = np.array([number.value / number.scale if number.positive else 0.0 for number in numbers[:free]])
    return Problem(scene, camera, moves, scales, free, positive, nodes, image, weights(image, camera, noise))


def solve(
    problem: Problem,
    data: Float[np.ndarray, "rows columns"],
    held: Float[np.ndarray, "fits held"],
    until_failure: bool = False,
) -> Solution:
    """Fits of one image [photoelectrons], each with its own steps of the held numbers, in their scales.

    `until_failure`: where one fails, leave those that are still under way.
    """
    # What a step too far computes is looked at afterwards.
    with np.errstate(all="ignore"):
        fits = _begun(problem, data, held)
        together = max(1, _RAYS // problem.nodes**2)
        while going := [fit for fit in fits if fit.goes_on]:
            if until_failure and any(fit.failed for fit in fits):
                break
            for first in range(0, len(going), together):
                _step(problem, data, going[first : first + together])
        steps = np.array([fit.at for fit in fits])
        # An exposure that has gone to nothing leaves no image to tell anything.
        vanishes = (abs(problem.positive + steps) <= SETTLED * abs(problem.positive)) & (problem.positive != 0)
        converged = ~vanishes.any(axis=1) & [fit.stage > fit.stages and _is_determined(fit.matrix) for fit in fits]
        misfit, ended = (np.array(each) for each in zip(*[(fit.misfit, not fit.goes_on) for fit in fits], strict=True))
        return Solution(np.where(converged[:, None], steps, np.nan), misfit, converged, ended)


def slopes(
    problem: Problem,
    data: Float[np.ndarray, "rows columns"],
    steps: Float[np.ndarray, " free"],
    held: Float[np.ndarray, " held"],
) -> Slopes:
    """By the implicit function theorem, where a fit has converged."""
    place, free, shape = np.concatenate([steps, held]), problem.free, problem.camera.shape
    every, count = np.eye(len(place)), len(place) + 1
    twice = jets.variable(place, every, 1, 3) + jets.variable(np.zeros(len(place)), every, 2, 3)
    bench = moved(problem.scene, problem.camera, problem.moves, twice, problem.scales)
    parts = jets.full(tables([bench], problem.nodes, 3)[0], (1, count, count)).parts[0, :, :, 0]
    table, changes = parts[0, 0], parts[1:, 0]
    normal = equations(table, changes, shape, lambda _, rows: problem.weight[rows], data, parts[1:, 1:])
    inverse = _least(normal.matrix[:free, :free], np.eye(free))
    weighted = slopes_of(table, changes[:free], shape) * problem.weight
    by_image, by_held = np.tensordot(inverse, weighted, 1), -inverse @ normal.matrix[:free, free:]
    # What is left of the gradient, rounding, moves the misfit with the steps: at the minimum itself it is 0.
    rounding = normal.gradient[:free]
    return Slopes(
        by_image,
        by_held,
        problem.weight * (data - image_of(table, shape)) + np.tensordot(rounding, by_image, 1),
        normal.gradient[free:] + rounding @ by_held,
    )


class _Fit:
    """A fit under way: its steps, the stage it is at, and how many steps it has taken there."""

    def __init__(self, at: np.ndarray, held: np.ndarray, stage: int, stages: int):
        self.at, self.held, self.stage, self.stages = at, held, stage, stages
        self.taken, self.misfit = 0, np.nan
        self.matrix = np.zeros((len(at), len(at)))

    @property
    def goes_on(self) -> bool:
        return self.stage <= self.stages and self.taken < STEPS

    @property
    def failed(self) -> bool:
        return self.stage <= self.stages and not self.goes_on

    @property
    def place(self) -> np.ndarray:
        return np.concatenate([self.at, self.held * (self.stage / max(self.stages, 1))])

    def give_up(self) -> None:
        self.taken = STEPS

    def step(self, normal: Equations) -> None:
        """One step of Gauss and Newton; into the next stage where it is a small one."""
        free = len(self.at)
        if not (np.isfinite(normal.matrix).all() and np.isfinite(normal.gradient).all()):
            self.give_up()
            return
        self.matrix, self.misfit = normal.matrix[:free, :free], normal.misfit
        move = _least(self.matrix, normal.gradient[:free])
        self.at = self.at - move
        settled = bool(abs(move).max() <= SETTLED * max(abs(self.at).max(), 1e-2))
        settled |= bool(move @ self.matrix @ move <= UNSEEN**2)
        self.taken = 0 if settled else self.taken + 1
        if settled and self.stage < self.stages:
            # The fringes of the next stage are met where this one's slopes put them: else it may miscount them.
            self.at = self.at - _least(self.matrix, normal.matrix[:free, free]) / self.stages
        self.stage += settled


def _begun(problem: Problem, data, held) -> list[_Fit]:
    """The fits after their common first stage, in which nothing is off: it has the slopes by every held number."""
    free, numbers = problem.free, len(problem.scales)
    base = _Fit(np.zeros(free), np.zeros(numbers - free), 0, 0)
    ((normal, changes),) = _looks(problem, data, [base.place], [np.eye(numbers)])
    phases = changes[free:, 2]
    base.step(normal)
    while base.goes_on:
        ((normal, _),) = _looks(problem, data, [base.place], [np.eye(numbers)])
        base.step(normal)
    if base.stage == 0 or numbers == free:
        return [base] * len(held)
    turns = abs(np.tensordot(held, phases, 1)).sum(axis=(1, 2))
    stages = np.clip(np.ceil(2 * turns), 1, STAGES).astype(int)
    follow = _least(base.matrix, normal.matrix[:free, free:] @ held.T).T / stages[:, None]
    return [_Fit(*fit) for fit in zip(base.at - follow, held, [1] * len(held), stages.tolist(), strict=True)]


def _step(problem: Problem, data, fits: list[_Fit]) -> None:
    # Tangents by the free numbers, and along the way of the held ones.
    along = [np.zeros((problem.free + 1, len(problem.scales))) for _ in fits]
    for tangents, fit in zip(along, fits, strict=True):
        tangents[:-1, : problem.free] = np.eye(problem.free)
        tangents[-1, problem.free :] = fit.held
    for fit, (normal, _) in zip(fits, _looks(problem, data, [fit.place for fit in fits], along), strict=True):
        fit.step(normal)


def _looks(problem: Problem, data, places, tangents) -> list[tuple[Equations, np.ndarray]]:
    """Normal equations at places, by tangents [tangents, numbers] at each, and the coefficients' derivatives.

    Where beams miss a node the equations are no numbers.
    """
    benches = [
        moved(problem.scene, problem.camera, problem.moves, jets.variable(place, along, 1, 2), problem.scales)
        for place, along in zip(places, tangents, strict=True)
    ]
    coefficients, reached = tables(benches, problem.nodes, 2)
    parts = jets.full(coefficients, (1, 1 + len(tangents[0]))).parts[0]
    looks = []
    for k, is_reached in enumerate(reached):
        table, changes = parts[0, k], np.where(is_reached, parts[1:, k], np.nan)
        sums = equations(table, changes, problem.camera.shape, lambda _, rows: problem.weight[rows], data)
        looks.append((sums, changes))
    return looks


def _is_determined(matrix: np.ndarray) -> bool:
    """Whether normal equations determine every number."""
    size = np.diag(matrix)
    if not np.all(size > 0):
        return False
    unit = 1 / np.sqrt(size)
    return bool(np.linalg.eigvalsh(matrix * np.outer(unit, unit))[0] > ROUNDING * len(matrix))


def _least(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Matrix x = right by least squares: of what is not determined it takes nothing."""
    size = np.sqrt(np.maximum(abs(np.diag(matrix)), 1e-300))
    by = size.reshape(-1, *[1] * (right.ndim - 1))
    return np.linalg.lstsq(matrix / np.outer(size, size), right / by, rcond=1e-12)[0] / by
