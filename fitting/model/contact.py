"""The part of faces that are pressed together: a disc of contact, and what it does to the gap around it."""

import jax
import numpy as np

from fitting.model.part import AbstractPart, Flattening
from fitting.parameters import Numbers
from newtonjax.scene import hertz_gap


class Contact(AbstractPart):
    """A sphere that is flattened on the plate (Hertz 1882), by its disc's squared radius [half diagonals²].

    In the disc the gap is nothing, so the phase is that of contact.
    """

    name = "contact"
    parameters = ("contact",)
    pins = ("phase",)
    edge = "contact"

    def flatten(self, r2, unit2, numbers: Numbers):
        """Twice the sphere's radius times the gap."""
        a2 = numbers.contact * unit2
        if isinstance(r2, jax.Array) or isinstance(a2, jax.Array):
            return hertz_gap(r2, a2)
        return r2 if a2 == 0 else _hertz(r2, a2)[0]

    def flattening(self, r2: np.ndarray, unit2, numbers: Numbers) -> Flattening:
        """The same with its derivatives."""
        gap, outwards, pressing = _hertz(r2, numbers.contact * unit2)
        return Flattening(gap, outwards, {"contact": pressing})


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
