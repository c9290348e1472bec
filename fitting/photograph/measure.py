"""From a photograph of rings to the radius: read, find, solve, judge, report."""

import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import jax
import numpy as np

from fitting.estimate import FEW
from fitting.parameters import (
    AbstractResult,
    Progress,
    one_blas_thread,
    progress_of,
    says_its_origin,
)
from fitting.photograph.colours import fit_channels
from fitting.photograph.finding import find
from fitting.photograph.further_lines import further_lines
from fitting.photograph.light import with_richer_light
from fitting.photograph.light_words import light_of
from fitting.photograph.reporting import report
from fitting.photograph.result import FitResult
from fitting.photograph.sharp_rings import result_of_coated_bench
from fitting.photograph.solving import solve, solve_bench
from fitting.photograph.task import task_of
from fitting.photograph.verdict import RefusedError, judge
from newtonjax.numerics import x64
from newtonjax.scene import Response, Scene, Spectrum


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
    response: str | Path | Response | None = None,
    channel: str | None = None,
    noise: str | tuple[float, float] | np.ndarray | None = None,
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
      transfer: "linear", "srgb" or an exponent; see `fitting.read`. Without it the usual one is taken, and an
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
        Light of bands (an LED, white light, a file) goes with a response.
      response: of the camera's channels to light of bands, red, green and blue or one, as a Response or in the words of
        `newtonjax.camera_response`. Each channel has the lamp's spectrum times its curve, which may be tilted and bent
        (0.3 of either over 50 nm, 1 sd); what is left over says what the curves may be off by, up to where the radius
        is refused. By how much all their wavelengths are off together rings do not tell: wavelength_sd, or 0.8 %. The
        fringe scale is that of the middle one of the channels' mean wavelengths.
      channel: "red", "green" or "blue"; without it the one with the clearest rings.
      noise: by which pixels are weighed, at the light that a fit of equal weights finds. "estimated": the variance at
        each level of light, from what that fit leaves over; "shot": in proportion to the light; (full well, read noise)
        in photoelectrons, the full well that of the largest code (of floats: of light 1); or the variance of each
        pixel, [rows, columns] in any unit. All pixels count alike where it is not given.
      progress: True for a bar on the terminal, or a function of (steps done, their number).

    What the data cannot give comes back as a status and a message. Raises ValueError and FileNotFoundError for input
    that cannot be used.

    """
    arguments, began = locals(), time.perf_counter()
    try:
        result = _result_of(arguments)
    except RefusedError as refusal:
        warnings, parameters = list(refusal.photograph.warnings), refusal.parameters
        result = FitResult("refused", refusal.reason, warnings=warnings, parameters=parameters)
    return replace(result, seconds=time.perf_counter() - began)


def _result_of(arguments: dict[str, Any]) -> FitResult:
    """The result of the arguments of `fit`, stage by stage. Raises RefusedError where there can be none."""
    is_of_lamp = any(arguments[name] is not None for name in ("light", "response"))
    light_given = light_of(arguments) if is_of_lamp or isinstance(arguments["wavelength"], str) else None
    if light_given is not None:
        arguments = arguments | {"wavelength": light_given.reference}
    task = task_of(arguments)
    # Reading has loaded SciPy, whose threads are to be limited too.
    progress = progress_of(arguments["progress"], "fitting")
    with x64(runs_programs=arguments["scene"] is not None), one_blas_thread(), progress as done:
        done(1, 4)
        if task.scene is not None and task.scene.all_orders is not None:
            return result_of_coated_bench(task)
        task, rings = find(task)
        done(2, 4)
        if light_given is not None:
            result = fit_channels(task, rings, light_given, arguments)
            done(4, 4)
            return result
        choice = solve(task, rings)
        done(3, 4)
        if reason := judge(choice.found, choice.photograph, rings, task.is_guided):
            raise RefusedError(reason, choice.photograph)
        if task.scene is not None:
            choice = solve_bench(task.scene, task, choice)
        if choice.found.orders < FEW:
            choice = with_richer_light(choice)
        result = report(task, choice, partial(further_lines, task, rings, arguments))
        done(4, 4)
        return result
