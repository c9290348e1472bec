"""Whether a picture contradicts what a person holds: the gap, or the rings' centre."""

import numpy as np

from fitting.estimate import Fitted, robust_fit
from fitting.parameters import Numbers, Quantities, slots_of, with_sd
from fitting.photograph.averaging import variance_of
from fitting.reasons import Reason
from newtonjax.numerics import Statement

_HELD = {"gap": ("phase",), "centre_px": ("centre_x", "centre_y")}
# Chi-squared of what is held, by its numbers: noise alone exceeds it once in 16 000 pictures (four deviations of one).
_CONTRADICTED = {1: 16.0, 2: 19.3}


def contradictions(fit: Fitted, known: Quantities, contact_phase: float) -> list[Statement]:
    """That a fit without what is held has its number elsewhere, by more than noise explains; for each held value.

    What a held value does wrong stays in the residual and enlarges the deviations: so they are those of a fit in which
    it is free.
    """
    statements = []
    for name in (name for name in fit.fixed if name in _HELD):
        others = {key: value for key, value in fit.fixed.items() if key != name}
        prior = fit.solution.problem.prior
        free = robust_fit(fit.model, fit.reduced, [fit.numbers], others, fit.parts, prior, True)
        slots = slots_of(_HELD[name])
        offset = free.numbers[slots] - fit.numbers[slots]
        try:
            covariance = free.matrix.covariance(variance_of(free)[0])[np.ix_(slots, slots)]
            square = float(offset @ np.linalg.solve(covariance, offset))
        except np.linalg.LinAlgError:
            continue
        if not free.converged or not square > _CONTRADICTED[len(slots)]:
            continue
        sds = np.sqrt(np.diag(covariance))
        if name == "gap":
            answer = free.model.answer(known, Numbers(*free.numbers), contact_phase)
            period = None if answer.gap is None else answer.period
            place = _gap_words(fit, float(offset[0]), float(sds[0]), period)
        else:
            place = _centre_words(fit, free.numbers[slots], sds)
        statements.append(Reason.HELD_CONTRADICTED(name=name, place=place, ratio=np.sqrt(square)))
    return statements


def _gap_words(fit: Fitted, away: float, sd: float, period: float | None) -> str:
    """Where the gap is, `away` turns from the held one; `period`: of a turn [m], None where that is not known."""
    if period is None:
        return with_sd(away, sd, "turns from there")
    return with_sd(fit.fixed["gap"] + away * period, sd * period, "m")


def _centre_words(fit: Fitted, offsets: np.ndarray, sds: np.ndarray) -> str:
    frame = fit.model.frame
    places = (
        with_sd(float(middle + offset * frame.unit), float(sd * frame.unit), "px")
        for middle, offset, sd in zip(frame.middle, offsets, sds, strict=True)
    )
    return ", ".join(places)
