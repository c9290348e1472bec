"""The start of a form fit without a start: tiles, signs, demodulation, and a fit on the reduced picture."""

from typing import NamedTuple

import numpy as np

from fitting.irregularity.demodulation import demodulated, remainder_of
from fitting.irregularity.disc import Disc, Pupil, around, disc_of, reduced
from fitting.irregularity.indications import fringes_of
from fitting.irregularity.projection import FormFit, fit_form
from fitting.irregularity.seeds import forms
from fitting.irregularity.tiles import frequencies
from fitting.irregularity.zernike import TERMS

# Diameters of the reduced picture [px] and tiles over it, in the order in which they are tried.
_LADDER = ((220, 11), (220, 15), (320, 19), (640, 27))
# A form is accepted where the tiles that confirm it are this share, and the search ends there: right ones have 0.995
# and more, of which 0.99 leaves room for dust; wrong ones had up to 0.985.
LOCKED = 0.99
# A start is followed where so many tiles confirm it after demodulation; those of right forms were 0.96 and more.
_PROMISING = 0.85
# Where fringes are fewer, or less is explained, all forms of a rung are followed, for another one may lock as well: a
# cylinder folded over its axis was confirmed everywhere, explaining 0.92.
_FEW, _CLEAR = 10.0, 0.97
# Two forms have equal merit where their shares of the variance differ by less; nearer than this [turns] they are one.
_RIVAL, _APART = 0.02, 0.1


class Candidate(NamedTuple):
    """A form that the search came to, the share of tiles that confirm it, and its fit on the reduced picture."""

    fit: FormFit
    agreement: float

    @property
    def locked(self) -> bool:
        """Whether the tiles confirm it, at an optimum."""
        return self.agreement > LOCKED and self.fit.converged

    @property
    def clear(self) -> bool:
        """Whether no other form need be looked for: it explains too much, with too many fringes, for a fold."""
        return self.locked and self.fit.explained > _CLEAR and fringes_of(self.fit.coefficients) > _FEW


class Search(NamedTuple):
    """The candidates, best first, and how many starts were followed."""

    candidates: list[Candidate]
    starts: int

    @property
    def rivals(self) -> list[Candidate]:
        """Candidates of equal merit whose form is another one, up to the sign of all."""
        best, *following = self.candidates
        least = best.fit.explained - _RIVAL
        equal = [x for x in following if x.locked and x.fit.explained > least]
        return [x for x in equal if distance(x.fit, best.fit) > _APART]


def distance(first: FormFit, second: FormFit) -> float:
    """How far two forms lie apart, rms over the pupil, the piston and the sign of all left out [turns]."""
    count = min(len(first.coefficients), len(second.coefficients))
    first_terms, second_terms = first.coefficients[1:count], second.coefficients[1:count]
    return float(min(np.linalg.norm(first_terms - second_terms), np.linalg.norm(first_terms + second_terms)))


def search(image: np.ndarray, mask: np.ndarray, pupil: Pupil, terms: int = TERMS) -> Search:
    """Forms of a picture [rows, columns]; ends at the first that its tiles confirm, and else follows every start."""
    candidates, starts = [], 0
    image, mask, pupil = around(image, mask, pupil)
    for diameter, side in _LADDER:
        factor = max(int(2 * pupil.radius / diameter), 1)
        disc = disc_of(*reduced(image, mask, factor), pupil.reduced(factor))
        for start in forms(frequencies(disc, side), terms):
            starts += 1
            candidate = _followed(disc, start)
            candidates += [] if candidate is None else [candidate]
            if candidate is not None and candidate.clear:
                return Search(_sorted(candidates), starts)
        if any(candidate.locked for candidate in candidates):
            break
    return Search(_sorted(candidates), starts)


def _followed(disc: Disc, start: np.ndarray) -> Candidate | None:
    """The fit from a start; None where too few tiles confirm what it comes to."""
    form, agreement = demodulated(disc, start)
    if agreement < _PROMISING:
        return None
    fit = fit_form(disc, form)
    return Candidate(fit, remainder_of(disc, fit.coefficients).agreement)


def _sorted(candidates: list[Candidate]) -> list[Candidate]:
    """Those that are confirmed first, by what they explain."""
    return sorted(candidates, key=lambda x: (-min(x.agreement, LOCKED), -x.fit.explained))
