"""What `sensitivity` returns: how well each fixed number must be known, as text, JSON and picture."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from fitting.parameters import AbstractResult, Origin, common_from


@dataclass(frozen=True)
class Neglected:
    """A number that a fit holds fixed, and what that costs.

    - `name`, `unit`, `value`: of the number.
    - `size`: its value, or what matters of it where that is zero [`unit`].
    - `slope`: change of the target per unit by which the number is held too large, in their units.
    - `tolerance`: the error of the number that moves the target by the accuracy asked for; infinite where that is more
      than 1000 times its size.
    """

    name: str
    unit: str
    value: float
    size: float
    slope: float
    tolerance: float


@dataclass(frozen=True, repr=False, eq=False)
class Sensitivity(AbstractResult):
    """What a measured number owes to each fixed one, the most critical first.

    - `target`, `value`, `unit`: the number that is measured.
    - `relative_accuracy`: asked for, as a fraction of the value; `accuracy`: the same in its unit.
    - `sd`: Cramér–Rao bound of the target with the free numbers unknown [unit].
    - `free`: what the fit determines with it; `neglected`: what it holds fixed.
    - `images`: a function from names to derivatives of the image by these numbers, each [rows, columns] in
      photoelectrons per unit; None in a loaded result, which draws the tolerances alone.
    """

    target: str
    value: float
    unit: str
    relative_accuracy: float
    sd: float
    free: tuple[str, ...]
    neglected: tuple[Neglected, ...]
    status: str = "ok"
    message: str = ""
    warnings: list[str] = field(default_factory=list)
    origin: Origin | None = None
    images: Callable[[Sequence[str]], dict[str, np.ndarray]] | None = None

    @property
    def accuracy(self) -> float:
        """The accuracy asked for [unit]."""
        return self.relative_accuracy * abs(self.value)

    def figure(self, ax=None) -> Any:
        """How well each number must be known, and derivatives of the image, each on its own scale; a matplotlib figure.

        With `ax`, and for a loaded result, the tolerances alone.
        """
        from fitting.studies.figures import tolerances

        return tolerances(self, ax)

    def to_dict(self) -> dict[str, Any]:
        """The result for JSON: units beside the numbers; None for a tolerance that is infinite."""
        return {
            "status": self.status,
            "message": str(self.message),
            "target": self.target,
            "value": self.value,
            "unit": self.unit,
            "relative_accuracy": self.relative_accuracy,
            "accuracy": self.accuracy,
            "sd": self.sd,
            "free": list(self.free),
            "neglected": [asdict(number) for number in self.neglected],
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "Sensitivity":
        """The result that `to_dict` was called of."""
        return cls(
            saved["target"],
            saved["value"],
            saved["unit"],
            saved["relative_accuracy"],
            saved["sd"],
            tuple(saved["free"]),
            tuple(_neglected(dict(row)) for row in saved["neglected"]),
            *common_from(saved),
        )

    def report(self) -> str:
        """A table: a row for each fixed number, the most critical first."""
        lines = [
            f"{self.target} = {self.value:.6g} {self.unit}, noise alone {self.sd:.2g} {self.unit}; "
            f"free with it: {', '.join(self.free) or 'nothing'}",
            f"to know it to {self.accuracy:.2g} {self.unit} ({self.relative_accuracy:.2g} of it):",
            f"{'':<14} {'value':>12} {'known to':>11} {'unit':<15} {self.target} per unit",
        ]
        lines[2:2] = self.warnings
        for number in self.neglected:
            tolerance = "any" if np.isinf(number.tolerance) else f"{number.tolerance:.2g}"
            lines.append(
                f"{number.name:<14} {number.value:>12.6g} {tolerance:>11} {number.unit:<15} {number.slope:+.4g}"
            )
        return "\n".join(lines)


def _neglected(row: dict[str, Any]) -> Neglected:
    """JSON has no infinity: None stands for it."""
    values = dict(row)
    if values["tolerance"] is None:
        values["tolerance"] = np.inf
    return Neglected(**values)
