"""From a photograph of rings to the radius: read, find, solve, judge, report."""

import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import jax
import numpy as np

from fitting.estimate import FEW, Fitted, finely, frame_on, robust_fit, sharpened
from fitting.model import AXIS, GapModel, Microscope, microscope_on, scene_start
from fitting.parameters import (
    AbstractResult,
    Numbers,
    Progress,
    held_turns,
    one_blas_thread,
    progress_of,
    says_its_origin,
)
from fitting.photo import (
    Photograph,
    Rings,
    block_size,
    evidence_of,
    find_rings,
    follow,
    pixels_of,
    reduce,
    settled,
    view_of,
)
from fitting.photograph.colours import fit_channels
from fitting.photograph.further_lines import further_lines
from fitting.photograph.light import with_richer_light
from fitting.photograph.light_words import light_of
from fitting.photograph.priors import Priors
from fitting.photograph.result import FitResult
from fitting.photograph.second_look import rings_in_the_middle
from fitting.photograph.selection import (
    Choice,
    Complete,
    at_the_mean,
    averaged,
    complete,
    with_another_curve,
    without_parts,
)
from fitting.photograph.summary import report
from fitting.photograph.task import Task, task_of
from fitting.photograph.transfer import linearized
from fitting.photograph.verdict import RefusedError, judge, too_steep, why_refused
from fitting.reasons import Reason
from newtonjax.numerics import x64
from newtonjax.scene import Scene, Spectrum

# More blocks than this are made wider, up to so many cycles of the finest fringe in one: a made picture of 29 million
# pixels has a deviation of 1.2 millionths with them, 0.9 without.
_MANY_BLOCKS, _BEARABLE = 500_000, 0.2
# Blocks to a side of the lit field, at least.
_FEWEST_BLOCKS = 64
# Shapes of cameras' frames: long over short side, and by how much they may differ.
_SHAPES, _ALIKE = (4 / 3, 3 / 2, 16 / 9, 5 / 4), 0.005


@says_its_origin
def fit(
    image: str | Path | np.ndarray | jax.Array,
    *,
    wavelength: float | str | None = None,
    pixel_size: float | None = None,
    radius: float | None = None,
    gap_index: float | None = None,
    wavelength_sd: float | str | None = None,
    pixel_size_sd: float | str | None = None,
    radius_sd: float | str | None = None,
    gap_index_sd: float | str | None = None,
    plate_radius: float | None = None,
    plate_radius_sd: float | str | None = None,
    view: str | None = None,
    scene: Scene | None = None,
    free: str | tuple[str, ...] | None = None,
    fixed: dict[str, float | tuple[float, float]] | None = None,
    start: dict[str, float | tuple[float, float]] | None = None,
    transfer: str | float | None = None,
    mask: str | Path | np.ndarray | None = None,
    parts: dict[str, bool] | None = None,
    page: int | None = None,
    scale: AbstractResult | str | Path | None = None,
    priors: Mapping[str, tuple[float, float | str]] | None = None,
    axis_px: tuple[float, float] | None = None,
    axis_px_sd: float | None = None,
    view_angle: float | None = None,
    view_angle_sd: float | str | None = None,
    light: str | Spectrum | None = None,
    channel: str | None = None,
    progress: Progress = None,
) -> FitResult:
    """The lens radius, or another one of radius, wavelength, pixel size and gap index, from an image of rings.

    Without `scene` the model is fringes localized in the gap: path difference 2 n t of the exact sphere at normal
    incidence, dark centre in contact reflected, bright transmitted. With `scene` it is that bench, traced, with its
    beams, screen and tilts. Background and contrast are smooth polynomials of the degree that the image calls for.

    Args:
      image: a file, or an array [rows, columns] or [rows, columns, channels].
      wavelength, pixel_size, radius: [m]; two of the three. Without the pixel size the answer is the fringe scale.
        With `scene` the wavelength and gap_index are the scene's unless given or named in `free`.
      gap_index: of the gap's medium, 1 unless given; `free=("gap_index",)` measures it.
      plate_radius, plate_radius_sd: of a curved plate under the lens [m], positive where it bulges towards the lens;
        the rings then are those of 1/R + 1/plate_radius, and the radius is the lens's. For shallow faces.
      wavelength_sd, pixel_size_sd, radius_sd, gap_index_sd: standard deviations of what is given, as numbers or as
        percentages ("0.1%"); they enter the budget.
      view: "reflected" (where it is not given, with a warning) or "transmitted"; a scene has its own.
      fixed: values held, by name: "gap" [m], "centre_px" (x, y).
      start: values to start from instead of the search, by name: "radius" [m] or "fringe_scale_per_px2", "centre_px".
      transfer: "linear", "srgb" or an exponent; see `fitting.photo.read`. Without it the usual one is taken, and an
        exponent more where the fringes have a second harmonic.
      mask: True where pixels may be used, [rows, columns]; or an image file, where it is white (brighter than half).
      parts: "oblique_view", "distortion", "fifth_order" (of the distortion), "contact" or "film" (between the pressed
        faces) by name: True forces a part on, with what it needs (a fifth order the distortion, a film the contact),
        False excludes it; for a part that is not named the image decides (Schwarz's criterion).
      page: of a file with several pictures, from 1 on; the first, with a warning, where it is not given.
      scale: in place of pixel_size and pixel_size_sd, a result of `fitting.scale` of the same camera, or of `fit` with
        the radius of another lens given (its pixel size and standard deviation alone), or the JSON file of one. A
        grid's distortion is a prior of the fit's; rings that are stretched otherwise than the grid are warned of.
      priors: (value, standard deviation) of numbers of parts in place of the defaults, by name, such as
        {"distortion": (0.0, 0.02)}: "stretch", "shear", "distortion", "distortion_fifth_order", "axis_x", "axis_y" and
        the terms of the lens's form, "coma_x" to "tetrafoil_y"; the deviation also as a percentage of the value. They
        are normal. A part of whose numbers something is said is there for certain, but for an axis alone.
      axis_px, axis_px_sd: where the camera's axis is in the picture, (x, y) [px], of one that has been cut out of a
        larger one: in its middle unless given; the deviation of x and y is 1.5 % of half a diagonal unless given. The
        pixel size and the scale are those on the axis.
      view_angle, view_angle_sd: against the normal [rad], which way nobody knows. Elliptic rings are those of a view at
        an angle, or of a lens with two radii: with 0 they are the lens's. The result then has "radius_along" of the
        steeper meridian, "radius_across" and "astigmatism_axis" among its parameters, and the radius is that of their
        mean curvature; without, it is their geometric mean, and what is undecided is in the budget.
      light: in place of the wavelength, a lamp whose lines the rings are of, in the words of `newtonjax.lamp` or as a
        Spectrum: all channels are fitted together, each with amplitudes of its own for the lamp's lines and for bands.
        A lamp's name given as wavelength means the same. The fringe scale is that of the line nearest to 555 nm.
      channel: "red", "green" or "blue"; without it the one with the clearest rings.
      progress: True for a bar on the terminal, or a function of (steps done, their number).

    What the data cannot give comes back as a status and a message. Raises ValueError and FileNotFoundError for input
    that cannot be used.

    """
    arguments, began = locals(), time.perf_counter()
    try:
        is_of_lines = light is not None or isinstance(wavelength, str)
        light_given = light_of(arguments) if is_of_lines else None
        if light_given is not None:
            arguments["wavelength"] = light_given.reference
        task = task_of(arguments)
        # Reading has loaded SciPy, whose threads are to be limited too.
        with x64(runs_programs=scene is not None), one_blas_thread(), progress_of(progress, "fitting") as done:
            done(1, 4)
            task, rings = find(task)
            done(2, 4)
            if light_given is not None:
                result = fit_channels(task, rings, light_given, arguments, began)
                done(4, 4)
                return result
            choice = solve(task, rings)
            done(3, 4)
            judge(choice.found, choice.photograph, rings, task.is_guided)
            if task.scene is not None:
                choice = solve_bench(task.scene, task, choice)
            if choice.found.orders < FEW:
                choice = with_richer_light(choice)
            result = report(task, choice, began, partial(further_lines, task, rings, arguments))
            done(4, 4)
            return result
    except RefusedError as refusal:
        seconds = time.perf_counter() - began
        return FitResult("refused", refusal.reason, warnings=list(refusal.photograph.warnings), seconds=seconds)


def find(task: Task) -> tuple[Task, Rings]:
    """The rings of a photograph, and the task, whose photograph may be cut to where they are clear.

    Raises RefusedError where nothing speaks for rings, or they are larger than the lens that makes them.
    """
    photograph, coarse = task.photograph, view_of(task.photograph)
    rings = follow(photograph, _given_rings(task)) if task.start else find_rings(photograph, coarse)
    if reason := too_steep(photograph, rings, task.quantities):
        raise RefusedError(reason, photograph)
    # A bench may well make fringes of many beams, or slanted ones; and a person who gives a start has seen them.
    if task.scene is None and not task.start and (reason := evidence_of(photograph, rings, coarse).reason):
        if (middle := rings_in_the_middle(photograph)) is None:
            raise RefusedError(reason, photograph)
        photograph, rings = middle
    return replace(task, photograph=photograph), rings


def _given_rings(task: Task) -> Rings:
    scale, values = task.start.get("fringe_scale_per_px2"), task.quantities.given
    if scale is None:
        if "pixel_size" not in values or "wavelength" not in values:
            raise ValueError("start holds a radius, which needs pixel_size and wavelength; give fringe_scale_per_px2")
        scale = values.get("gap_index", 1.0) * values["pixel_size"] ** 2 / (task.start["radius"] * values["wavelength"])
    return Rings(float(scale), task.start["centre_px"], 0.0, 0.0)


def solve(task: Task, rings: Rings) -> Choice:
    """The fit of the gap formula with the parts that it needs, on codes that follow the light."""
    plain = _plain(task, rings)
    with_all = _with_parts(task, rings, plain)
    if not task.keeps_curve and (linear := linearized(task.photograph, with_all.fit)) is not None:
        task = replace(task, photograph=linear)
        again = with_another_curve(with_all, linear)
        with_all = again or _with_parts(task, rings, _plain(task, rings, plain), with_all)
    choice = averaged(with_all)
    return at_the_mean(choice._replace(found=sharpened(finely(choice.found, task.photograph))))


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
    numbers = Numbers(rings.scale * frame.unit**2, x, y, phase, **axis)
    start = np.array(numbers)
    # A few fringes leave the search uncertain by as much as this.
    starts = [start, *(np.array(numbers._replace(curvature=k * numbers.curvature)) for k in (0.6, 1.6))]
    if before is not None and before.converged:
        starts[0] = before.numbers
    given = task.quantities
    side = Microscope(touching=task.contact_phase, modulo=float("gap" not in fixed))
    model = GapModel(frame_on(reduced.grid, start), given.sphere(rings.scale), given.plate_curvature)
    model = replace(model, microscope=microscope_on(given, numbers, frame, side))
    return finely(robust_fit(model, reduced, starts, fixed), photograph)


def _block(photograph: Photograph, rings: Rings) -> int:
    """Pixels to a side of a block that resolves the rings all over the lit field, and leaves enough of them."""
    x, y = pixels_of(photograph.lit)
    finest = 2 * rings.scale * float(np.hypot(x - rings.centre[0], y - rings.centre[1]).max())
    pixels = np.count_nonzero(photograph.mask)
    block = block_size(finest)
    if pixels > _MANY_BLOCKS * block**2:
        block = min(block_size(finest, _BEARABLE), int(np.ceil(np.sqrt(pixels / _MANY_BLOCKS))))
    return max(1, min(block, int(min(np.ptp(x), np.ptp(y))) // _FEWEST_BLOCKS))


def _with_parts(task: Task, rings: Rings, plain: Fitted, before: Complete | None = None) -> Complete:
    """A fit of the gap formula with all parts that may be there.

    A bench has parts of its own: then they are tried only where the rings are not found without them. What a grid says
    of the camera is there for certain.
    """
    photograph, wishes, priors = task.photograph, task.wishes, _priors(task)
    is_refused = bool(why_refused(plain, photograph, rings, task.is_guided))
    are_few = is_refused and plain.orders < FEW and not any(wishes.values())
    if are_few or (task.scene is not None and not is_refused):
        return without_parts(plain, photograph, priors)
    return complete(plain, photograph, wishes, priors, before)


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
    return choice._replace(found=finely(choice.found, photograph))
