"""A posterior's numbers by the names that a chain has for them, in its units; both ways, inside transformations too."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from fitting.estimate import Fitted
from fitting.model import PARTS, shown_of
from fitting.parameters import NUMBERS, Numbers, Quantities, result_names
from newtonjax.numerics import shown

_CENTRE = ("centre_x", "centre_y")
# Numbers of parts, by the part that they belong to.
_PART_OF = {name: part for part in PARTS.values() for name in part.parameters}


@dataclass(frozen=True)
class Naming:
    """The numbers of a posterior by name: the model's free ones that move, then the given quantities that are drawn.

    In SI units, centres in pixels, the phase at the centre in turns (`gap_turns`).
    """

    fitted: Fitted
    quantities: Quantities
    moving: tuple[str, ...]
    given: tuple[str, ...]

    @cached_property
    def by_slot(self) -> dict[str, str]:
        """The name of each number that moves, by its name in the model's vector."""
        numbers, is_scaled = Numbers(*self.fitted.numbers), self.quantities.unknown is not None
        of_parts = shown_of(self.fitted.parts, numbers, 1.0, is_scaled)
        names = result_names(self.quantities.unknown) | {slot: number.name for slot, number in of_parts.items()}
        # A phase stays one, and is no gap as in a result.
        names |= {"phase": "gap_turns"}
        return {slot: names[slot] for slot in self.moving}

    @property
    def names(self) -> tuple[str, ...]:
        """In the order of a chain's columns."""
        return (*self.by_slot.values(), *self.given)

    def values(self, free: Any, factors: Any) -> dict[str, Any]:
        """Values by name, of the model's numbers [free, ...] and of the factors of what is given [given, ...]."""
        numbers, frame = Numbers(*free), self.fitted.model.frame
        drawn = {name: self.quantities.given[name] * at for name, at in zip(self.given, factors, strict=True)}
        measured = self.fitted.model.measured(self.quantities, numbers.curvature, drawn)
        length = frame.unit * self._pixel_size(measured, drawn)
        of_parts = shown_of(self.fitted.parts, numbers, length, self.quantities.unknown is not None)
        columns = numbers._asdict() | {slot: number.value for slot, number in of_parts.items()}
        columns |= {"curvature": measured}
        columns |= {slot: at + frame.unit * columns[slot] for slot, at in zip(_CENTRE, frame.middle, strict=True)}
        return {name: columns[slot] for slot, name in self.by_slot.items()} | drawn

    def numbers(
        self, values: Mapping[str, Any], start: Float[Array, " free"]
    ) -> tuple[Float[Array, " free"], Float[Array, " given"]]:
        """The model's numbers and the factors of what is given, of values by name; `start`: of those that do not move.

        Raises ValueError where a name is missing or unknown.
        """
        self.check(values)
        frame = self.fitted.model.frame
        drawn = {name: jnp.asarray(values[name]) for name in self.given}
        measured = values.get(self.by_slot.get("curvature", ""))
        length = frame.unit * self._pixel_size(measured, drawn)
        free = start
        for slot, name in self.by_slot.items():
            number = jnp.asarray(values[name])
            if slot == "curvature":
                number = self.fitted.model.first_number(self.quantities, number, drawn)
            elif slot in _CENTRE:
                number = (number - frame.middle[_CENTRE.index(slot)]) / frame.unit
            elif slot in _PART_OF:
                number = _PART_OF[slot].number_of(slot, number, length)
            free = free.at[NUMBERS.index(slot)].set(number)
        factors = [value / self.quantities.given[name] for name, value in drawn.items()]
        return free, jnp.stack(factors) if factors else jnp.zeros(0)

    def slopes(self, free: Float[Array, " free"], factors: Float[Array, " given"]) -> dict[str, Any]:
        """By how much each named value that moves grows per unit of its number, all others as they are."""

        def slope(slot, name):
            place = NUMBERS.index(slot)

            def value_of(number):
                return self.values(free.at[place].set(number), factors)[name]

            return jax.jvp(value_of, (free[place],), (jnp.ones_like(free[place]),))[1]

        return {name: slope(slot, name) for slot, name in self.by_slot.items()}

    def check(self, values: Any) -> None:
        """Raise ValueError for what is no mapping of the names."""
        if not isinstance(values, Mapping):
            raise ValueError(f"values is {shown(values)}; allowed: a mapping of {', '.join(self.names)} to numbers")
        missing, unknown = ([n for n in a if n not in b] for a, b in ((self.names, values), (values, self.names)))
        if missing or unknown:
            names = f"missing: {', '.join(missing)}" if missing else f"unknown: {', '.join(map(str, unknown))}"
            raise ValueError(f"values has other names than the posterior ({names}); allowed: {', '.join(self.names)}")

    def _pixel_size(self, measured: Any, drawn: Mapping[str, Any]) -> Any:
        """Metres to a pixel; 1 without a scale, where lengths are in pixels."""
        if self.quantities.unknown is None:
            return 1.0
        sizes = {**self.quantities.given, **drawn, self.quantities.measured: measured}
        return sizes.get("pixel_size", 1.0)
