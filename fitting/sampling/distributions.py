"""Priors of a user's own: pairs, distributions of scipy.stats or of libraries like NumPyro, functions."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from fitting.parameters import normal_pair, number, positive_sd
from newtonjax.numerics import is_real, shown

# Differences for the slope of a prior that JAX cannot trace, in standard deviations of the fit: a slope steers a
# sampler and decides nothing, as the density itself accepts or refuses.
_STEP = 1e-4
_ALLOWED = "(value, sd), a distribution with logpdf or log_prob, or a function of the value"


@dataclass(frozen=True)
class Distribution:
    """The prior of one named number.

    - `log_density`: its logarithm at a value, up to a constant, for JAX; `words`: what it is.
    - `place`: where a search for its mode begins.
    """

    log_density: Callable[[Any], Any]
    words: str
    place: float | None = None

    def at(self, values: np.ndarray) -> np.ndarray:
        """Log-densities at many values."""
        return np.asarray(jax.vmap(self.log_density)(jnp.asarray(values, float)), float)


def checked_distributions(
    priors: Any, values: Mapping[str, float], sds: Mapping[str, float]
) -> dict[str, Distribution]:
    """The priors of a user's by name; `values`, `sds`: of the fit, by name.

    Raises ValueError for a name that is none of these, and for what is no prior.
    """
    if priors is None:
        return {}
    if not isinstance(priors, Mapping):
        example = '{"radius": (1.0, 0.01)}'
        raise ValueError(f"priors is {shown(priors)}; allowed: a mapping of names to priors, such as {example}")
    for name in priors:
        if name not in values:
            raise ValueError(
                f"priors: {shown(name)} is not drawn; allowed: {', '.join(values)}; a given quantity is drawn where "
                "fit was told its sd, a number of a part where the fit has the part"
            )
    return {name: _distribution(name, prior, values[name], sds[name]) for name, prior in priors.items()}


def _distribution(name: str, prior: Any, value: float, sd: float) -> Distribution:
    pair = normal_pair(prior)
    if isinstance(pair, tuple | list):
        return _normal(name, pair)
    log_density = next((getattr(prior, key) for key in ("logpdf", "log_prob") if hasattr(prior, key)), prior)
    if not callable(log_density) or isinstance(prior, type):
        raise ValueError(f"priors: {name} is {shown(prior)}; allowed: {_ALLOWED}")
    traced = _within_support(prior, log_density)
    if not _is_traceable(name, traced, value):
        is_vector = hasattr(prior, "logpdf")
        traced = _called_back(log_density if is_vector else np.vectorize(log_density, otypes=[float]), _STEP * sd)
        _require_number(name, prior, traced, value)
    return Distribution(traced, _words(prior), _middle(prior))


def _normal(name: str, pair: Any) -> Distribution:
    if len(pair) != 2:
        raise ValueError(f"priors: {name} is {shown(pair)}; allowed: {_ALLOWED}")
    centre = number(f"priors: {name}", pair[0])
    sd = positive_sd(f"priors: {name}", pair[1], centre)
    constant = -np.log(sd) - 0.5 * np.log(2 * np.pi)
    return Distribution(lambda at: constant - 0.5 * ((at - centre) / sd) ** 2, f"{centre:.10g} ± {sd:.4g}", centre)


def _within_support(prior: Any, log_density: Callable) -> Callable:
    """With -inf beyond the support, which NumPyro's densities leave out; SciPy's `support` has another meaning."""
    support: Any = getattr(prior, "support", None)
    if not (hasattr(prior, "log_prob") and callable(support)):
        return log_density

    def within(at):
        is_inside: Any = support(at)
        return jnp.where(is_inside, log_density(at), -jnp.inf)

    return within


def _is_traceable(name: str, log_density: Callable, value: float) -> bool:
    """Whether JAX traces it. Raises ValueError where it then is no number."""
    try:
        result = jax.eval_shape(log_density, jnp.asarray(value))
    except Exception:  # whatever a function of NumPy makes of a tracer
        return False
    if getattr(result, "shape", None) != ():
        raise ValueError(f"priors: {name} gives {shown(result)} at one value; allowed: one number")
    return True


def _require_number(name: str, prior: Any, log_density: Callable, value: float) -> None:
    try:
        log_density(jnp.asarray(value))
    except Exception as error:
        reason = (str(error).strip() or type(error).__name__).splitlines()[-1]
        raise ValueError(f"priors: {name}, {_words(prior)}, fails at {value:.6g}: {reason}; {_ALLOWED}") from error


def _called_back(log_density: Callable, step: float) -> Callable:
    """A function of NumPy inside JAX's programs, its slope by central differences; no slope where it is not finite."""

    def values(at):
        with np.errstate(all="ignore"):
            return np.asarray(log_density(at), float).reshape(at.shape)

    def slopes(at):
        slope = (values(at + step) - values(at - step)) / (2 * step)
        return np.where(np.isfinite(slope), slope, 0.0)

    def call(function, at):
        # As words of 32 bits: in the thread of a callback JAX may round float64 to its default type.
        words = jax.lax.bitcast_convert_type(jnp.asarray(at, jnp.float64), jnp.uint32)
        shape = jax.ShapeDtypeStruct(words.shape, words.dtype)
        result = jax.pure_callback(partial(_on_words, function), shape, words, vmap_method="expand_dims")
        return jax.lax.bitcast_convert_type(result, jnp.float64)

    @jax.custom_jvp
    def density(at):
        return call(values, at)

    @density.defjvp
    def _(primals, tangents):
        (at,), (step_of_at,) = primals, tangents
        return density(at), call(slopes, at) * step_of_at

    return density


def _on_words(function: Callable, words: Any) -> np.ndarray:
    """A function of float64 on the two words of 32 bits of each number."""
    numbers = np.ascontiguousarray(words).view(np.float64)[..., 0]
    with np.errstate(all="ignore"):
        return np.ascontiguousarray(function(numbers)[..., None]).view(np.uint32)


def _words(prior: Any) -> str:
    """What it is, in a few words: of SciPy the family with its numbers."""
    family = getattr(getattr(prior, "dist", None), "name", None)
    if family is None:
        return getattr(prior, "__name__", type(prior).__name__).replace("<lambda>", "a function")
    numbers = [_digits(value) for value in getattr(prior, "args", ())]
    numbers += [f"{name}={_digits(value)}" for name, value in getattr(prior, "kwds", {}).items()]
    return f"{family}({', '.join(numbers)})"


def _digits(value: Any) -> str:
    return f"{float(value):.6g}" if is_real(value) and np.ndim(value) == 0 else shown(value)


def _middle(prior: Any) -> float | None:
    """The median of a distribution that says it."""
    median: Any = getattr(prior, "median", None)
    try:
        middle: Any = median() if callable(median) else None
        return None if middle is None else float(middle)
    except (TypeError, ValueError):
        return None
