"""Draws from a posterior, and how far they may be trusted."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fitting.parameters import AbstractResult, Origin, common_from, rounded, with_sd
from fitting.reasons import Reason
from fitting.sampling.density import NEAR, excursions, in_blocks
from fitting.sampling.posterior_function import LogPosterior
from fitting.sampling.tension import tensions
from newtonjax.numerics import require_number, shown

# A chain shorter than this many autocorrelation times tells no quantile (emcee's documentation; Sokal 1997).
_LONG = 50


@dataclass(frozen=True, repr=False, eq=False)
class Chain(AbstractResult):
    """What was drawn after burn-in, and how far it may be trusted.

    - `status`: "ok", or "not-converged" where `message` says why no quantile is quoted.
    - `names`; `values` [steps, walkers, names] in SI units (centre in pixels, gap's phase in turns); `log_prob`
      [steps, walkers], up to a constant.
    - `autocorrelation_time` [names] in steps (Goodman and Weare 2010); `effective` draws, the fewest of any name.
    - `acceptance`: mean share of accepted moves; `split_rhat` [names]: half-chains against each other.
    - `priors`: of the user's own, by name in words; `warnings`: those that the image contradicts.

    The posterior is that of the model and of what was given: rows of the fit's budget for what the model leaves out are
    not in it.
    """

    names: tuple[str, ...]
    values: np.ndarray
    log_prob: np.ndarray
    autocorrelation_time: np.ndarray
    effective: float
    acceptance: float
    split_rhat: np.ndarray
    status: str = "ok"
    message: str = ""
    warnings: list[str] = field(default_factory=list)
    origin: Origin | None = None
    priors: Mapping[str, str] = field(default_factory=dict)

    def of(self, name: str) -> np.ndarray:
        """All draws of one number. Raises ValueError for an unknown name."""
        if not (isinstance(name, str) and name in self.names):
            raise ValueError(f"the chain has no {shown(name)}; it has {', '.join(self.names)}")
        return self.values[:, :, self.names.index(name)].ravel()

    def draws(self) -> dict[str, np.ndarray]:
        """The draws by name, each [walkers, steps]: chains by draws, as ArviZ takes a posterior."""
        return {name: self.values[:, :, k].T for k, name in enumerate(self.names)}

    def interval(self, name: str, coverage: float = 0.95) -> tuple[float, float]:
        """Quantiles with equal tails.

        Raises ValueError for an unknown name, a coverage that is none, and a chain too short to tell them.
        """
        require_number("coverage", coverage, "a number between 0 and 1", lambda share: (share > 0) & (share < 1))
        if self.message:
            raise ValueError(self.message)
        low, high = np.quantile(self.of(name), [(1 - coverage) / 2, (1 + coverage) / 2])
        return float(low), float(high)

    def to_dict(self) -> dict[str, Any]:
        """The chain for JSON: by name mean, standard deviation and 95 % (null where none is quoted); its draws."""
        return {
            "status": self.status,
            "message": str(self.message),
            "steps": len(self.values),
            "walkers": self.values.shape[1],
            "effective_draws": self.effective,
            "acceptance": self.acceptance,
            "parameters": {
                name: {
                    "mean": float(self.of(name).mean()),
                    "sd": float(self.of(name).std()),
                    "interval": None if self.message else list(self.interval(name)),
                    "autocorrelation_time_steps": float(self.autocorrelation_time[k]),
                    "split_rhat": float(self.split_rhat[k]),
                }
                for k, name in enumerate(self.names)
            },
            "priors": dict(self.priors),
            **self._common(),
            "draws": self.values.tolist(),
            "log_prob": self.log_prob.tolist(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "Chain":
        """The chain that `to_dict` was called of."""
        parameters = saved["parameters"]
        return cls(
            tuple(parameters),
            np.array(saved["draws"], float),
            np.array(saved["log_prob"], float),
            np.array([row["autocorrelation_time_steps"] for row in parameters.values()], float),
            saved["effective_draws"],
            saved["acceptance"],
            np.array([row["split_rhat"] for row in parameters.values()], float),
            *common_from(saved),
            saved.get("priors", {}),
        )

    def figure(self, ax=None) -> Any:
        """Histograms of all numbers and of all pairs, with median and 68 %.

        Raises ValueError with `ax`: there are as many axes as pairs of numbers.
        """
        from fitting.sampling.figures import corner_figure

        if ax is not None:
            raise ValueError("a corner plot has as many axes as pairs of numbers; leave ax out")
        return corner_figure(self.names, self.values)

    def trace_figure(self) -> Any:
        """Every walker of every number against the step, burn-in left out."""
        from fitting.sampling.figures import trace_figure

        return trace_figure(self.names, self.values)

    def report(self) -> str:
        """The chain as text."""
        lines = [
            f"[[Posterior]]  {self.values.shape[1]} chains of {len(self.values)} steps, {self.effective:.0f} effective "
            f"draws, acceptance {self.acceptance:.2f}" + (f"; {self.message}" if self.message else "")
        ]
        for k, name in enumerate(self.names):
            mean, sd = float(self.of(name).mean()), float(self.of(name).std())
            interval = (
                "" if self.message else " (95 %: {} to {})".format(*(rounded(x, sd) for x in self.interval(name)))
            )
            lines += [
                f"    {name:<14} {with_sd(mean, sd)}{interval}"
                f", autocorrelation {self.autocorrelation_time[k]:.0f} steps, R-hat {self.split_rhat[k]:.3f}"
            ]
        lines += [f"    prior of {name}: {words}" for name, words in self.priors.items()]
        lines += [f"    warning: {warning}" for warning in self.warnings]
        return "\n".join(lines)


def chain_of(density: LogPosterior, points: np.ndarray, log_prob: np.ndarray, acceptance: float) -> Chain:
    """The chain of points [steps, walkers, dimensions] after burn-in, with its diagnostics."""
    import emcee

    flat = points.reshape(-1, density.dimensions)
    # A walker that does not move stays where its last excursion is known.
    excursion = float(in_blocks(excursions, density.target, np.unique(flat, axis=0)).max())
    columns = density.values(flat)
    values = np.stack(list(columns.values()), axis=1).reshape(*points.shape[:2], -1)
    with np.errstate(invalid="ignore"):  # a walker that has never moved has no autocorrelation
        time = np.atleast_1d(emcee.autocorr.integrated_time(values, quiet=True, tol=0))
    length, slowest = len(values), float(np.max(time))
    message = ""
    if not np.isfinite(slowest) or length < _LONG * slowest:
        least = int(_LONG * slowest * 4 / 3) + 1 if np.isfinite(slowest) else 4 * length
        message = Reason.CHAIN_TOO_SHORT(steps=length, times=_LONG, slowest=slowest, least=least)
    if excursion > 0.9 * NEAR:
        message = Reason.CHAIN_BEYOND_LIKELIHOOD(excursion=excursion, near=NEAR)
    return Chain(
        density.names,
        values,
        log_prob,
        time,
        values[:, :, 0].size / slowest,
        acceptance,
        split_rhat(values),
        "not-converged" if message else "ok",
        message,
        [*tensions(density, columns)],
        priors={name: prior.words for name, prior in density.priors.items()},
    )


def split_rhat(values: np.ndarray) -> np.ndarray:
    """Potential scale reduction of half-chains (Gelman et al., Bayesian Data Analysis, 3rd ed., section 11.4)."""
    half = len(values) // 2
    chains = np.concatenate([values[:half], values[half : 2 * half]], axis=1)
    within = chains.var(axis=0, ddof=1).mean(axis=0)
    between = half * chains.mean(axis=0).var(axis=0, ddof=1)
    return np.sqrt((half - 1) / half + between / (half * within))
