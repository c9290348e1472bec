"""A number as results hold it: with its name, unit and standard deviation."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fitting.parameters.digits import exact, with_sd
from fitting.parameters.table import UNITS


@dataclass(frozen=True)
class Parameter:
    """A number of a result: its value and standard deviation, in SI units or pixels, and whether it was given.

    `sd` is None where the number is fixed, or where no standard deviation is known; `unit` is empty where it has none.
    """

    value: float
    sd: float | None
    fixed: bool
    name: str
    unit: str

    @property
    def text(self) -> str:
        """Value, standard deviation and unit, in a unit of its size."""
        # What was given is shown as it was; a fitted number without a deviation has no tenth digit.
        is_exact = self.fixed and not self.sd
        return exact(self.value, self.unit) if is_exact else with_sd(self.value, self.sd or None, self.unit)

    def __str__(self) -> str:
        return f"{self.name} = {self.text}" + (" (given)" if self.fixed else "")


def parameters_from(saved: Mapping[str, Any]) -> dict[str, Parameter]:
    """The parameters in a saved result; files of earlier versions have none, or ones without name and unit."""
    rows: Mapping[str, Mapping[str, Any]] = saved.get("parameters", {})
    return {name: Parameter(**{"name": name, "unit": UNITS.get(name, ""), **row}) for name, row in rows.items()}
