"""From a photograph of rings to the radius: read, find, fit, judge."""

import time
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

from fitting import least_squares as ls
from fitting.models import GapModel, SceneModel, as_arrays, curved_surface, frame_of, localize
from fitting.moments import Moments, moments, synthesize
from fitting.photo import Photograph, read
from fitting.quantity import Quantities, quantities
from fitting.result import FitResult
from fitting.scene_start import scene_start
from fitting.start import Rings, find_rings, follow, plane_wave, thin
from fitting.summary import refused, summarize
from newtonjax.gap import required_gap
from newtonjax.precision import x64
from newtonjax.scene import Scene

# A reference phase this close to the optimum everywhere [turns] makes the moments exact to rounding.
_NEAR = 0.1
# A tangent that misses the model by less [turns] moves no radius: a thousandth of what noise does to a phase.
_STRAIGHT = 1e-7
_ROUNDS = 8
# Share of pixels beyond four standard deviations from which on they are outliers (a normal distribution: 6e-5).
_OUTLIERS = 1e-3


@dataclass(frozen=True)
class Fitted:
    """A finished least-squares fit and what it was made of."""

    model: GapModel | SceneModel
    solution: ls.Solution
    kept: Moments
    weights: np.ndarray
    shape: tuple[int, int]

    @cached_property
    def fitted(self) -> np.ndarray:
        """The model at every pixel [rows, columns]."""
        return np.asarray(synthesize(*self.solution.image, self.weights.shape))


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
    view: str = "reflected",
    scene: Scene | None = None,
    free: tuple[str, ...] = (),
    fixed: dict[str, float | tuple[float, float]] | None = None,
    start: dict[str, float | tuple[float, float]] | None = None,
    transfer: str | float | None = None,
    mask: np.ndarray | None = None,
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
      wavelength_sd, pixel_size_sd, radius_sd, index_sd: standard deviations of what is given; they enter the budget.
      view: "reflected" or "transmitted", for the gap's sign convention; a scene has its own.
      fixed: values held, by name: "gap" [m], "centre_px" (x, y).
      start: values to start from instead of the search, by name: "radius" [m] or "fringe_scale_per_px2", "centre_px".
      transfer: "linear", "srgb" or an exponent; see `fitting.photo.read`.
      mask: True where pixels may be used.

    What the data cannot give comes back as a status and a message. Raises ValueError and FileNotFoundError for input
    that cannot be used.

    """
    began = time.perf_counter()
    if view not in ("reflected", "transmitted"):
        raise ValueError(f"view is {view!r}; allowed: 'reflected' or 'transmitted'")
    known = _known(locals(), scene)
    if scene is not None:
        view = scene.view
    photograph = read(np.asarray(image) if isinstance(image, jax.Array) else image, transfer, mask)
    if np.ptp(photograph.image[photograph.mask]) == 0:
        return refused("the image is uniform: there are no fringes", photograph, began)
    with x64(), _controller().limit(limits=1, user_api="blas"):
        rings = _start(photograph, known, start)
        found = _fit_gap(photograph, rings, known, view, fixed or {} if scene is None else {})
        reason = _why_refused(found, photograph, rings)
        if reason:
            return refused(reason, photograph, began)
        if scene is not None:
            found = _fit_scene(photograph, scene, known, found, fixed or {})
        return summarize(photograph, known, view, found, began)


@cache
def _controller():
    # A BLAS with threads of its own spins on the cores after each product, while JAX's threads wait for them: a fit
    # takes half as long again. The products here are small.
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def _known(arguments: dict, scene: Scene | None) -> Quantities:
    given = {name: arguments[name] for name in ("radius", "wavelength", "pixel_size", "index")}
    sd = {name: arguments[f"{name}_sd"] for name in given}
    free = tuple(arguments["free"])
    if set(free) - set(given):
        raise ValueError(f"free is {free}; allowed: radius, wavelength, pixel_size or index")
    for name, allowed in (("fixed", {"gap", "centre_px"}), ("start", {"radius", "fringe_scale_per_px2", "centre_px"})):
        if set(arguments[name] or {}) - allowed:
            raise ValueError(f"{name} holds {', '.join(arguments[name])}; allowed: {', '.join(sorted(allowed))}")
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


def _start(photograph: Photograph, known: Quantities, start: dict | None) -> Rings:
    if not start:
        return find_rings(photograph.image, photograph.mask)
    if "centre_px" not in start or not {"radius", "fringe_scale_per_px2"} & set(start):
        raise ValueError("start needs centre_px, and radius or fringe_scale_per_px2; without it the rings are searched")
    scale = start.get("fringe_scale_per_px2")
    if scale is None:
        values = known.given
        if "pixel_size" not in values or "wavelength" not in values:
            raise ValueError("start holds a radius, which needs pixel_size and wavelength; give fringe_scale_per_px2")
        scale = values.get("index", 1.0) * values["pixel_size"] ** 2 / (start["radius"] * values["wavelength"])
    return follow(photograph.image, photograph.mask, Rings(float(scale), tuple(start["centre_px"]), 0.0, 0.0))


def _fit_gap(photograph: Photograph, rings: Rings, known: Quantities, view: str, fixed: dict) -> Fitted:
    frame = frame_of(photograph.image.shape)
    model = GapModel(frame, known.sphere(rings.scale))
    centre = fixed.get("centre_px", rings.centre)
    place = [(c - m) / frame.unit for c, m in zip(centre, frame.middle, strict=True)]
    phase = rings.phase
    if "gap" in fixed:
        if "wavelength" not in known.given:
            raise ValueError("a fixed gap needs the wavelength")
        phase = 2 * known.given.get("index", 1.0) * fixed["gap"] / known.given["wavelength"]
        phase += 0.5 if view == "reflected" else 0.0
    held = ((1, 2) if "centre_px" in fixed else ()) + ((3,) if "gap" in fixed else ())
    return _robust(model, photograph, np.array([rings.scale * frame.unit**2, *place, phase]), held)


def _fit_scene(photograph: Photograph, scene: Scene, known: Quantities, gap: Fitted, fixed: dict) -> Fitted:
    numbers, phase = np.asarray(gap.solution.unknowns.model), np.asarray(gap.solution.image[2])
    model, numbers, held = scene_start(scene, known, frame_of(photograph.image.shape), numbers, phase, fixed)
    return _robust(model, photograph, numbers, held, gap.weights)


def _robust(model, photograph: Photograph, numbers: np.ndarray, held=(), weights=None) -> Fitted:
    """Fit, and where pixels lie far off the fit, weight them down (Tukey's biweight) and fit again."""
    weights = photograph.mask.astype(float) if weights is None else weights
    found = _converge(model, photograph, numbers, weights, held)
    for _ in range(2):
        residual = photograph.image - found.fitted
        sample = thin(photograph.mask)
        away = np.abs(residual[sample][photograph.mask[sample]])
        spread = 1.4826 * np.median(away)
        if np.mean(away > 4 * spread) < _OUTLIERS:
            break
        weights = np.where(photograph.mask, np.clip(1 - (residual / (6 * spread)) ** 2, 0, None) ** 2, 0.0)
        found = _converge(model, photograph, np.asarray(found.solution.unknowns.model), weights, held)
    return found


def _converge(model, photograph: Photograph, numbers: np.ndarray, weights: np.ndarray, held) -> Fitted:
    """Fit, following the optimum with the model's tangent and the moments' reference until both are near.

    First with background and contrast of full degree, then with the degrees that the image calls for.
    """
    image, weight, count = jnp.asarray(photograph.image), jnp.asarray(weights), len(numbers)
    shape, chosen = (ls.BACKGROUND, ls.CONTRAST), False
    local = localize(as_arrays(model), jnp.asarray(numbers))
    kept = moments(image, weight, local.value[0])
    unknowns = ls.linear_start(local, kept)
    rounds = 0
    while True:
        solution = ls.solve(local, kept, unknowns, jnp.asarray(ls.active_mask(count, *shape, held)))
        unknowns = solution.unknowns
        moved = localize(as_arrays(model), unknowns.model)
        straight = float(jnp.abs(moved.value[0] - solution.image[2]).max()) < _STRAIGHT
        near = float(solution.excursion) < _NEAR
        if near and straight and chosen:
            break
        local = moved
        if not near:
            kept = moments(image, weight, local.value[0])
        elif not chosen:
            shape, chosen = ls.choose_shape(solution, count, float(weights.sum()), held), True
        rounds += 1
        if rounds == _ROUNDS:
            break
    return Fitted(model, solution, kept, weights, shape)


def _why_refused(found: Fitted, photograph: Photograph, rings: Rings) -> str:
    """Why no radius can be had from a fit of the gap formula; empty where one can."""
    if bend := _straight(photograph.mask, rings.scale, rings.centre):
        return bend
    frame = frame_of(photograph.image.shape)
    turns, x, y, _ = np.asarray(found.solution.unknowns.model)
    scale = float(turns) / frame.unit**2
    explained = 1 - float(found.solution.chi2) / float(ls.background_only(found.kept))
    if not (np.isfinite(explained) and np.isfinite(scale)):
        return "the fit has no finite optimum: no rings were recognized"
    if explained < 0.12 or rings.match < 0.05:
        straight = plane_wave(photograph.image, photograph.mask)
        if straight > 0.3:
            return f"the fringes are straight (they explain {straight:.0%} of the power); a radius needs rings or arcs"
        return f"no rings: fringes of any radius and centre explain {max(explained, 0):.1%} of the variance at best"
    centre = (frame.middle[0] + float(x) * frame.unit, frame.middle[1] + float(y) * frame.unit)
    if bend := _straight(photograph.mask, scale, centre):
        return bend
    orders = abs(scale) * float(np.ptp(_squared_distance(photograph.mask, centre)))
    if orders < 1:
        return f"the image holds {orders:.2g} of a fringe; a radius needs at least one"
    if scale <= 0:
        return "the rings' curvature is not determined"
    return ""


def _pixels(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows of some of a mask's pixels, spread over all of it."""
    sample = thin(mask, 20_000)
    rows, columns = np.nonzero(mask[sample])
    return columns * sample[1].step, rows * sample[0].step


def _squared_distance(mask: np.ndarray, centre: tuple[float, float]) -> np.ndarray:
    x, y = _pixels(mask)
    return (x - centre[0]) ** 2 + (y - centre[1]) ** 2


def _straight(mask: np.ndarray, scale: float, centre: tuple[float, float]) -> str:
    """That many fringes cross the field without bending by one: then their curvature is no ring's. Empty otherwise."""
    x, y = _pixels(mask)
    orders = abs(scale) * float(np.ptp(_squared_distance(mask, centre)))
    bend = abs(scale) * float(_squared_distance(mask, (float(x.mean()), float(y.mean()))).max())
    if bend >= 1 or orders <= 3:
        return ""
    return (
        f"the fringes are straight: over {orders:.0f} of them the curvature bends one by {bend:.2g} of their distance; "
        "a radius needs rings or arcs"
    )
