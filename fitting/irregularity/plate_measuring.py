"""The verb `plate_test`: power, irregularity and radius of a part from its fringes under a test plate; or a request."""

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fitting.irregularity.blurred_fit import REPORTED, BlurredFit
from fitting.irregularity.budget import Row, noise_row, pupil_row, terms_row
from fitting.irregularity.disc import Pupil, disc_of
from fitting.irregularity.indications import fringes_of, indications
from fitting.irregularity.lamp_light import Lamp, without_lamp
from fitting.irregularity.plate_radius import PlateLengths, part_radius
from fitting.irregularity.plate_result import PlateTest
from fitting.irregularity.plate_search import EXPLAINS, PlateSearch, plate_search
from fitting.irregularity.plate_sign import signed_by_steps
from fitting.irregularity.pupil import pupil_of, usable_pixels
from fitting.irregularity.request import LEAST_RADIUS, Request
from fitting.irregularity.result import Form, Lengths
from fitting.irregularity.stepped import CONTRADICTORY, form_of_frames
from fitting.parameters import absolute_sd, check_quantity, number, one_blas_thread, says_its_origin
from fitting.photo import Photograph, read
from fitting.plate_reasons import PlateReason
from fitting.reasons import Reason
from newtonjax.numerics import shown

# The largest standard deviations of power (peak to valley) and irregularity (rms) of an answer [fringes]: so is 0.05
# their 95 %.
MOST_SD = 0.025
_LEAST_PIXELS = 1500
# A picture of the light is asked for where it should determine both to this share of that: its own noise and a
# visibility that goes to 1 made deviations 1.1 to 4.4 times those foreseen in 8 pictures of 0.3 fringe.
_SURELY = 0.25
_POWER = float(2 * np.sqrt(3))
_WAYS = {"outwards": 4, "inwards": -4}


@says_its_origin
def plate_test(
    images: Any,
    *,
    plate_radius: float | None = None,
    plate_radius_sd: float | str | None = None,
    wavelength: float | None = None,
    wavelength_sd: float | str | None = None,
    diameter: float | None = None,
    diameter_sd: float | str | None = None,
    light_picture: str | Path | np.ndarray | None = None,
    rings_move: str | None = None,
    pupil: tuple[float, float, float] | None = None,
    pupil_sd: float | None = None,
    transfer: str | float | None = None,
    mask: str | Path | np.ndarray | None = None,
    page: int | None = None,
) -> PlateTest:
    """Power, irregularity and radius of a part by its fringes against a test plate, 0.3 to 10 of them.

    One picture is blur(E (1 + V cos 2πφ)): E a polynomial of degree 2 (with terms of degrees 3 and 4 of 2 % of it), one
    visibility V, φ 15 Zernike terms (Noll 1976) with an order more of 0.03 fringe each, a Gaussian blur. One turn of φ
    is one fringe, λ/2 of the gap. The part's curvature is that of the plate plus λ P / a², P the power in fringes, a
    half of the diameter.

    Args:
      images: a file, or an array as in `fitting.fit`; or a list of three and more of them, each pressed by about a
        third of a fringe (less than half) more than the last one, whose light is then free at every pixel.
      plate_radius, plate_radius_sd: of the plate, positive where it is hollow, for a convex part [m].
      wavelength, wavelength_sd: in vacuum [m].
      diameter, diameter_sd: of the aperture that is seen [m]; with radius and wavelength the part's radius follows.
      light_picture: the light without fringes, of the same camera: the part taken away, or the plate lifted.
      rings_move: "outwards" or "inwards", the way of rings where the gap is made smaller; "outwards" says that the gap
        grows outwards. Several pictures, pressed in their order, say it themselves.
      pupil, pupil_sd: as in `fitting.form`; transfer, mask, page: as in `fitting.fit`.

    What one picture does not determine to 0.025 fringe (power) and 0.025 fringe rms (irregularity), and what several
    forms explain, comes back refused, with what further pictures would determine it. Standard deviations in the same
    units or as "0.1%". Raises ValueError and FileNotFoundError for input that is none.

    """
    lengths = _lengths(plate_radius, plate_radius_sd, wavelength, wavelength_sd, diameter, diameter_sd)
    if rings_move is not None and not (isinstance(rings_move, str) and rings_move in _WAYS):
        raise ValueError(f"rings_move is {shown(rings_move)}; allowed: outwards, inwards")
    of_form = Lengths(wavelength, lengths.wavelength_sd, reference=plate_radius)
    request = Request(of_form, pupil, pupil_sd, None, None if rings_move is None else _WAYS[rings_move], 0.0)
    request.check()
    pictures = list(images) if isinstance(images, list | tuple) else [images]
    with one_blas_thread():
        if len(pictures) == 1:
            photograph = read(pictures[0], transfer, mask, page)
            usable = usable_pixels(photograph, mask is not None)
            lamp = None if light_picture is None else Lamp(light_picture, transfer, page)
            result = _of_picture(photograph, usable, request, lamp)
        else:
            if page is not None or light_picture is not None:
                raise ValueError("page and light_picture belong to one picture; several determine their light")
            result = _of_frames(pictures, request, transfer, mask)
    return _with_radius(replace(result, lengths=lengths, rings_move=rings_move))


def _lengths(
    plate: float | None, plate_sd: Any, wavelength: float | None, wavelength_sd: Any, diameter: float | None, sd: Any
) -> PlateLengths:
    check_quantity("wavelength", wavelength)
    if plate is not None and not 1e-4 <= abs(number("plate_radius", plate)) <= 1e6:
        raise ValueError(f"plate_radius is {plate}; allowed: 1e-4 to 1e6 m, or minus that for a convex plate")
    largest = 10.0 if plate is None else min(2 * abs(plate), 10.0)
    if diameter is not None and not 1e-5 <= number("diameter", diameter) <= largest:
        raise ValueError(f"diameter is {diameter}; allowed: 1e-5 to {largest:g} m")
    return PlateLengths(
        plate,
        absolute_sd("plate_radius", plate_sd, plate and abs(plate)),
        wavelength,
        absolute_sd("wavelength", wavelength_sd, wavelength),
        diameter,
        absolute_sd("diameter", sd, diameter),
    )


class _View(NamedTuple):
    """A picture with its aperture."""

    image: np.ndarray
    usable: np.ndarray
    pupil: Pupil
    pupil_sd: float


def _of_picture(photograph: Photograph, usable: np.ndarray, request: Request, lamp: Lamp | None) -> PlateTest:
    """The form by one picture, with visibility and blur; refused where it does not suffice."""
    blank = Form("refused", "", warnings=list(photograph.warnings), photograph=photograph)
    if photograph.is_uniform:
        return _without_answer(blank, Reason.UNIFORM())
    pupil, sd = pupil_of(photograph) if request.pupil is None else (Pupil(*map(float, request.pupil)), 0.0)
    if sd is None:
        blank.warnings.append(Reason.PUPIL_NOT_SEEN(radius=pupil.radius))
    if not pupil.radius >= LEAST_RADIUS:
        return _without_answer(blank, Reason.PUPIL_TOO_SMALL(least=LEAST_RADIUS))
    sd = request.pupil_sd if request.pupil_sd is not None else sd
    blank = replace(blank, pupil=pupil, pupil_sd=sd, lengths=request.lengths)
    image, light_sd = photograph.image, None
    if lamp is not None:
        image, usable, light_sd = without_lamp(image, usable, pupil, lamp, blank.warnings)
    pixels = int(disc_of(image, usable, pupil).pixels)
    if pixels < _LEAST_PIXELS:
        return _without_answer(blank, Reason.TOO_FEW_PIXELS(usable=pixels, total=usable.size))
    candidates = plate_search(image, usable, pupil, light_sd)
    return _judged(blank, candidates, _View(image, usable, pupil, sd or 0.0), request, lamp is not None)


def _judged(blank: Form, candidates: PlateSearch, view: _View, request: Request, is_lit: bool) -> PlateTest:
    if not candidates.fits or candidates.fits[0].unexplained > EXPLAINS:
        unexplained = candidates.fits[0].unexplained if candidates.fits else 1.0
        remedy = _remedy(None, is_lit)
        reason = PlateReason.PLATE_NOT_EXPLAINED(unexplained=unexplained, most=EXPLAINS, remedy=remedy)
        return _without_answer(blank, reason)
    fit = candidates.fits[0]
    remedy = _remedy(fit, is_lit)
    power_sd, irregularity_sd = _sds(fit, fit.covariance)
    if not max(power_sd, irregularity_sd) < MOST_SD:
        reason = PlateReason.PLATE_UNDETERMINED(
            power=power_sd, irregularity=irregularity_sd, most=MOST_SD, remedy=remedy
        )
        return _without_answer(blank, reason)
    if candidates.rivals:
        powers = ", ".join(f"{_POWER * abs(rival.form[3]):.3g}" for rival in candidates.rivals)
        reason = PlateReason.PLATE_RIVALS(
            count=len(candidates.rivals), powers=powers, power=_POWER * abs(fit.form[3]), remedy=remedy
        )
        return _without_answer(blank, reason)
    if not fit.converged:
        return _without_answer(blank, Reason.FORM_NOT_CONVERGED(), "not-converged")
    form = _answer(blank, fit, view, request)
    blur = float(np.sqrt(fit.numbers.blur)) * fit.block
    return PlateTest(form.status, form=form, visibility=fit.numbers.visibility, blur_px=blur)


def _sds(fit: BlurredFit, covariance: np.ndarray) -> tuple[float, float]:
    """Standard deviations of power, peak to valley, and irregularity, rms, by a covariance of white noise."""
    words = indications(fit.form[:REPORTED], fit.inflation * covariance[:REPORTED, :REPORTED])
    return words["A"][1], words["RMSi"][1]


def _remedy(fit: BlurredFit | None, is_lit: bool) -> str:
    """The pictures that would help; that of the light only where it is not there and would do so."""
    # Where the phase stays about an extremum, its size and the visibility are one number, whatever is known of light.
    helps = fit is None or max(_sds(fit, fit.with_lamp)) < _SURELY * MOST_SD
    return PlateReason.PLATE_REMEDY() if helps and not is_lit else PlateReason.PLATE_REMEDY_OF_FRINGES()


def _without_answer(blank: Form, message: str, status: str = "refused") -> PlateTest:
    return PlateTest(status, message, form=replace(blank, status=status, message=message))


def _answer(blank: Form, fit: BlurredFit, view: _View, request: Request) -> Form:
    covariance = fit.inflation * fit.covariance
    rows = [
        pupil_row(fit.form, view.pupil, view.pupil_sd),
        terms_row(fit.form, covariance, fit.inflation),
        noise_row(covariance),
    ]
    rows = [Row(row.source, row.changes[:, :REPORTED]) for row in rows]
    stacked = np.vstack([row.changes for row in rows])
    total = stacked.T @ stacked
    flip = float(np.sign(fit.form[3]) or 1.0) * (-1.0 if request.sign == -4 else 1.0)
    form = flip * fit.form[:REPORTED]
    warnings = list(blank.warnings)
    if fit.inflation > 1.5:
        warnings.append(Reason.CORRELATED_RESIDUALS(inflation=fit.inflation))
    return replace(
        blank,
        status="ok",
        coefficients=form.tolist(),
        covariance=total.tolist(),
        quadratic_covariance=total[3:6, 3:6].tolist(),
        budget={row.source: row.of_answers(form) for row in rows},
        fringes=fringes_of(form),
        explained=1 - max(fit.unexplained, 0.0),
        inflation=fit.inflation,
        sign=request.sign,
        warnings=warnings,
    )


def _of_frames(pictures: list, request: Request, transfer: Any, mask: Any) -> PlateTest:
    """The form by several pictures, its sign by the order in which they were pressed."""
    of_terms = request._replace(terms=REPORTED)
    form = form_of_frames(pictures, of_terms, transfer, mask, is_speckled=False)
    blank = Form("refused", photograph=form.photograph, pupil=form.pupil, pupil_sd=form.pupil_sd)
    blank = replace(blank, lengths=request.lengths, warnings=form.warnings)
    count = len(pictures)
    if form.status == "not-converged" or (form.inflation or 1.0) > CONTRADICTORY:
        return _without_answer(blank, PlateReason.PLATE_FRAMES_CONTRADICT(count=count))
    if form.coefficients is None:
        return PlateTest(form.status, form.message, form=form)
    sds = tuple(form.indications[name][1] for name in ("A", "RMSi"))
    if not max(sds) < MOST_SD:
        reason = PlateReason.PLATE_FRAMES_UNDETERMINED(count=count, power=sds[0], irregularity=sds[1], most=MOST_SD)
        return _without_answer(blank, reason)
    form = signed_by_steps(form, request.sign)
    return PlateTest(form.status, form.message, form=form)


def _with_radius(result: PlateTest) -> PlateTest:
    """The result with its warnings and the part's radius."""
    form, lengths = result.form, result.lengths
    warnings = [text for text in form.warnings if getattr(text, "code", "") != Reason.FORM_SIGN_OPEN.name]
    if form.coefficients is None:
        return replace(result, warnings=warnings)
    if form.sign is None:
        warnings.append(PlateReason.PLATE_SIGN_OPEN())
    named = {"plate_radius": lengths.plate_radius, "wavelength": lengths.wavelength, "diameter": lengths.diameter}
    missing = [name for name, value in named.items() if value is None] + ["rings_move"] * (form.sign is None)
    # The diameter is that of an aperture that is seen, not of the largest circle in the frame.
    missing += ["pupil"] * any(getattr(text, "code", "") == Reason.PUPIL_NOT_SEEN.name for text in warnings)
    if missing or result.power is None:
        warnings.append(PlateReason.PLATE_NO_RADIUS(missing=", ".join(missing)))
        return replace(result, warnings=warnings)
    exact = [name for name in named if getattr(lengths, f"{name}_sd") is None]
    if exact:
        warnings.append(Reason.TREATED_AS_EXACT(names=", ".join(exact)))
    return replace(result, warnings=warnings, part=part_radius(lengths, *result.power))
