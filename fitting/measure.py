"""From a photograph of rings to the radius: read, find, fit, judge."""

import time
from dataclasses import replace
from functools import cache
from pathlib import Path

import jax
import numpy as np

from fitting.evidence import evidence_of
from fitting.illumination import Fitted, numbers_of, robust_fit
from fitting.matched import Rings
from fitting.models import NUMBERS, GapModel, curved_surface, frame_of
from fitting.photo import Photograph, read
from fitting.quantity import Quantities, checked_fixed, checked_plate, checked_start, held_turns, quantities
from fitting.result import FitResult
from fitting.scene_start import scene_start
from fitting.selection import Choice, adapt, checked_parts
from fitting.start import find_rings, follow, settled
from fitting.summary import refused, summarize
from fitting.transfer import linearized
from fitting.trials import WARPS
from fitting.verdict import too_steep, why_refused
from newtonjax.gap import required_gap
from newtonjax.precision import x64
from newtonjax.scene import Scene

_UNSTATED = (
    "the view was not stated: taken as Newton's rings in reflected light; one image does not tell these from "
    "transmitted ones without a known gap, nor from the rings of a Michelson interferometer"
)
# Fewer pixels hold no rings.
_FEWEST = 64


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
    mask: np.ndarray | None = None,
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
      mask: True where pixels may be used.
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
    if np.ptp(photograph.image[photograph.mask]) == 0:
        return refused("the image is uniform: there are no fringes", photograph, began)
    with x64(), _controller().limit(limits=1, user_api="blas"):
        rings = _start(photograph, known, start)
        if reason := too_steep(photograph, rings, known):
            return refused(reason, photograph, began)
        # A bench may well make fringes of many beams, or slanted ones; and a person who gives a start has seen them.
        if scene is None and not start and (reason := evidence_of(photograph, rings).reason):
            return refused(reason, photograph, began)
        held, pinned = fixed if scene is None else {}, 0.5 if view == "reflected" else 0.0
        choice = _of_gap(photograph, rings, known, view, held, wishes, pinned, scene)
        if transfer is None and (linear := linearized(photograph, choice.found)) is not None:
            photograph = linear
            choice = _of_gap(photograph, rings, known, view, held, wishes, pinned, scene)
        if reason := why_refused(choice.found, photograph, rings):
            return refused(reason, photograph, began)
        if scene is not None:
            alone = choice.found
            found = _fit_scene(photograph, scene, known, alone, fixed)
            if not found.explained > 0.5 * alone.explained:
                reason = (
                    f"the bench does not make these fringes: it explains {max(found.explained, 0):.0%} of the variance "
                    f"where rings of any size explain {alone.explained:.0%}; check the scene, and what is fixed"
                )
                return refused(reason, photograph, began)
            choice = adapt(found, photograph, wishes | {"contact": False}, pinned)
        return summarize(photograph, known, view, choice, began)


@cache
def _controller():
    # A BLAS with threads of its own spins on the cores after each product, while JAX's threads wait for them: a fit
    # takes half as long again. The products here are small.
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


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


def _start(photograph: Photograph, known: Quantities, start: dict) -> Rings:
    if not start:
        return find_rings(photograph)
    scale = start.get("fringe_scale_per_px2")
    if scale is None:
        values = known.given
        if "pixel_size" not in values or "wavelength" not in values:
            raise ValueError("start holds a radius, which needs pixel_size and wavelength; give fringe_scale_per_px2")
        scale = values.get("index", 1.0) * values["pixel_size"] ** 2 / (start["radius"] * values["wavelength"])
    return follow(photograph, Rings(float(scale), start["centre_px"], 0.0, 0.0))


def _of_gap(photograph, rings: Rings, known, view: str, fixed: dict, wishes: dict, pinned: float, scene) -> Choice:
    """A fit of the gap formula with the parts that it needs.

    A bench has parts of its own: then, as without a pixel size, where a distortion has nothing to be measured against,
    warps are tried only where the rings are not found without them.
    """
    plain = Choice(_fit_gap(photograph, rings, known, view, fixed), {})
    scaled = scene is None and known.unknown is not None
    if scaled or why_refused(plain.found, photograph, rings):
        return adapt(plain.found, photograph, wishes, pinned)
    if scene is not None:
        return plain
    choice = adapt(plain.found, photograph, dict.fromkeys(WARPS, False) | wishes, pinned)
    untried = dict.fromkeys(WARPS, "not tried: without a pixel size the image does not need it")
    return choice._replace(evidence=untried | choice.evidence)


def _fit_gap(photograph: Photograph, rings: Rings, known: Quantities, view: str, fixed: dict) -> Fitted:
    frame = frame_of(photograph.image.shape)
    model = GapModel(frame, known.sphere(rings.scale), known.plate_curvature)
    if "centre_px" in fixed:
        rings = settled(photograph, replace(rings, centre=fixed["centre_px"]))
    place = [(c - m) / frame.unit for c, m in zip(rings.centre, frame.middle, strict=True)]
    phase = rings.phase
    if "gap" in fixed:
        phase = held_turns(fixed, known) + (0.5 if view == "reflected" else 0.0)
    start = np.array([rings.scale * frame.unit**2, *place, phase, *(0.0 for _ in NUMBERS[4:])])
    # A few fringes leave the search uncertain by as much as this.
    starts = [start, *(np.array([factor * start[0], *start[1:]]) for factor in (0.6, 1.6))]
    return robust_fit(model, photograph, starts, fixed)


def _fit_scene(photograph: Photograph, scene: Scene, known: Quantities, gap: Fitted, fixed: dict) -> Fitted:
    numbers, phase = numbers_of(gap), np.asarray(gap.solution.image[2])
    model, numbers = scene_start(scene, known, frame_of(photograph.image.shape), numbers, phase, fixed)
    return robust_fit(model, photograph, [numbers], fixed)
