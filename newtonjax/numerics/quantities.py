"""What a number may be: a Python float, a NumPy or JAX array, or a traced value."""

import numbers
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Complex, Float, Int

from newtonjax.numerics import jets
from newtonjax.numerics.jet import Jet

Scalar = float | int | np.floating | Float[Array | np.ndarray, ""] | Int[Array | np.ndarray, ""] | Float[Any, ""]
Vector2 = tuple[Scalar, Scalar] | Float[Any, "2"]
Vector3 = tuple[Scalar, Scalar, Scalar] | Float[Any, "3"]


def is_concrete(*trees) -> bool:
    """True when no leaf of the trees is being traced by a JAX transformation, or carries tangents."""
    return not any(isinstance(leaf, Tracer | Jet) for leaf in jax.tree.leaves(trees))


def namespace(*trees) -> Any:
    """NumPy for concrete values, which keeps float64 whatever JAX's setting; jax.numpy for traced ones; or `jets`."""
    leaves = jax.tree.leaves(trees)
    if any(isinstance(leaf, Jet) for leaf in leaves):
        return jets
    return jnp if any(isinstance(leaf, Tracer) for leaf in leaves) else np


def functions(*numbers) -> Any:
    """What a kernel takes its functions from: `jets` for jets, else jax.numpy."""
    return jets if any(isinstance(number, Jet) for number in numbers) else jnp


def module_of(array) -> Any:
    """NumPy for its own arrays, jax.numpy for JAX's: what is made of an array stays where it was."""
    return np if isinstance(array, np.ndarray) else jnp


def as_scalar(value):
    """A leaf for one number: a concrete one becomes a Python float, which no x64 setting can round."""
    return value if isinstance(value, jax.Array | Jet) and not is_concrete(value) else _unwrap(value)


def _unwrap(value):
    if isinstance(value, str):
        raise ValueError(f"{value!r} is no number; allowed: numbers in SI units")
    if not is_real(value):
        raise ValueError(f"{shown(value)} is no number; allowed: numbers in SI units")
    # A batch of scenes has arrays where one scene has numbers: those pass through.
    return float(value) if np.ndim(value) == 0 else value


def is_real(value) -> bool:
    """Whether it is a real number, an array of such, or traced; texts, complex numbers, lists and None are none."""
    if isinstance(value, Tracer | Jet):
        return True
    kind = getattr(value, "dtype", None)
    if kind is None:
        return isinstance(value, numbers.Real)
    return any(bool(jnp.issubdtype(kind, family)) for family in (np.bool_, np.integer, np.floating))


def as_vector(values) -> Any:
    """A leaf for a few numbers: NumPy float64 when concrete, a JAX array when traced."""
    if isinstance(values, Jet):
        return values
    if isinstance(values, jax.Array):
        return values if not is_concrete(values) else np.asarray(values, dtype=np.float64)
    if is_concrete(values):
        return np.asarray(values, dtype=np.float64) if _numeric(values) else values
    return jnp.stack([jnp.asarray(value, dtype=float) for value in values])


def _numeric(values) -> bool:
    # Transformations rebuild modules with placeholder leaves (None, object()): those pass through.
    try:
        np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        return False
    return True


def as_complex(value: Float[Any, "..."]) -> Complex[Any, "..."]:
    """The value with an imaginary part of 0, in the precision it has; NumPy stays NumPy."""
    if isinstance(value, Jet):
        return value.astype(complex)
    if isinstance(value, np.ndarray | np.floating):
        return np.asarray(value + 0j)
    return jax.lax.complex(value, jnp.zeros_like(value))


def require(name: str, value, allowed: str, test) -> None:
    """Raise ValueError when a concrete value fails its test; a traced one passes."""
    if isinstance(value, str | bytes | complex) or jnp.issubdtype(getattr(value, "dtype", float), np.complexfloating):
        raise ValueError(f"{name} is {value!r}; allowed: {allowed}")
    if not is_concrete(value) or not _numeric(value):
        return  # traced, or a placeholder with which a transformation rebuilds a module
    concrete = np.asarray(value, dtype=np.float64)
    if not np.all(test(concrete)):
        raise ValueError(f"{name} is {value}; allowed: {allowed}")


def require_pair(name: str, value) -> None:
    """Raise ValueError for what is no pair of finite angles; traced ones pass."""
    pair = len(value) == 2 if isinstance(value, tuple | list) else getattr(value, "shape", ())[:1] == (2,)
    if not pair:
        raise ValueError(f"{name} is {value}; allowed: two angles in radians, about x and about y")
    require(name, value, "two finite angles in radians, about x and about y", finite)


def finite(value) -> bool:
    return bool(np.all(np.isfinite(value)))


def positive(value) -> bool:
    return bool(np.all(np.isfinite(value) & (value > 0)))


def require_tolerance(tolerance) -> None:
    """Raise ValueError for what is no positive number."""
    if not (isinstance(tolerance, int | float | np.number) and 0 < float(tolerance) < np.inf):
        raise ValueError(f"tolerance is {shown(tolerance)}; allowed: a positive number, such as 1e-3")


def require_whole(name: str, value) -> None:
    """Raise ValueError for what is no whole number from 1 on; None passes."""
    if value is not None and not (isinstance(value, int | np.integer) and value >= 1):
        raise ValueError(f"{name} is {shown(value)}; allowed: 1 or more")


def shown(value) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
