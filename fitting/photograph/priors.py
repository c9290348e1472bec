"""What is known of a fit's numbers before the image is seen."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fitting.estimate import Prior
from fitting.model import AXIS, PARTS, PRIORS, anchors_of, numbers_of
from fitting.parameters import Numbers

# Where the axis of a picture may lie that has been cut, in half diagonals from its middle.
CUT = 0.25
# Shapes of cameras' frames: long over short side, and by how much they may differ.
_SHAPES, _ALIKE = (4 / 3, 3 / 2, 16 / 9, 5 / 4), 0.005


def may_be_cut(shape: tuple[int, ...]) -> bool:
    """Whether a picture has not the shape of a camera's frame."""
    ratio = max(shape[:2]) / min(shape[:2])
    return all(abs(ratio / other - 1) > _ALIKE for other in _SHAPES)


@dataclass(frozen=True)
class Priors:
    """Priors of the parts' numbers, by name (value, standard deviation); the phase where faces touch [turns].

    `may_be_cut`: whether the picture has not the shape of a camera's: then its axis may lie anywhere.
    """

    contact_phase: float
    given: Mapping[str, tuple[float, float]]
    may_be_cut: bool = False

    @property
    def numbers(self) -> dict[str, tuple[float, float]]:
        """By number: what is given, else what its part says."""
        return {**PRIORS, **self.given}

    def table(self, parts: Iterable[str]) -> dict[str, dict[str, Any]]:
        """By number of parts: value, standard deviation, and the reason, for a report."""
        parts, rows = tuple(parts), {}
        for part in parts:
            for name in PARTS[part].priors:
                value, sd = self.numbers[name]
                reason = "measured on the grid" if name in self.given else PARTS[part].prior_words
                rows[name] = {"value": value, "sd": sd, "reason": reason}
        for name, sd in anchors_of(parts).items():
            rows[name] = {"value": self.contact_phase, "sd": sd, "reason": "the phase of touching faces, in turns"}
        return rows

    def words(self, part: str) -> str:
        """Why a part is there for certain."""
        return "measured on the grid" if set(PARTS[part].parameters) & set(self.given) - set(AXIS) else "asked for"

    def cut(self) -> "Priors":
        """The same for a picture that has been cut out of a larger one."""
        axis = dict.fromkeys(AXIS, (0.0, CUT))
        return replace(self, given={**axis, **self.given})

    def of(self, parts: Iterable[str], numbers: np.ndarray, variance: float) -> Prior:
        """For a fit with parts; the phase of contact is meant up to whole turns: the nearest to the numbers' own.

        `variance`: of the light per unit weight, errors that neighbours share included.
        """
        parts, start = tuple(parts), Numbers(*numbers)
        centres = {name: self.numbers[name] for name in numbers_of(parts) if name in self.numbers}
        for name, sd in anchors_of(parts).items():
            offset = getattr(start, name) - self.contact_phase
            centres[name] = (self.contact_phase + float(np.round(offset)), sd)
        return Prior(centres, variance)
