"""The form of a surface from frames stepped in phase, with its budget, and the frame that contradicts the others."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy import special

from fitting.irregularity.budget import Row, distortion_row, edge_row, noise_row, pupil_row, terms_row
from fitting.irregularity.disc import EDGE, Pupil
from fitting.irregularity.frames import Frames, frames_of_surface
from fitting.irregularity.frames_blur import Unblurred, without_blur
from fitting.irregularity.indications import fringes_of
from fitting.irregularity.joint_frames import FramesFit, fit_frames, own_forms, refit_frames
from fitting.irregularity.phase_steps import Start, coarse, starts, tilted_starts
from fitting.irregularity.request import Request, flip_of
from fitting.irregularity.residuals import inflation_of
from fitting.irregularity.result import Form
from fitting.irregularity.solution import by_evidence
from fitting.irregularity.zernike import ORDERS, TERMS
from fitting.plate_reasons import PlateReason
from fitting.reasons import Reason

# Inflation of the noise in frames of a lamp beyond which they came to a wrong optimum: of right ones 1.4, of one 67.
CONTRADICTORY = 10.0
# Of the pixels of many starts so many say which is best.
_THINNED = 3
# Frames from which one can be left out.
_LEAVING_OUT = 4
# Chance that a frame is named that does not contradict the others, over all frames.
_ALARM = 0.01
# The least share of the frames' change that one phase explains; steps within this of one direction are none.
_EXPLAINED, _ALIKE = 0.5, 0.98
_FIRST, _NARROWER = 15, 0.9
# Of frames with blur less of the radius is used, as blur brings dark over the rim; the largest blur [radii]: at 0.027
# half of the irregularities lie within their intervals, at 0.014 all but one of 33.
_EDGE_OF_BLUR, _MOST_BLUR = 0.95, 0.022


class Terms(NamedTuple):
    """A form [terms], turns, with piston and tilts of the first frame, and its covariance."""

    coefficients: np.ndarray
    covariance: np.ndarray


def form_of_frames(images: Any, request: Request, transfer: Any, mask: Any, *, is_speckled: bool = True) -> Form:
    """The form of a surface of which three frames and more are given, stepped by unknown parts of a fringe.

    Frames of a lamp, without speckle, are fitted with their blur.
    """
    frames = frames_of_surface(images, request.pupil, transfer, mask, EDGE if is_speckled else _EDGE_OF_BLUR)
    frames = frames._replace(is_speckled=is_speckled)
    scale = frames.scale
    pupil = Pupil(*(value * scale + (scale - 1) / 2 * (k < 2) for k, value in enumerate(frames.pupil)))
    known_sd = request.pupil_sd if request.pupil_sd is not None else frames.pupil_sd and frames.pupil_sd * scale
    warnings = list(frames.photograph.warnings)
    if request.pupil is None and known_sd is None:
        warnings.append(Reason.PUPIL_NOT_SEEN(radius=pupil.radius))
    blank = {"pupil": pupil, "pupil_sd": known_sd, "photograph": frames.photograph, "reading": scale}
    first = best_fit(frames, starts(frames, _FIRST))
    if not is_speckled and not (first.converged and _inflation(frames, first) < CONTRADICTORY):
        first = _with_tilts(frames, first)
    explained = _explained(frames, first)
    if not explained > _EXPLAINED:
        reason = Reason.FRAMES_NOT_STEPPED(explained=max(explained, 0.0), least=_EXPLAINED)
        return Form("refused", reason, warnings=warnings, **blank)
    if abs(np.exp(2j * np.pi * _steps(first)).mean()) > _ALIKE:
        return Form("refused", Reason.FRAMES_ALIKE(), warnings=warnings, **blank)
    unblurred = None if is_speckled else without_blur(frames, first)
    if unblurred is not None:
        frames, first = unblurred.frames, unblurred.fit
        blur, most = np.sqrt(unblurred.variance), _MOST_BLUR * frames.pupil.radius
        # Of few fringes the blur is known to a pixel only.
        if unblurred.variance - unblurred.sd > most**2:
            reason = PlateReason.PLATE_FRAMES_BLURRED(blur=blur * scale, radius=pupil.radius, most=most * scale)
            return Form("refused", reason, warnings=warnings, **blank)
    fit, reported = _with_terms(frames, first, request.terms)
    if not fit.converged:
        return Form("not-converged", Reason.FORM_NOT_CONVERGED(), warnings=warnings, **blank)
    inflation = _inflation(frames, fit)
    terms = _terms(fit, inflation)
    others = _leaving_out(frames, fit)
    rows = _rows(frames, fit, terms, others, reported, pupil, known_sd or 0.0, request.distortion_sd)
    if unblurred is not None:
        rows.append(_blur_row(unblurred, inflation, reported))
    size, freedom = _contradictions(frames, first), _FIRST - 3
    if size and max(size) > special.chdtri(freedom, _ALARM / len(size)) / freedom:
        place = int(np.argmax(size))
        warnings.append(Reason.FRAME_CONTRADICTS(frame=place + 1, size=max(size)))
    if inflation > 1.5:
        warnings.append(Reason.CORRELATED_RESIDUALS(inflation=inflation))
    coefficients = terms.coefficients[:reported]
    covariance = np.sum([row.changes.T @ row.changes for row in rows], axis=0)
    flip, of_sign = flip_of(coefficients, np.sqrt(np.diag(covariance)), request.sign)
    form = flip * coefficients
    stacked = np.vstack(
        [rows[0].changes - 2 * coefficients * (known_sd or 0.0) / pupil.radius * _first(rows[0])]
        + [row.changes for row in rows[1:]]
    )[:, 3:6]
    return Form(
        "ok",
        "",
        coefficients=form.tolist(),
        covariance=covariance.tolist(),
        quadratic_covariance=(stacked.T @ stacked).tolist(),
        budget={row.source: row.of_answers(form) for row in rows},
        fringes=fringes_of(form),
        explained=_explained(frames, fit),
        inflation=inflation,
        sign=request.sign,
        lengths=request.lengths,
        steps=(flip * _steps(fit)).tolist(),
        contradictions=size,
        warnings=warnings + of_sign,
        **blank,
    )


def best_fit(frames: Frames, trials: Iterable[Start]) -> FramesFit:
    return min((fit_frames(frames, *start) for start in trials), key=lambda fit: fit.variance)


def _with_tilts(frames: Frames, first: FramesFit) -> FramesFit:
    """The optimum by starts with tilts, on fewer pixels, where it explains more than the first one."""
    few, start = coarse(frames), starts(frames, _FIRST)[0]
    fewer = few._replace(light=few.light[:, ::_THINNED], u=few.u[::_THINNED], v=few.v[::_THINNED])
    fit = refit_frames(frames, best_fit(fewer, tilted_starts(few, _FIRST, start)), _FIRST)
    return min(fit, first, key=lambda fit: fit.variance)


def _blur_row(unblurred: Unblurred, inflation: float, reported: int) -> Row:
    """What the deviation of the blur's size makes of the form."""
    change = np.zeros(reported)
    count = min(reported - 3, len(unblurred.change))
    change[3 : 3 + count] = np.sqrt(inflation) * unblurred.change[:count]
    return Row("blur", change[None])


def _first(row: Row) -> np.ndarray:
    """1 in the first of a row's changes, which is that of the radius."""
    return np.eye(len(row.changes))[:, :1]


def _steps(fit: FramesFit) -> np.ndarray:
    """Steps of the frames from the first one, in turns, within half a turn."""
    steps = fit.own[:, 0] - fit.own[0, 0]
    return steps - np.round(steps)


def _explained(frames: Frames, fit: FramesFit) -> float:
    """The share of the change from frame to frame that is one phase's."""
    light = frames.light / np.maximum(frames.light.mean(axis=0), 1e-6)
    change = light - light.mean(axis=1)[:, None]
    change = change - change.mean(axis=0)
    return 1 - float(np.square(fit.residual, dtype=float).sum() / max(np.square(change, dtype=float).sum(), 1e-30))


def _with_terms(frames: Frames, first: FramesFit, terms: int | None) -> tuple[FramesFit, int]:
    """The fit with two orders more than are reported, and how many these are: by evidence, of all, unless given."""
    if terms is None:
        everything = refit_frames(frames, first, TERMS)
        inflation = _inflation(frames, everything)
        evident = by_evidence(*_terms(everything, inflation), frames.light.size / inflation)
        terms = max(evident, 6)
    fitted = [order for order in ORDERS if order >= terms][:3][-1]
    return refit_frames(frames, first, fitted), terms


def _terms(fit: FramesFit, inflation: float) -> Terms:
    """Piston and tilts of the first frame with the form; of these three no deviation is said."""
    covariance = np.pad(inflation * fit.covariance, ((3, 0), (3, 0)))
    return Terms(np.concatenate([fit.own[0], fit.form]), covariance)


def _inflation(frames: Frames, fit: FramesFit) -> float:
    """By how much residuals that go together, over pixels and over frames, inflate the form's variance."""
    of_pixel = fit.score.sum(axis=0)
    grid = np.where(frames.cells >= 0, of_pixel[frames.cells], 0.0)
    over_frames = float(np.square(of_pixel, dtype=float).sum()) / float(np.square(fit.score, dtype=float).sum())
    return max(1.0, inflation_of(grid) * over_frames)


def _leaving_out(frames: Frames, fit: FramesFit) -> list[FramesFit]:
    """The fits without each of the frames; none where too few are left."""
    count = len(frames.light)
    if count < _LEAVING_OUT:
        return []
    beside = [np.delete(np.arange(count), k) for k in range(count)]
    return [refit_frames(chosen_frames(frames, rest), with_own(fit, rest), 3 + len(fit.form)) for rest in beside]


def chosen_frames(frames: Frames, places: np.ndarray) -> Frames:
    return frames._replace(light=frames.light[places])


def with_own(fit: FramesFit, places: np.ndarray) -> FramesFit:
    """A fit as a start for some of its frames."""
    return replace(fit, own=fit.own[places], gains=fit.gains[places])


def _rows(
    frames: Frames,
    fit: FramesFit,
    terms: Terms,
    others: list[FramesFit],
    reported: int,
    pupil: Pupil,
    pupil_sd: float,
    distortion_sd: float,
) -> list[Row]:
    """The budget: as that of one picture, and what leaving out frames says beyond the noise."""
    inside = np.hypot(frames.u, frames.v) <= _NARROWER
    cells = np.full_like(frames.cells, -1)
    cells[frames.cells >= 0] = np.where(inside, np.cumsum(inside) - 1, -1)
    narrow = Frames(frames.light[:, inside], frames.u[inside], frames.v[inside], cells, *frames[4:])
    narrower = refit_frames(narrow, fit, len(terms.coefficients))
    inflation = _inflation(frames, fit)
    beside = _terms(narrower, inflation)
    beside.coefficients[:3] = terms.coefficients[:3]
    rows = [
        pupil_row(terms.coefficients, pupil, pupil_sd),
        edge_row(beside.coefficients - terms.coefficients, beside.covariance - terms.covariance),
        terms_row(terms.coefficients, terms.covariance, inflation),
        distortion_row(terms.coefficients, distortion_sd),
        noise_row(terms.covariance),
    ]
    if others:
        forms = np.stack([other.form for other in others])
        square = (len(forms) - 1) / len(forms) * np.square(forms - forms.mean(axis=0)).sum(axis=0)
        excess = np.sqrt(np.maximum(square - np.diag(terms.covariance)[3:], 0.0))
        rows.append(Row("leaving out frames", np.diag(np.concatenate([np.zeros(3), excess]))))
    return [Row(row.source, row.changes[:, :reported]) for row in rows]


def _contradictions(frames: Frames, fit: FramesFit) -> list[float]:
    """Chi-squared a term of a form of its own for each frame; none where too few frames are left.

    With the terms of the start: a frame alone has more where it lacks fringes.
    """
    if len(frames.light) < _LEAVING_OUT:
        return []
    inflation = _inflation(frames, fit)
    return [size / inflation / len(fit.form) for size in own_forms(frames, fit)]
