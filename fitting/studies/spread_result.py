"""What `spread` returns: the scatter of a measured number, and each given number's fraction of its variance."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float

from fitting.parameters import AbstractResult, Origin, common_from


@dataclass(frozen=True)
class Share:
    """What one given number leaves uncertain.

    - `name`, `unit`, `sd`: of the number.
    - `slope_sd`: of the target, by its slope alone [unit of the target].
    - `first`, `total`: Sobol's indices, of first order and total; `first_range`, `total_range`: 95 % of each, by
      bootstrap over the draws (percentiles), which takes them for independent ones.
    """

    name: str
    unit: str
    sd: float
    slope_sd: float
    first: float
    first_range: tuple[float, float]
    total: float
    total_range: tuple[float, float]


@dataclass(frozen=True, repr=False, eq=False)
class Spread(AbstractResult):
    """The scatter of a measured number, the given number with the largest total index first.

    - `target`, `unit`, `value`: of the measured number; `free`: what is determined with it.
    - `sd`, `shift`: standard deviation of the target over the draws, and its mean less the value [unit]; `slope_sd`:
      the deviation that slopes alone predict.
    - `shares`: by given number; `draws`: one row a fit, the values it was given [units], and `targets`: the target
      there; `seed`.
    """

    target: str
    unit: str
    value: float
    free: tuple[str, ...]
    sd: float
    shift: float
    slope_sd: float
    shares: tuple[Share, ...]
    draws: dict[str, Float[np.ndarray, " fits"]]
    targets: Float[np.ndarray, " fits"]
    seed: int
    status: str = "ok"
    message: str = ""
    warnings: list[str] = field(default_factory=list)
    origin: Origin | None = None

    def figure(self, ax=None) -> Any:
        """The draws beside the normal curve that slopes predict, and each number's fraction of their variance.

        A matplotlib figure; with `ax` the draws alone.
        """
        from fitting.studies.figures import scatter

        return scatter(self, ax)

    def to_dict(self) -> dict[str, Any]:
        """The result for JSON: units beside the numbers, every draw."""
        return {
            "status": self.status,
            "message": str(self.message),
            "target": self.target,
            "unit": self.unit,
            "value": self.value,
            "free": list(self.free),
            "sd": self.sd,
            "shift": self.shift,
            "slope_sd": self.slope_sd,
            "shares": [
                {**asdict(share), "first_range": list(share.first_range), "total_range": list(share.total_range)}
                for share in self.shares
            ],
            "draws": {name: values.tolist() for name, values in self.draws.items()},
            "targets": self.targets.tolist(),
            "seed": self.seed,
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "Spread":
        """The result that `to_dict` was called of."""
        return cls(
            saved["target"],
            saved["unit"],
            saved["value"],
            tuple(saved["free"]),
            saved["sd"],
            saved["shift"],
            saved["slope_sd"],
            tuple(_share(row) for row in saved["shares"]),
            {name: np.array(values, float) for name, values in saved["draws"].items()},
            np.array(saved["targets"], float),
            saved["seed"],
            *common_from(saved),
        )

    def report(self) -> str:
        """A table: a row for each given number, the largest total index first."""
        unit = f" {self.unit}" if self.unit else ""
        lines = [
            f"{self.target} = {self.value:.6g}{unit}: errors of given numbers leave sd {self.sd:.2g}{unit} and move "
            f"the mean by {self.shift:+.2g}{unit} ({len(self.targets)} fits; by slopes alone sd "
            f"{self.slope_sd:.2g}{unit})",
            f"{'':<14} {'sd':>10} {'unit':<6} {'first order':>11} {'its 95 %':>16} {'total':>7} {'its 95 %':>16}",
        ]
        for share in self.shares:
            first, total = (f"{low:.3f} to {high:.3f}" for low, high in (share.first_range, share.total_range))
            row = f"{share.name:<14} {share.sd:>10.2g} {share.unit:<6} {share.first:>11.3f} {first:>16}"
            lines.append(f"{row} {share.total:>7.3f} {total:>16}")
        return "\n".join([*lines, *self.warnings])


def _share(row: Mapping[str, Any]) -> Share:
    """JSON has no tuples."""
    values: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in row.items()}
    return Share(**values)
