"""The fit of a photograph's rings: by the gap formula with the parts that it needs, and by a traced bench."""

from dataclasses import replace

import numpy as np

from fitting.estimate import FEW, Fitted, Noise, finely, frame_on, moved_to, residuals_of, robust_fit, sharpened
from fitting.model import (
    AXIS,
    PARTS,
    WARPS,
    GapModel,
    Microscope,
    microscope_on,
    numbers_of,
    plate_curvature,
    scene_start,
    sphere_of,
)
from fitting.parameters import Numbers, held_turns
from fitting.photo import Bend, Photograph, Rings, block_size, noise_variance, pixels_of, reduce, settled
from fitting.photograph.averaging import variance_of
from fitting.photograph.choice import Choice, averaged
from fitting.photograph.clusters import with_shift_to_mean
from fitting.photograph.fringe_rivals import WeakLight
from fitting.photograph.priors import Priors
from fitting.photograph.refit import with_parts
from fitting.photograph.remainder import Remainder
from fitting.photograph.selection import Complete, complete, with_needed_parts
from fitting.photograph.task import Task
from fitting.photograph.transfer import linearized, with_another_curve
from fitting.photograph.verdict import RefusedError, judge
from fitting.reasons import Reason
from newtonjax.scene import Scene

# More blocks than this are made wider, up to so many cycles of the finest fringe in one: a made picture of 29 million
# pixels has a deviation of 1.2 millionths with them, 0.9 without.
_MANY_BLOCKS, _BEARABLE = 500_000, 0.2
# Blocks to a side of the lit field, at least.
_FEWEST_BLOCKS = 64
# Shapes of cameras' frames: long over short side, and by how much they may differ.
_SHAPES, _ALIKE = (4 / 3, 3 / 2, 16 / 9, 5 / 4), 0.005


def solve(task: Task, rings: Rings) -> Choice:
    """The fit of the gap formula with the parts that it needs, on codes that follow the light."""
    priors = _priors(task)
    plain = _plain(task, rings)
    refusal = judge(plain, task.photograph, rings, task.is_guided)
    with_all = with_needed_parts(task, plain, priors, refusal)
    if not task.keeps_curve and (linear := linearized(task.photograph, with_all.fit)) is not None:
        task = replace(task, photograph=linear)
        again = with_another_curve(with_all, linear)
        if again is None:
            if task.scene is None and rings.bend is not None and _contradicts_weak_light(with_all):
                # Rings that are no circles have taken a second look already: the search anew takes longest.
                return Choice(with_all.fit, with_all.part_words, with_all.photograph)
            plain = _plain(task, rings, plain)
            refusal = judge(plain, linear, rings, task.is_guided)
            again = with_needed_parts(task, plain, priors, refusal, with_all)
        with_all = again
    choice = averaged(with_all if task.noise is None else _weighed(with_all, task.noise))
    # Weights by noise are those of the blocks that they were made for.
    found = choice.found if task.noise is not None else finely(choice.found, task.photograph)
    return with_shift_to_mean(choice._replace(found=sharpened(found)))


def _contradicts_weak_light(complete: Complete) -> bool:
    """Whether rings in weak light lie so far from where a fit continues them that there is no answer."""
    fit, photograph = complete.fit, complete.photograph
    if not fit.converged or fit.orders < FEW or photograph.dim is None:
        return False
    finding = WeakLight().finding(Remainder(fit, photograph))
    return finding is not None and finding.consequence == "refusal"


def _weighed(complete: Complete, noise: Noise) -> Complete:
    """The same fit with pixels weighed by one over their noise's variance, at the light that it says."""
    fit = finely(complete.fit, complete.photograph)
    if not fit.converged:
        return complete
    reduced = fit.reduced.weighed(noise.variance(fit, complete.photograph))

    def again(one: Fitted) -> Fitted:
        model, left = moved_to(one.model, reduced.grid), residuals_of(one.solution, reduced, None)
        start = replace(one, model=model, reduced=reduced, left=left)
        return with_parts(start, one.parts, one.numbers, complete.priors, variance_of(start)[0])

    beside = complete.runner_up
    beside = None if beside is None else (again(finely(beside[0], complete.photograph)), beside[1])
    return complete._replace(fit=again(fit), runner_up=beside)


def _plain(task: Task, rings: Rings, before: Fitted | None = None) -> Fitted:
    """A fit of the gap formula without parts; `before`: one on the same photograph with another curve."""
    # A bench has its own gap and centre.
    fixed, photograph = task.fixed if task.scene is None else {}, task.photograph
    if "centre_px" in fixed:
        rings = settled(photograph, replace(rings, centre=fixed["centre_px"]))
    reduced = reduce(photograph, _block(photograph, rings))
    frame = frame_on(reduced.grid)
    x, y = ((c - m) / frame.unit for c, m in zip(rings.centre, frame.middle, strict=True))
    phase = rings.phase
    if "gap" in fixed:
        phase = held_turns(fixed, task.quantities) + task.contact_phase
    axis = {name: task.priors[name].value for name in AXIS if name in task.priors}
    bend, parts = ({}, ()) if rings.bend is None else _bend(task, rings.bend)
    numbers = Numbers(rings.scale * frame.unit**2, x, y, phase, **axis, **bend)
    start = np.array(numbers)
    # A few fringes leave the search uncertain by as much as this.
    starts = [start, *(np.array(numbers._replace(curvature=k * numbers.curvature)) for k in (0.6, 1.6))]
    if before is not None and before.converged:
        starts[0] = before.numbers
    given = task.quantities
    side = Microscope(touching=task.contact_phase, modulo=float("gap" not in fixed))
    model = GapModel(frame_on(reduced.grid, start), sphere_of(given, rings.scale), plate_curvature(given))
    model = replace(model, microscope=microscope_on(given, numbers, frame, side))
    if not parts:
        return finely(robust_fit(model, reduced, starts, fixed), photograph)
    # Circles are not near these rings, so priors alone hold the parts, against no more than the noise.
    prior = _priors(task).of(parts, start, noise_variance(reduced.light, reduced.used))
    return finely(robust_fit(model, reduced, starts[:1], fixed, parts, prior), photograph)


def _bend(task: Task, bend: Bend) -> tuple[dict[str, float], tuple[str, ...]]:
    """Numbers of rings that are no circles, and the parts that these belong to, of those that are not excluded."""
    numbers = bend._asdict()
    parts = [part for part in WARPS if task.wishes.get(part, True) and set(PARTS[part].parameters) & set(numbers)]
    return {name: numbers[name] for name in numbers_of(parts) if name in numbers}, tuple(parts)


def _block(photograph: Photograph, rings: Rings) -> int:
    """Pixels to a side of a block that resolves the rings all over the lit field, and leaves enough of them."""
    x, y = pixels_of(photograph.lit)
    finest = 2 * rings.scale * float(np.hypot(x - rings.centre[0], y - rings.centre[1]).max())
    pixels = np.count_nonzero(photograph.mask)
    block = block_size(finest)
    if pixels > _MANY_BLOCKS * block**2:
        block = min(block_size(finest, _BEARABLE), int(np.ceil(np.sqrt(pixels / _MANY_BLOCKS))))
    return max(1, min(block, int(min(np.ptp(x), np.ptp(y))) // _FEWEST_BLOCKS))


def _priors(task: Task) -> Priors:
    is_axis_unsaid = not set(AXIS) & set(task.priors)
    return Priors(task.contact_phase, task.priors, is_axis_unsaid and _may_be_cut(task.photograph.mask.shape))


def _may_be_cut(shape: tuple[int, ...]) -> bool:
    """Whether a picture has not the shape of a camera's frame."""
    ratio = max(shape[:2]) / min(shape[:2])
    return all(abs(ratio / frame - 1) > _ALIKE for frame in _SHAPES)


def solve_bench(scene: Scene, task: Task, choice: Choice) -> Choice:
    """The fit of the traced bench next to that of the gap formula.

    Raises RefusedError where the scene does not reproduce these fringes.
    """
    gap, photograph = choice.found, choice.photograph
    frame, phase = gap.model.frame, gap.solution.fields.phase
    model, numbers = scene_start(scene, task.quantities, frame, gap.numbers, phase, task.fixed)
    bench = robust_fit(model, gap.reduced, [numbers], task.fixed)
    if not bench.explained > 0.5 * gap.explained:
        reason = Reason.SCENE_MISFIT(explained=max(bench.explained, 0.0), by_rings=gap.explained)
        raise RefusedError(reason, photograph)
    choice = averaged(complete(bench, photograph, task.wishes, _priors(task)))
    return choice if task.noise is not None else choice._replace(found=finely(choice.found, photograph))
