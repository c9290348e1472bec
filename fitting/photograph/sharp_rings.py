"""What is said of rings of many beams: finesse and fringe scale, and a radius where a coated bench is given."""

from dataclasses import replace

import numpy as np

from fitting.parameters import EXPONENTS, TABLE, Parameter, Quantities, interval, with_sd
from fitting.photo import Photograph, RingEvidence, Rings, search_of
from fitting.photograph.many_beams import ManyBeams, explained_by_sharp_rings, many_beams
from fitting.photograph.result import FitResult
from fitting.photograph.task import Task
from fitting.photograph.verdict import RefusedError
from fitting.reasons import Reason
from newtonjax.numerics import Statement

# Rings of fewer harmonics than these are measured as those of two beams, unless all of their evidence speaks against
# it; sharp ones explain so much of the light, of Fabry and Perot's photograph 0.94.
_CLEAR, _LEAST_FINESSE = 0.8, 2.8
# The first harmonic of a finesse of 30 has a match of 0.1 and more; a picture of something else is not tried below it.
_LEAST_MATCH = 0.08


def refusal_of_sharp_rings(task: Task, rings: Rings, evidence: RingEvidence) -> RefusedError | None:
    """Why rings of many beams give no radius, with what was measured of them; None where they are none.

    Sharp rings, of which the first harmonic holds little, have the evidence of no rings: then they are looked at.
    """
    verdict, photograph = evidence.verdict, task.photograph
    if verdict not in ("many beams", "no rings") or rings.match < _LEAST_MATCH:
        return None
    if verdict == "no rings" and explained_by_sharp_rings(photograph, rings) < _CLEAR:
        return None
    answer = many_beams(photograph, rings, _with_another_curve(task))
    if answer.explained < _CLEAR or answer.finesse < _LEAST_FINESSE:
        return None
    parameters = _parameters(answer)
    return RefusedError(_reason(parameters), photograph, parameters)


def result_of_coated_bench(task: Task) -> FitResult:
    """The radius, or what else is unknown, by rings of many beams that a coated bench is said to have made."""
    photograph, known = task.photograph, task.quantities
    rings, _ = search_of(photograph)
    answer = many_beams(photograph, rings, _with_another_curve(task))
    parameters = _parameters(answer)
    common = {"warnings": list(photograph.warnings), "explained_variance": answer.explained}
    if answer.explained < _CLEAR:
        reason = Reason.SHARP_RINGS_MISFIT(explained=max(answer.explained, 0.0), least=_CLEAR)
        return FitResult("refused", reason, **common)
    common |= {"centre_px": answer.centre, "fringe_scale_per_px2": answer.scale, "fringe_scale_sd": answer.scale_sd}
    budget = _budget(known, answer)
    value = known.values(answer.scale)[known.measured]
    sd = float(np.sqrt(sum(part**2 for _, part in budget)))
    spec = TABLE[known.measured]
    parameters[known.measured] = Parameter(value, sd, False, known.measured, spec.unit)
    if known.measured == "radius":
        common |= {"radius": value, "radius_sd": sd, "radius_interval": interval(value, sd)}
    return FitResult("ok", measured=known.measured, budget=budget, parameters=parameters, **common)


def _budget(known: Quantities, answer: ManyBeams) -> list[tuple[str, float]]:
    """Rows of what is measured: the spread between phase polynomials, with noise; and what is given."""
    value = known.values(answer.scale)[known.measured]
    power = EXPONENTS[known.measured]
    rows = [("phase polynomials", abs(value / power) * answer.scale_sd / answer.scale)]
    for name, sd in known.sd.items():
        rows.append((name, abs(value * EXPONENTS[name] / power) * sd / known.given[name]))
    return rows


def _with_another_curve(task: Task) -> Photograph | None:
    """The photograph as linear light, where sRGB was assumed and may be wrong."""
    codes = task.photograph.codes
    if task.keeps_curve or codes.curve.exponent is not None:
        return None
    return replace(task.photograph, codes=replace(codes, curve=replace(codes.curve, exponent=1.0)))


def _parameters(answer: ManyBeams) -> dict[str, Parameter]:
    rows = {"finesse": (answer.finesse, answer.finesse_sd), "fringe_scale": (answer.scale, answer.scale_sd)}
    return {name: Parameter(value, sd, False, name, TABLE[name].unit) for name, (value, sd) in rows.items()}


def _reason(parameters: dict[str, Parameter]) -> Statement:
    finesse, scale = parameters["finesse"], parameters["fringe_scale"]
    return Reason.MANY_BEAM_RINGS(
        finesse=with_sd(finesse.value, finesse.sd or None), scale=with_sd(scale.value, scale.sd or None, "per px²")
    )
