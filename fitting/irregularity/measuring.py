"""The verb `form`: from one picture of fringes to the form of a surface, with its budget; or a refusal."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from fitting.irregularity.demodulation import remainder_of
from fitting.irregularity.disc import Pupil, disc_of, square_about
from fitting.irregularity.fringe_count import LEAST_COUNT, fringe_count
from fitting.irregularity.indications import fringes_of
from fitting.irregularity.moments import products_at
from fitting.irregularity.projection import FormFit
from fitting.irregularity.pupil import pupil_of, usable_pixels
from fitting.irregularity.request import LEAST_RADIUS, Request, flip_of
from fitting.irregularity.result import Form, Lengths
from fitting.irregularity.search import LOCKED, Search, search
from fitting.irregularity.solution import Solution, Uncertain, solved
from fitting.irregularity.stepped import form_of_frames
from fitting.irregularity.zernike import at_points, slopes
from fitting.parameters import (
    Progress,
    absolute_sd,
    check_quantity,
    number,
    one_blas_thread,
    progress_of,
    says_its_origin,
)
from fitting.photo import Photograph, read
from fitting.reasons import Reason

# Fewer fringes leave folds: the illumination takes up what a fringe would say.
LEAST_FRINGES = 6.0
_LEAST_PIXELS = 1500
_STEPS = 2
# Width of the finest fringe [px] below which sampling is said; inflation of the noise beyond which it is said.
_FINE, _CORRELATED = 3.0, 1.5


@says_its_origin
def form(
    image: str | Path | np.ndarray | Sequence[str | Path | np.ndarray],
    *,
    wavelength: float | None = None,
    wavelength_sd: float | str | None = None,
    pixel_size: float | None = None,
    pixel_size_sd: float | str | None = None,
    reference_radius: float | None = None,
    pupil: tuple[float, float, float] | None = None,
    pupil_sd: float | None = None,
    terms: int | None = None,
    sign: int | None = None,
    distortion_sd: float = 0.0,
    transfer: str | float | None = None,
    mask: str | Path | np.ndarray | None = None,
    page: int | None = None,
    progress: Progress = None,
) -> Form:
    """The form of a surface against its reference, from one picture of fringes of equal thickness.

    B + M cos 2πφ with smooth B and M, φ = Σ p_j Z_j in Zernike polynomials (Noll 1976), by variable projection (Golub
    and Pereyra 1973); the start comes from the fringes' frequencies in tiles. One turn of φ is one fringe spacing of
    the gap, λ/2. Fitted are two radial orders more than are reported, up to 36 terms.

    Args:
      image: a file, or an array as in `fitting.fit`; or a list of three frames and more of one surface, stepped in
        phase by unknown parts of a fringe, whose light is then free at every pixel.
      wavelength, wavelength_sd: of the light in vacuum [m]; with them heights in nanometres.
      pixel_size, pixel_size_sd: at the surface [m]; with the wavelength, radii of curvature.
      reference_radius: of the surface against which it is seen, positive where it is hollow [m]; a plane unless given.
      pupil: column, row and radius of the aperture [px], from the middle of the first pixel; else it is looked for.
      pupil_sd: standard deviation of its rim [px]; the scatter of its edge where it is looked for, else 0.
      terms: how many are reported: 6, 10, 15, 21, 28 or 36; by the picture's evidence unless given.
      sign: the number of a term that is positive, or minus that of one that is negative, which decides the sign of all;
        4 for a lens that is more convex than its reference fits. One picture does not tell it.
      distortion_sd: standard deviation of the camera's radial distortion at the pupil's rim, as a share.
      transfer, mask, page: as in `fitting.fit`.
      progress: True for a bar on the terminal, or a function of (steps made, their number).

    A picture that gives no form comes back refused. It wants 6 fringes, which were found in 276 of 280 pictures from 8
    fringes on. Raises ValueError and FileNotFoundError for input that is none.

    """
    lengths = _lengths(wavelength, wavelength_sd, pixel_size, pixel_size_sd, reference_radius)
    request = Request(lengths, pupil, pupil_sd, _whole("terms", terms), _whole("sign", sign), distortion_sd or 0.0)
    request.check()
    if isinstance(image, list | tuple):
        if page is not None:
            raise ValueError("page is given with a list of frames; leave it out")
        with progress_of(progress, "fitting the form") as done, one_blas_thread():
            done(1, _STEPS)
            return form_of_frames(image, request, transfer, mask)
    photograph = read(cast("str | Path | np.ndarray", image), transfer, mask, page)
    with progress_of(progress, "fitting the form") as done, one_blas_thread():
        return _measured(photograph, usable_pixels(photograph, mask is not None), request, done)


def _whole(name: str, value: Any) -> int | None:
    """A whole number, or None. Raises ValueError for anything else."""
    if value is None:
        return None
    if number(name, value) % 1:
        raise ValueError(f"{name} is {value}; allowed: a whole number")
    return int(value)


def _lengths(
    wavelength: float | None, wavelength_sd: Any, pixel_size: float | None, pixel_size_sd: Any, reference: float | None
) -> Lengths:
    for name, value in (("wavelength", wavelength), ("pixel_size", pixel_size)):
        check_quantity(name, value)
    sds = absolute_sd("wavelength", wavelength_sd, wavelength), absolute_sd("pixel_size", pixel_size_sd, pixel_size)
    if reference is not None and not 1e-4 <= abs(number("reference_radius", reference)) <= 1e6:
        raise ValueError(f"reference_radius is {reference}; allowed: 1e-4 to 1e6 m, or minus that for a convex one")
    return Lengths(wavelength, sds[0], pixel_size, sds[1], reference)


def _measured(photograph: Photograph, usable: np.ndarray, request: Request, done: Callable[[int, int], object]) -> Form:
    warnings = list(photograph.warnings)
    if photograph.is_uniform or usable.sum() < _LEAST_PIXELS:
        few = Reason.TOO_FEW_PIXELS(usable=int(usable.sum()), total=usable.size)
        return Form("refused", Reason.UNIFORM() if photograph.is_uniform else few, warnings=warnings)
    if request.pupil is not None:
        pupil, pupil_sd = Pupil(*map(float, request.pupil)), request.pupil_sd
        if not pupil_sd:
            warnings.append(Reason.TREATED_AS_EXACT(names="pupil"))
    else:
        pupil, pupil_sd = pupil_of(photograph)
        if pupil_sd is None:
            warnings.append(Reason.PUPIL_NOT_SEEN(radius=pupil.radius))
        pupil_sd = request.pupil_sd if request.pupil_sd is not None else pupil_sd
    blank = Form("refused", "", pupil=pupil, pupil_sd=pupil_sd, warnings=warnings, photograph=photograph)
    if not pupil.radius >= LEAST_RADIUS:
        return replace(blank, message=Reason.PUPIL_TOO_SMALL(least=LEAST_RADIUS), pupil=None)
    box, square = square_about(pupil)
    image, inside = photograph.codes.light(box), usable[box]
    disc = disc_of(image, inside, square)
    if disc.pixels < _LEAST_PIXELS:
        return replace(blank, message=Reason.TOO_FEW_PIXELS(usable=int(disc.pixels), total=usable.size))
    count = fringe_count(image, inside, square)
    if count is not None and count < LEAST_COUNT:
        return replace(blank, message=Reason.FORM_FEW_FRINGES(fringes=count, least=LEAST_FRINGES))
    candidates = search(image, inside, square)
    done(1, _STEPS)
    refusal = _refusal(candidates)
    if refusal is not None:
        return replace(blank, message=refusal)
    uncertain = Uncertain(pupil_sd or 0.0, request.distortion_sd or 0.0)
    solution = solved(disc, pupil, candidates, request.terms, uncertain)
    done(2, _STEPS)
    agreement = remainder_of(disc, solution.fit.coefficients).agreement
    if agreement < LOCKED:
        return replace(blank, message=Reason.FORM_NOT_CONFIRMED(agreement=agreement, least=LOCKED))
    if not solution.fit.converged:
        return replace(blank, status="not-converged", message=Reason.FORM_NOT_CONVERGED())
    return _answer(blank, solution, candidates, agreement, request)


def _refusal(candidates: Search) -> str | None:
    """Why a search gives no start; None where it does."""
    if not candidates.starts:
        return Reason.FORM_NO_FRINGES()
    agreement = candidates.candidates[0].agreement if candidates.candidates else 0.0
    if agreement < LOCKED:
        return Reason.FORM_NOT_CONFIRMED(agreement=agreement, least=LOCKED)
    fringes = fringes_of(candidates.candidates[0].fit.coefficients)
    if fringes < LEAST_FRINGES:
        return Reason.FORM_FEW_FRINGES(fringes=fringes, least=LEAST_FRINGES)
    return None


def _answer(blank: Form, solution: Solution, candidates: Search, agreement: float, request: Request) -> Form:
    fit, form_of, covariance = solution.fit, solution.form, solution.covariance
    flip, sign_warnings = flip_of(form_of, np.sqrt(np.diag(covariance)), request.sign)
    pupil = blank.pupil or Pupil(0.0, 0.0, 1.0)
    warnings = [*blank.warnings, *sign_warnings, *_warnings(solution, candidates, pupil.radius)]
    piston = float(_positive_contrast(fit))
    form_of = flip * (form_of + np.eye(len(form_of))[0] * piston)
    return replace(
        blank,
        status="ok",
        coefficients=form_of.tolist(),
        covariance=covariance.tolist(),
        quadratic_covariance=solution.quadratic_covariance.tolist(),
        budget={row.source: row.of_answers(form_of) for row in solution.rows},
        fringes=fringes_of(form_of),
        explained=fit.explained,
        agreement=agreement,
        inflation=solution.inflation,
        sign=request.sign,
        rivals=[rival.fit.coefficients[: len(form_of)].tolist() for rival in candidates.rivals],
        lengths=request.lengths,
        warnings=warnings,
    )


def _warnings(solution: Solution, candidates: Search, radius: float) -> list[str]:
    texts: list[str] = []
    if candidates.rivals:
        texts.append(Reason.FORM_RIVALS(count=len(candidates.rivals)))
    if solution.inflation > _CORRELATED:
        texts.append(Reason.CORRELATED_RESIDUALS(inflation=solution.inflation))
    u, v = np.cos(np.linspace(0, 2 * np.pi, 90)), np.sin(np.linspace(0, 2 * np.pi, 90))
    rises = [at_points(part[: solution.terms], u, v) @ solution.form for part in slopes()]
    width = radius / max(float(np.hypot(*rises).max()), 1e-9)
    if width < _FINE:
        texts.append(Reason.NEAR_SAMPLING_LIMIT(width=width))
    return texts


def _positive_contrast(fit: FormFit) -> float:
    """Half a turn where the contrast is negative in the middle of the pupil: a bright fringe taken for a dark one."""
    middle = products_at(np.zeros(1), np.zeros(1), fit.degrees.contrast) @ fit.contrast
    return 0.5 if float(middle[0]) < 0 else 0.0
