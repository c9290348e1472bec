"""What is asked of every fit before its answer leaves: all rivals, in one loop."""

from collections.abc import Callable, Collection

from fitting.estimate import FEW, Fitted
from fitting.photograph.fringe_rivals import Astray, SecondSystem, Waveform
from fitting.photograph.model_rivals import Form, PriorTension, ViewOrForm
from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding

RIVALS: tuple[AbstractRival, ...] = (Astray(), Waveform(), SecondSystem(), Form(), ViewOrForm(), PriorTension())
# What leaves less of the variance over was no photograph, and holds rounding.
_ROUNDED = 1e-8


def findings_of(
    fit: Fitted, decided: Collection[str] = (), further: Callable[[float], Finding | None] | None = None
) -> tuple[list[Finding], list[tuple[str, float]]]:
    """What rivals say of a finished fit, and the rows that they add: (source, deviation of its first number).

    `decided`: names of those on which something else that is given decides; `further`: what speaks for the scale of the
    fit [turns per px²] beside what it leaves over. Nothing where it leaves rounding alone, or
    has too few fringes to tell.
    """
    if not fit.converged or fit.orders < FEW or not 1 - fit.explained > _ROUNDED:
        return [], []
    remainder = Remainder(fit)
    answers = [rival.finding(remainder) for rival in RIVALS if rival.name not in decided]
    if further is not None:
        answers.append(further(abs(remainder.scale)))
    findings = [finding for finding in answers if finding is not None]
    return findings, [(finding.rival, finding.deviation * remainder.first) for finding in findings if finding.deviation]
