"""A number as results hold it: with its name, unit and standard deviation."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fitting.parameters.digits import text_of
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

    def __str__(self) -> str:
        return f"{self.name} = {text_of(self)}" + (" (given)" if self.fixed else "")


def parameters_from(saved: Mapping[str, Any]) -> dict[str, Parameter]:
    """The parameters in a saved result; files of earlier versions have none, or ones without name and unit."""
    rows: Mapping[str, Mapping[str, Any]] = saved.get("parameters", {})
    return {name: Parameter(**{"name": name, "unit": UNITS.get(name, ""), **row}) for name, row in rows.items()}
