"""What an image can determine of a bench: an information matrix, and the bounds on standard deviations that follow."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from fitting.parameters import AbstractResult, Origin, common_from, read_sd
from fitting.reasons import Reason
from fitting.studies.undetermined import in_words
from newtonjax.numerics import Joined, shown

# A combination is called undetermined where its information is this small a fraction of what its parts have by
# themselves.
_WEAK = 1e-8
# Fractions that rounding makes of nothing.
_ROUNDING = 1e-13


@dataclass(frozen=True, repr=False, eq=False)
class Information(AbstractResult):
    """Fisher's information of parameters `names`, and what follows from it.

    - `units`, `values`, `scales`: by parameter; `matrix`: of the image alone, per unit squared.
    - `given_sd`: standard deviations of what is known from elsewhere [units]; 0 fixes a parameter.
    - `status`: "ok", or "undetermined" where `message` says which combinations the image does not determine.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Float[np.ndarray, " n"]
    scales: Float[np.ndarray, " n"]
    matrix: Float[np.ndarray, "n n"]
    given_sd: Mapping[str, float] = field(default_factory=dict)
    positive: tuple[bool, ...] = ()
    warnings: list[str] = field(default_factory=list)
    origin: Origin | None = None

    status: str = field(init=False)
    message: str = field(init=False)

    def __post_init__(self):
        undetermined = self.undetermined
        object.__setattr__(self, "status", "undetermined" if undetermined else "ok")
        combinations = Joined("; ", undetermined)
        message = Reason.UNDETERMINED_COMBINATIONS(combinations=combinations) if undetermined else ""
        object.__setattr__(self, "message", message)

    def position(self, name: str) -> int:
        """Row of a parameter in the matrix. Raises ValueError for one that is not free."""
        if not (isinstance(name, str) and name in self.names):
            raise ValueError(f"{shown(name)} is not free; free are {', '.join(self.names)}")
        return self.names.index(name)

    def with_sd(self, **sd: float | str) -> "Information":
        """The same with standard deviations of some parameters from elsewhere [units], or as "0.1%" of their values.

        0 fixes a parameter. Raises ValueError for one that is not free, and for what is not a standard deviation.
        """
        absolute = {}
        for name, stated_sd in sd.items():
            value = abs(float(self.values[self.position(name)]))
            is_relative, size = read_sd(stated_sd)
            if not 0 <= size < np.inf:
                raise ValueError(
                    f"sd: {name} is {shown(stated_sd)}; allowed: zero, a positive number in its unit, or a percentage"
                )
            absolute[name] = size * value if is_relative else size
        return replace(self, given_sd={**self.given_sd, **absolute})

    @property
    def covariance(self) -> Float[np.ndarray, "n n"]:
        """Bound on the covariance of unbiased estimates [units]; a variance is infinite where nothing determines it."""
        scaled = self._scaled()
        fixed = self._fixed()
        bound = np.zeros_like(scaled)
        if fixed.all():
            return bound
        # To unit diagonal with the priors in it: then a prior, however tight, hides nothing of the others.
        size = np.diag(scaled)
        unit = 1 / np.sqrt(np.where(size > 0, size, 1.0))
        size, axes = np.linalg.eigh((scaled * np.outer(unit, unit))[np.ix_(~fixed, ~fixed)])
        determined = size > _ROUNDING * len(size)
        inverse = (axes[:, determined] / size[determined]) @ axes[:, determined].T
        undetermined = (axes[:, ~determined] ** 2).sum(axis=1) > 1e-10
        inverse[undetermined, undetermined] = np.inf
        bound[np.ix_(~fixed, ~fixed)] = inverse
        step = self._steps() * unit
        return bound * np.outer(step, step)

    def sd(self, name: str) -> float:
        """Bound on the standard deviation of a parameter, the others free, but for `given_sd` [unit].

        Raises ValueError for a parameter that is not free.
        """
        k = self.position(name)
        return float(np.sqrt(self.covariance[k, k]))

    def sd_if_all_known(self, name: str) -> float:
        """Bound on the standard deviation of a parameter if all others were known exactly [unit].

        Raises ValueError for a parameter that is not free.
        """
        k = self.position(name)
        prior = self.given_sd.get(name)
        if prior == 0:
            return 0.0
        information = self.matrix[k, k] + (0.0 if prior is None else prior**-2)
        return float(information**-0.5) if information > 0 else np.inf

    def sd_if_known(self, name: str) -> dict[str, float]:
        """Bound on a parameter [unit] if one other parameter were known exactly, for each of the others.

        Raises ValueError for a parameter that is not free.
        """
        remaining = self.names[: self.position(name)] + self.names[self.position(name) + 1 :]
        return {fixed: self.with_sd(**{fixed: 0.0}).sd(name) for fixed in remaining}

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Combinations of parameters that image and priors do not determine."""
        unit = 1 / np.sqrt(np.maximum(np.diag(self._scaled()), 1e-300))
        fixed = self._fixed()
        visible = np.diag(self._scaled()) > 0
        words = [f"{self.names[k]}: the image does not change with it" for k in np.flatnonzero(~visible & ~fixed)]
        visible &= ~fixed
        if visible.sum() < 2:
            return tuple(words)
        normal = (self._scaled() * np.outer(unit, unit))[np.ix_(visible, visible)]
        size, axes = np.linalg.eigh(normal)
        weak = size < _WEAK
        if not weak.any():
            return tuple(words)
        references = np.where(self._ratio(), np.abs(self.values), self.scales)
        names = [name for name, is_visible in zip(self.names, visible, strict=True) if is_visible]
        relative = (unit * self._steps() / references)[visible]
        return (*words, *in_words(names, self._ratio()[visible], relative, axes[:, weak]))

    def _fixed(self) -> np.ndarray:
        return np.array([self.given_sd.get(name) == 0 for name in self.names])

    def _ratio(self) -> np.ndarray:
        return np.array(self.positive or (False,) * len(self.names))

    def _steps(self) -> np.ndarray:
        """Standard deviation of each parameter by itself [units]; its scale where the image does not change with it."""
        size = np.diag(self.matrix)
        return np.where(size > 0, 1 / np.sqrt(np.where(size > 0, size, 1.0)), self.scales)

    def _scaled(self) -> np.ndarray:
        step = self._steps()
        prior = [self.given_sd.get(name, np.inf) for name in self.names]
        from_priors = [(s / p) ** 2 if p else 0.0 for s, p in zip(step, prior, strict=True)]
        return self.matrix * np.outer(step, step) + np.diag(from_priors)

    def figure(self, ax=None) -> Any:
        """Correlations of the bounds, as a matplotlib figure; drawn into `ax` where it is given."""
        from fitting.studies.figures import correlations

        return correlations(self, ax)

    def to_dict(self) -> dict[str, Any]:
        """The bounds for JSON: units beside the parameters, None for what is infinite."""
        return {
            "status": self.status,
            "message": str(self.message),
            "parameters": {
                name: {
                    "value": float(self.values[k]),
                    "unit": self.units[k],
                    "sd": self.sd(name),
                    "sd_if_all_known": self.sd_if_all_known(name),
                    "scale": float(self.scales[k]),
                    "positive": bool(self._ratio()[k]),
                }
                for k, name in enumerate(self.names)
            },
            "given_sd": dict(self.given_sd),
            "matrix": self.matrix.tolist(),
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "Information":
        """The information that `to_dict` was called of."""
        rows, (_, _, warnings, origin) = saved["parameters"].values(), common_from(saved)
        return cls(
            tuple(saved["parameters"]),
            tuple(row["unit"] for row in rows),
            np.array([row["value"] for row in rows], float),
            np.array([row["scale"] for row in rows], float),
            np.array(saved["matrix"], float),
            dict(saved["given_sd"]),
            tuple(row["positive"] for row in rows),
            warnings,
            origin,
        )

    def report(self) -> str:
        """A table: a row for each parameter, then what is undetermined."""
        rows = [f"{'':<14} {'value':>12} {'sd':>10} {'others known':>13} {'unit':<14}".rstrip()]
        for k, name in enumerate(self.names):
            rows.append(
                f"{name:<14} {self.values[k]:>12.6g} {self.sd(name):>10.2g} {self.sd_if_all_known(name):>13.2g} "
                f"{self.units[k]:<14}".rstrip()
            )
        return "\n".join([*rows, *(f"undetermined: {text}" for text in self.undetermined)])
