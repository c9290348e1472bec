"""From a photograph of rings to the radius: read, find, fit, judge."""

import time
from dataclasses import replace
from pathlib import Path

import jax
import numpy as np

from fitting.estimate import FEW, Fitted, frame_on, moved_to, robust_fit, sharpened
from fitting.finding import Rings, View, evidence_of, find_rings, follow, settled, view_of
from fitting.model import GapModel, scene_start
from fitting.parameters import (
    Numbers,
    Quantities,
    checked_fixed,
    checked_plate,
    checked_start,
    curved_surface,
    held_turns,
    one_blas_thread,
    quantities,
    says_its_origin,
)
from fitting.photo import Photograph, block_size, pixels_of, read, reduce
from fitting.photograph.light import with_richer_light
from fitting.photograph.result import FitResult
from fitting.photograph.second_look import rings_in_the_middle
from fitting.photograph.selection import Choice, adapt, checked_parts
from fitting.photograph.summary import refused, summarize
from fitting.photograph.transfer import linearized
from fitting.photograph.trials import WARPS
from fitting.photograph.verdict import too_steep, why_refused
from newtonjax.numerics import x64
from newtonjax.scene import Scene, required_gap

_UNSTATED = (
    "the view was not stated: taken as Newton's rings in reflected light; one image does not tell these from "
    "transmitted ones without a known gap, nor from the rings of a Michelson interferometer"
)
# Fewer pixels hold no rings.
_FEWEST = 64
# More blocks than this are made wider, up to so many cycles of the finest fringe in one: a made picture of 29 million
# pixels has a deviation of 1.2 millionths with them, 0.9 without.
_MANY_BLOCKS, _BEARABLE = 500_000, 0.2
# Blocks to a side of the lit field, at least; pixels up to which a fit may go on from blocks to each of them.
_FEWEST_BLOCKS, _MOST_PIXELS = 64, 1_000_000
# Fringes that explain less than this may be bent.
_HALF_FOUND = 0.7
# Correlation of residuals up to which noise is what limits a fit, and shares of the variance that no photograph leaves
# so little of, and that single precision rounds.
_WHITE, _MADE, _EXACT = 2.0, 1e-4, 1e-8


@says_its_origin
def fit(
    image: str | Path | np.ndarray | jax.Array,
    *,
    wavelength: float | None = None,
    pixel_size: float | None = None,
    radius: float | None = None,
    index: float | None = None,
    wavelength_sd: float | None = None,
    pixel_size_sd: float | None = None,
    radius_sd: float | None = None,
    index_sd: float | None = None,
    plate_radius: float | None = None,
    plate_radius_sd: float | None = None,
    view: str | None = None,
    scene: Scene | None = None,
    free: str | tuple[str, ...] | None = None,
    fixed: dict[str, float | tuple[float, float]] | None = None,
    start: dict[str, float | tuple[float, float]] | None = None,
    transfer: str | float | None = None,
    mask: str | Path | np.ndarray | None = None,
    parts: dict[str, bool] | None = None,
) -> FitResult:
    """The lens radius, or another one of radius, wavelength, pixel size and index, from an image of rings.

    Without `scene` the model is fringes localized in the gap: path difference 2 n t of the exact sphere at normal
    incidence, dark centre in contact reflected, bright transmitted. With `scene` it is that bench, traced, with its
    beams, screen and tilts. Background and contrast are smooth polynomials of the degree that the image calls for.

    Args:
      image: a file, or an array [rows, columns] or [rows, columns, channels].
      wavelength, pixel_size, radius: [m]; two of the three. Without the pixel size the answer is the fringe scale.
        With `scene` the wavelength and the index are the scene's unless given or named in `free`.
      index: of the gap's medium, 1 unless given; `free=("index",)` measures it.
      plate_radius, plate_radius_sd: of a curved plate under the lens [m], positive where it bulges towards the lens;
        the rings then are those of 1/R + 1/plate_radius, and the radius is the lens's. For shallow faces.
      wavelength_sd, pixel_size_sd, radius_sd, index_sd: standard deviations of what is given; they enter the budget.
      view: "reflected" (where it is not given, with a warning) or "transmitted"; a scene has its own.
      fixed: values held, by name: "gap" [m], "centre_px" (x, y).
      start: values to start from instead of the search, by name: "radius" [m] or "fringe_scale_per_px2", "centre_px".
      transfer: "linear", "srgb" or an exponent; see `fitting.photo.read`. Without it the usual one is taken, and an
        exponent more where the fringes have a second harmonic.
      mask: True where pixels may be used, [rows, columns]; or an image file, where it is not black.
      parts: "oblique view", "distortion", "fifth order" (of the distortion), "contact" or "film" (between the pressed
        faces), with True (there, whatever the image says) or False (not there); those not named are there where the
        image calls for them.

    What the data cannot give comes back as a status and a message. Raises ValueError and FileNotFoundError for input
    that cannot be used.

    """
    began = time.perf_counter()
    stated = view is not None or scene is not None
    view = view or "reflected"
    if view not in ("reflected", "transmitted"):
        raise ValueError(f"view is {view!r}; allowed: 'reflected' or 'transmitted'")
    wishes = checked_parts(parts)
    free = (free,) if isinstance(free, str) else tuple(free or ())
    fixed, start = checked_fixed(fixed), checked_start(start)
    known = _known(locals(), scene)
    if plate := checked_plate(plate_radius, plate_radius_sd):
        if scene is not None or known.unknown != "radius":
            raise ValueError("plate_radius goes with wavelength and pixel_size, and no scene; leave it out")
        known = replace(known, plate=plate)
    if scene is not None:
        view = scene.view
    photograph = read(np.asarray(image) if isinstance(image, jax.Array) else image, transfer, mask)
    if not stated:
        photograph.warnings.append(_UNSTATED)
    if (usable := int(photograph.mask.sum())) < _FEWEST:
        reason = f"{usable} pixels of {photograph.mask.size} can be used: the image is saturated, dark or masked"
        return refused(reason, photograph, began)
    if photograph.is_uniform:
        return refused("the image is uniform: there are no fringes", photograph, began)
    guided = bool(fixed or start)
    with x64(), one_blas_thread():
        coarse = view_of(photograph)
        rings = _start(photograph, known, start, coarse)
        if reason := too_steep(photograph, rings, known):
            return refused(reason, photograph, began)
        # A bench may well make fringes of many beams, or slanted ones; and a person who gives a start has seen them.
        if scene is None and not start and (reason := evidence_of(photograph, rings, coarse).reason):
            if (middle := rings_in_the_middle(photograph)) is None:
                return refused(reason, photograph, began)
            photograph, rings = middle
        held, pinned = fixed if scene is None else {}, 0.5 if view == "reflected" else 0.0
        plain = _plain(photograph, rings, known, view, held)
        choice = _of_gap(plain, photograph, rings, known, wishes, pinned, scene, guided)
        if transfer is None and (linear := linearized(photograph, choice.found)) is not None:
            photograph = linear
            plain = _plain(photograph, rings, known, view, held, plain)
            choice = _of_gap(plain, photograph, rings, known, wishes, pinned, scene, guided, choice.found)
        choice = choice._replace(found=sharpened(finely(choice.found, photograph)))
        if reason := why_refused(choice.found, photograph, rings, guided):
            return refused(reason, photograph, began)
        if scene is not None:
            alone = choice.found
            found = _fit_scene(scene, known, alone, fixed)
            if not found.explained > 0.5 * alone.explained:
                reason = (
                    f"the bench does not make these fringes: it explains {max(found.explained, 0):.0%} of the variance "
                    f"where rings of any size explain {alone.explained:.0%}; check the scene, and what is fixed"
                )
                return refused(reason, photograph, began)
            choice = adapt(found, photograph, wishes | {"contact": False}, pinned)
            choice = choice._replace(found=finely(choice.found, photograph))
        if choice.found.orders < FEW:
            choice = with_richer_light(choice)
        return summarize(photograph, known, view, choice, began)


def _known(arguments: dict, scene: Scene | None) -> Quantities:
    given = {name: arguments[name] for name in ("radius", "wavelength", "pixel_size", "index")}
    sd = {name: arguments[f"{name}_sd"] for name in given}
    free = arguments["free"]
    if set(free) - set(given):
        raise ValueError(f"free is {free}; allowed: radius, wavelength, pixel_size or index")
    if scene is None:
        given["index"] = 1.0 if given["index"] is None else given["index"]
        return quantities(given, sd, free)
    curved_surface(scene)  # refuses what a fit cannot take before the image is read
    for name, value in (("wavelength", scene.wavelength), ("index", scene.media[required_gap(scene) + 1])):
        given[name] = float(value) if given[name] is None else given[name]
    known = quantities(given, sd, free)
    if known.unknown is None:
        raise ValueError("with a scene, give the pixel size, or the radius to measure the pixel size by")
    return known


def _start(photograph: Photograph, known: Quantities, start: dict, view: View) -> Rings:
    if not start:
        return find_rings(photograph, view)
    scale = start.get("fringe_scale_per_px2")
    if scale is None:
        values = known.given
        if "pixel_size" not in values or "wavelength" not in values:
            raise ValueError("start holds a radius, which needs pixel_size and wavelength; give fringe_scale_per_px2")
        scale = values.get("index", 1.0) * values["pixel_size"] ** 2 / (start["radius"] * values["wavelength"])
    return follow(photograph, Rings(float(scale), start["centre_px"], 0.0, 0.0))


def _plain(
    photograph: Photograph, rings: Rings, known: Quantities, view: str, fixed: dict, before: Fitted | None = None
) -> Fitted:
    """A fit of the gap formula without parts; `before`: one on the same photograph with another curve."""
    return finely(_fit_gap(photograph, rings, known, view, fixed, before), photograph)


def _of_gap(
    plain: Fitted, photograph, rings: Rings, known, wishes: dict, pinned: float, scene, guided: bool, before=None
) -> Choice:
    """A fit of the gap formula with the parts that it needs, next to one without.

    A bench has parts of its own: then, as without a pixel size, where a distortion has nothing to be measured against,
    warps are tried only where the rings are not found without them: where a fit is refused, or leaves more than twice
    what is left with them.
    """
    scaled = scene is None and known.unknown is not None
    refused_plain = "" if scaled else why_refused(plain, photograph, rings, guided)
    if refused_plain and plain.orders < FEW and not any(wishes.values()):
        # Parts may imitate whatever so few fringes leave over.
        return Choice(plain, {})
    if scaled or refused_plain:
        return adapt(plain, photograph, wishes, pinned, before)
    if scene is not None:
        return Choice(plain, {})
    # What an earlier choice has needed, the same photograph with another curve needs too, however much is explained.
    if before is not None and any(part in before.parts for part in WARPS):
        warped = adapt(plain, photograph, wishes, pinned, before)
        if _halves(warped.found, plain):
            return warped
    choice = adapt(plain, photograph, dict.fromkeys(WARPS, False) | wishes, pinned, before)
    if choice.found.explained < _HALF_FOUND:
        warped = adapt(plain, photograph, wishes, pinned, before)
        if _halves(warped.found, choice.found):
            return warped
    untried = dict.fromkeys(WARPS, "not tried: without a pixel size the image does not need it")
    return choice._replace(evidence=untried | choice.evidence)


def _halves(found: Fitted, other: Fitted) -> bool:
    """Whether a fit leaves less than half of what another one leaves."""
    return found.converged and 1 - found.explained < 0.5 * (1 - other.explained)


def _fit_gap(
    photograph: Photograph, rings: Rings, known: Quantities, view: str, fixed: dict, before: Fitted | None
) -> Fitted:
    if "centre_px" in fixed:
        rings = settled(photograph, replace(rings, centre=fixed["centre_px"]))
    reduced = reduce(photograph, _block(photograph, rings))
    frame = frame_on(reduced.grid)
    place = [(c - m) / frame.unit for c, m in zip(rings.centre, frame.middle, strict=True)]
    phase = rings.phase
    if "gap" in fixed:
        phase = held_turns(fixed, known) + (0.5 if view == "reflected" else 0.0)
    curvature = rings.scale * frame.unit**2
    start = np.array(Numbers(curvature=curvature, centre_x=place[0], centre_y=place[1], phase=phase))
    # A few fringes leave the search uncertain by as much as this.
    starts = [start, *(np.array(Numbers(*start)._replace(curvature=factor * curvature)) for factor in (0.6, 1.6))]
    if before is not None and before.converged:
        starts[0] = before.numbers
    model = GapModel(frame_on(reduced.grid, start), known.sphere(rings.scale), known.plate_curvature)
    return robust_fit(model, reduced, starts, fixed)


def _block(photograph: Photograph, rings: Rings) -> int:
    """Pixels to a side of a block that resolves the rings all over the lit field, and leaves enough of them."""
    x, y = pixels_of(photograph.lit)
    finest = 2 * rings.scale * float(np.hypot(x - rings.centre[0], y - rings.centre[1]).max())
    pixels = np.count_nonzero(photograph.mask)
    block = block_size(finest)
    if pixels > _MANY_BLOCKS * block**2:
        block = min(block_size(finest, _BEARABLE), int(np.ceil(np.sqrt(pixels / _MANY_BLOCKS))))
    return max(1, min(block, int(min(np.ptp(x), np.ptp(y))) // _FEWEST_BLOCKS))


def finely(found: Fitted, photograph: Photograph) -> Fitted:
    """The fit on every pixel for itself where blocks lose something: a tenth of the deviation that noise alone makes.

    Of most photographs other errors outweigh that by far. What leaves next to nothing over was no photograph: then in
    double precision.
    """
    reduced, left = found.reduced, 1 - found.explained
    white = left < _MADE or found.correlation < _WHITE
    exact = left < _EXACT
    done = reduced.grid.block == 1 and not (exact and reduced.light.dtype == np.float32)
    if done or not white or reduced.pixels > _MOST_PIXELS:
        return found
    pixels = reduce(photograph, 1, dtype=np.float64 if exact else np.float32)
    model = moved_to(found.model, pixels.grid)
    again = robust_fit(model, pixels, [found.numbers], found.fixed, found.parts)
    return again if again.converged or not found.converged else found


def _fit_scene(scene: Scene, known: Quantities, gap: Fitted, fixed: dict) -> Fitted:
    frame, phase = gap.model.frame, gap.solution.fields.phase
    model, numbers = scene_start(scene, known, frame, gap.numbers, phase, fixed)
    return robust_fit(model, gap.reduced, [numbers], fixed)
