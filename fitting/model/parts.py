"""The parts of the rings' model in their order, and which numbers of a fit they have.

A fit's vector holds the numbers of all of them, whether they are there or not: without its part a number is 0.
"""

from collections.abc import Iterable

from fitting.model.contact import Contact
from fitting.model.distortion import Distortion, FifthOrder
from fitting.model.film import Film
from fitting.model.form import LensForm
from fitting.model.oblique_view import ObliqueView
from fitting.model.part import AbstractPart
from fitting.parameters import NUMBERS

# In the order in which they are tried, and dropped from the end.
_ORDER: tuple[AbstractPart, ...] = (ObliqueView(), Distortion(), FifthOrder(), LensForm(), Contact(), Film())
PARTS = {part.name: part for part in _ORDER}
WARPS = tuple(part.name for part in _ORDER if part.is_warp)
# Those that are searched from several starts, each with the part that lifts its anchor.
SEARCHED = {
    part.name: next(other for other in _ORDER if part.name in other.needs and other.lifts)
    for part in _ORDER
    if part.probes
}
ADVICE = {row: text for part in _ORDER for row, text in part.advice.items()}
PRIORS = {number: prior for part in _ORDER for number, prior in part.priors.items()}
PRICES = {part.name: len(part.parameters) if part.price is None else part.price for part in _ORDER}
# Those that have a method of their own: for the phase, and for what is left out.
DISPLACING, REACHING, FLATTENING, LEAVING_OUT, SHOWING = (
    tuple(part for part in _ORDER if getattr(type(part), method) is not getattr(AbstractPart, method))
    for method in ("displacements", "reach", "flatten", "law", "shown")
)
# The numbers of radial powers 1, 2, ... of |u|², pairs of numbers that stretch, and numbers above 0 that make an edge.
RADIAL = tuple(part.parameters[0] for part in sorted(_ORDER, key=lambda part: part.radial_power) if part.radial_power)
# What numbers add to the phase, by number.
POLYNOMIALS = {number: terms for part in _ORDER for number, terms in part.polynomials.items()}
# Where the camera's axis is: two numbers.
AXIS = next(part.axis for part in _ORDER if part.axis)
STRETCHES = tuple(part.stretches for part in _ORDER if part.stretches)
EDGES = tuple(part.edge for part in _ORDER if part.edge)


def numbers_of(names: Iterable[str]) -> tuple[str, ...]:
    """Names of the numbers that belong to parts."""
    return tuple(number for name in names for number in PARTS[name].parameters)


def anchors_of(names: Iterable[str]) -> dict[str, float]:
    """Numbers that parts bring to the phase of touching faces, with their deviation [turns]."""
    parts = [PARTS[name] for name in names]
    lifted = {number for part in parts for number in part.lifts}
    return {number: sd for part in parts for number, sd in part.anchors.items() if number not in lifted}


def free_numbers(fixed: dict, names: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Names of the numbers that move, for what the user fixed by name, and the parts that are there."""
    held = set(numbers_of(name for name in PARTS if name not in names))
    held |= {"phase"} if "gap" in fixed else set()
    held |= {"centre_x", "centre_y"} if "centre_px" in fixed else set()
    return tuple(name for name in NUMBERS if name not in held)
