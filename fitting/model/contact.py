"""The part of faces that are pressed together: a disc of contact, and what it does to the gap around it."""

from types import MappingProxyType

import numpy as np

from fitting.model.part import AbstractPart, Flattening, Shown
from fitting.parameters import Numbers
from newtonjax.scene import hertz_gap

# Squared radii of discs that a search starts from [half diagonals squared].
_SQUARES = tuple(0.002 * 1.7**k for k in range(8))
# Turns of phase, and share of the contact, within which two of them go to the same optimum.
_BESIDE = 0.2
_TINY = 1e-300


class Contact(AbstractPart):
    """A sphere that is flattened on the plate (Hertz 1882), by its disc's squared radius [half diagonals²].

    In the disc the gap is nothing, so the phase is that of contact, but for what oxides and reflection add to it.
    """

    name = "contact"
    parameters = ("contact",)
    anchors = MappingProxyType({"phase": 0.04})
    edge = "contact"
    probes = tuple({"contact": square} for square in (0.003, 0.01, 0.03, 0.08))
    at_centre = True
    # Many discs are tried: the evidence has to be strong (Kass and Raftery 1995).
    clear = 6.0
    unfitted = "no contact disc fits the image; the fit has none"
    advice = MappingProxyType({"contact": "press less, or leave the rings next to the disc out by a mask"})

    def flatten(self, r2, unit2, numbers: Numbers):
        """Twice the sphere's radius times the gap."""
        return hertz_gap(r2, numbers.contact * unit2)

    def flattening(self, r2: np.ndarray, unit2, numbers: Numbers) -> Flattening:
        """The same with its derivatives."""
        gap, outwards, pressing = _hertz(r2, numbers.contact * unit2)
        return Flattening(gap, outwards, {"contact": pressing})

    def starts(self, plain: Numbers) -> list[Numbers]:
        """Discs of several sizes, the rings beyond them where they were."""
        return [plain._replace(phase=plain.phase + 2 * plain.curvature * a2, contact=a2) for a2 in _SQUARES]

    def is_beside(self, numbers: Numbers, reference: Numbers) -> bool:
        """Whether phases and discs are much the same: other optima are half a turn away."""
        widest = max(abs(numbers.contact), abs(reference.contact))
        same_turn = abs(numbers.phase - reference.phase) < _BESIDE
        return bool(same_turn and abs(numbers.contact - reference.contact) < _BESIDE * widest)

    def anchored(self, numbers: Numbers, phase: float, turn: float) -> Numbers:
        """Anchored, the phase beyond the disc allows a contact radius a turn: the nearest rung of that ladder.

        Nearest to the phase of a positive contrast, since a negative one is the same as half a turn.
        """
        nearest = phase + np.round(numbers.phase + turn - phase)
        contact = numbers.contact + (nearest - numbers.phase - turn) / (2 * numbers.curvature)
        return numbers._replace(phase=nearest, contact=contact)

    def shown(self, numbers: Numbers, length: float, is_scaled: bool) -> dict[str, Shown]:
        """The disc's radius."""
        size = abs(numbers.contact)
        root = ((numbers.contact + size) / 2) ** 0.5
        slope = length * root / (2 * size + _TINY)
        return {"contact": Shown("contact_radius" if is_scaled else "contact_radius_px", root * length, slope)}

    def number_of(self, name: str, value, length):  # noqa: ARG002  # others need all
        """The squared radius [half diagonals²] of a disc's radius."""
        return (value / length) ** 2


def _hertz(r2, a2):
    """`newtonjax.scene.hertz_gap` and its derivatives by r² and a².

    With t = sqrt(r²/a² - 1), and 0 inside the disc, arcsin(a/r) is π/2 - arctan t: Johnson's (1985) eq. 3.42a becomes
    a² (2/π) (t + (t² - 1) arctan t), a third of the work.
    """
    if a2 <= 0:
        return r2 - 2 * a2, np.ones_like(r2), np.full_like(r2, -2.0)
    t2 = np.maximum(r2 / a2 - 1, 0)
    t = np.sqrt(t2)
    angle = np.arctan(t)
    gap = (2 / np.pi) * a2 * (t + (t2 - 1) * angle)
    return gap, (2 / np.pi) * (angle + t / (1 + t2)), (-4 / np.pi) * angle
