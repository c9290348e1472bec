"""What a part of the rings' model is: the abstract class, which leaves the phase as it is."""

from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from fitting.parameters import Numbers


class Flattening(NamedTuple):
    """What r² [px²] becomes, and its derivatives: by r², and by the part's numbers, by name, each as an area [px²]."""

    value: np.ndarray
    by_r2: np.ndarray | float
    by_number: Mapping[str, np.ndarray]


class Shown(NamedTuple):
    """A number as a result shows it: its name and value there, and the value's change per unit of the number."""

    name: str
    value: Any
    slope: Any


class Law(NamedTuple):
    """What a part leaves out: its row of the budget, the number that stands for it, and how large that may be."""

    row: str
    number: str
    size: float


class AbstractPart:
    """A part of the model: its numbers, by name, and what they do to the phase.

    - `name`: what reports, budgets and `parts=` of a fit call it; `parameters`: its numbers, entries of `TABLE`.
    - `needs`: parts without which there is none; `anchors`: the phase of touching faces as a prior of the phase, with
      its standard deviation [turns]; `lifts`: anchors of other parts that it takes away.
    - `is_warp`: whether it is smooth in its numbers from 0 on, so that an answer is averaged over it; a traced bench
      can have it, too, where it bends the map from the image to the object alone.

    What it does to that map, from a pixel u, counted from the middle in half diagonals, to the object's point:

    - `radial_power` p: its number c moves the point to u (1 + c |u|²ᵖ), next to those of other parts.
    - `axis`: two numbers, where the camera's axis passes through the image, from its middle in half diagonals; u is
      then counted from there. They mean nothing without the part, whose other numbers are 0 then.
    - `displacements`: where a unit of each number moves the point, as any (x, y).
    - `polynomials`: by number, what a unit of it adds to the phase [turns]: coefficients of x^i y^j by (i, j), with x
      and y from the rings' centre over the reach of the field from there.
    - `stretches`: two numbers, a and b; an offset from the rings' centre is exp([[a, b], [b, -a]] / 2) times as large.

    And to the gap, by `flatten`: `edge` is the number above 0 of which that has an edge which nodes do not resolve.

    How it is chosen:

    - `probes`: numbers that a score test tries, of a part that is searched from several `starts`; without them the test
      goes by the derivatives at 0. `at_centre`: whether it is seen only where the rings' centre is in the field.
      `also_from`: numbers, beside those at 0, from which a fit with it starts too: it has optima of its own there.
    - `price`: of it in the criterion, in numbers, as many as it has unless given; `clear`: by how much better the
      criterion has to be with it.
    - `priors`: by number, its value and standard deviation before the image is seen; `prior_words`: their reason.
    - `unfitted`: what is said where it was asked for and is not found; `advice`: by row of the budget, what makes the
      row smaller.

    Formulae work on numbers, on arrays of NumPy and on those of JAX.
    """

    name: str
    parameters: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    anchors: Mapping[str, float] = MappingProxyType({})
    lifts: tuple[str, ...] = ()
    is_warp: bool = False
    radial_power: int = 0
    axis: tuple[str, ...] = ()
    stretches: tuple[str, str] | None = None
    edge: str = ""
    probes: tuple[Mapping[str, float], ...] = ()
    also_from: tuple[Mapping[str, float], ...] = ()
    at_centre: bool = False
    price: int | None = None
    clear: float = 0.0
    polynomials: Mapping[str, Mapping[tuple[int, int], float]] = MappingProxyType({})
    priors: Mapping[str, tuple[float, float]] = MappingProxyType({})
    prior_words: str = ""
    unfitted: str = "it is not found"
    advice: Mapping[str, str] = MappingProxyType({})

    def displacements(self, ux, uy, u2) -> dict[str, tuple[Any, Any]]:  # noqa: ARG002
        """By number, (x, y); `u2`: |u|², of a centre beyond the frame 1, since nothing is known of the lens there.

        Derivatives are taken by complex numbers: sums and products alone go.
        """
        return {}

    def reach(self, numbers: Numbers) -> Any:  # noqa: ARG002
        """By how much r² on the object exceeds that of the stretched offset."""
        return 1.0

    def reach_slopes(self, numbers: Numbers, by_reach) -> dict[str, Any]:  # noqa: ARG002
        """Derivatives by its numbers of what changes with `reach` by `by_reach`."""
        return {}

    def flatten(self, r2, unit2, numbers: Numbers) -> Any:  # noqa: ARG002
        """By JAX, what becomes of r² [px²], to which the gap of shallow touching spheres is proportional.

        `unit2`: half a diagonal squared [px²], in which numbers that are areas are counted.
        """
        return r2

    def flattening(self, r2: np.ndarray, unit2, numbers: Numbers) -> Flattening:
        """The same with its derivatives, by NumPy."""
        raise NotImplementedError

    def starts(self, plain: Numbers) -> list[Numbers]:
        """Where to search it from, for the numbers of a fit without it."""
        raise NotImplementedError

    def is_beside(self, numbers: Numbers, reference: Numbers) -> bool:
        """Whether two searches end at the same optimum."""
        raise NotImplementedError

    def anchored(self, numbers: Numbers, phase: float, turn: float) -> Numbers:
        """The nearest numbers at its anchor, for those of a fit in which another part has lifted it.

        `phase`: of contact [turns]; `turn`: half a turn where the fit's contrast is negative.
        """
        raise NotImplementedError

    def law(self, numbers: Numbers, present: Collection[str]) -> Law | None:  # noqa: ARG002
        """What it leaves out beside the parts that are there; None for nothing."""
        return None

    def shown(self, numbers: Numbers, length: float, is_scaled: bool) -> dict[str, Shown]:
        """Its numbers in a result, where not as they are; `length`: half a diagonal [m], or [px] without a scale."""
        raise NotImplementedError

    def number_of(self, name: str, value, length):  # noqa: ARG002  # others need all
        """A number of the model for its value in a result; the inverse of `shown`."""
        return value
