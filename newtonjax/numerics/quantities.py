"""What a number may be: a Python float, a NumPy or JAX array, or a traced value."""

import os
import sys
from collections.abc import Mapping, Set
from copy import copy
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Complex, Float, Int

from newtonjax.numerics import jets
from newtonjax.numerics.jet import Jet
from newtonjax.numerics.wording import shown

Scalar = float | int | np.floating | Float[Array | np.ndarray, ""] | Int[Array | np.ndarray, ""] | Float[Any, ""]
Vector2 = tuple[Scalar, Scalar] | Float[Any, "2"]
Vector3 = tuple[Scalar, Scalar, Scalar] | Float[Any, "3"]


_LARGEST = sys.float_info.max


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
    # A batch of scenes has arrays where one scene has numbers: those pass through, as what is no number does until the
    # checks of its owner name it.
    return float(value) if is_real(value) and np.ndim(value) == 0 else value


def is_real(value) -> bool:
    """Whether it is a real number, an array of such, or traced; texts, complex numbers, lists and None are none."""
    if isinstance(value, Tracer | Jet):
        return True
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        return False
    kind = getattr(value, "dtype", None)
    if kind is not None:
        # NumPy counts intervals of time among the integers.
        is_time = getattr(kind, "kind", "") == "m"
        families = (np.bool_, np.integer, np.floating)
        return not is_time and any(bool(jnp.issubdtype(kind, family)) for family in families)
    return isinstance(value, float) or (isinstance(value, int) and abs(value) <= _LARGEST)


def _is_traced(value) -> bool:
    """Whether a number, or one within lists, is traced or carries tangents; whatever else was given is not."""
    if isinstance(value, tuple | list):
        return any(map(_is_traced, value))
    return isinstance(value, Tracer | Jet)


def as_vector(values) -> Any:
    """A leaf for a few numbers: NumPy float64 when concrete, a JAX array when traced."""
    if isinstance(values, Jet):
        return values
    if isinstance(values, jax.Array):
        is_known = is_concrete(values) and is_real(values)  # a complex one is left to the checks of its owner
        return np.asarray(values, dtype=np.float64) if is_known else values
    if not _is_traced(values):
        return np.asarray(values, dtype=np.float64) if _numeric(values) else values
    return jnp.stack([jnp.asarray(value, dtype=float) for value in values])


def _numeric(values) -> bool:
    return _real_array(values) is not None


def _real_array(values) -> np.ndarray | None:
    """Concrete numbers in float64; None for what holds anything else."""
    if isinstance(values, tuple | list):
        parts = [part for value in values if (part := _real_array(value)) is not None]
        if len(parts) < len(values) or len({part.shape for part in parts}) > 1:
            return None
        return np.array(parts, dtype=np.float64)
    return np.asarray(values, dtype=np.float64) if is_real(values) else None


def as_complex(value: Float[Any, "..."]) -> Complex[Any, "..."]:
    """The value with an imaginary part of 0, in the precision it has; NumPy stays NumPy."""
    if isinstance(value, Jet):
        return value.astype(complex)
    if isinstance(value, np.ndarray | np.floating):
        return np.asarray(value + 0j)
    return jax.lax.complex(value, jnp.zeros_like(value))


def unchecked(module: Any, **numbers) -> Any:
    """A copy of a module with other fields, for those that its checks need not see: these take longer than a ray.

    Values are taken as they are: what the module's converters would make of them.
    """
    fresh = copy(module)
    for name, value in numbers.items():
        object.__setattr__(fresh, name, value)
    return fresh


def require(name: str, value, allowed: str, test) -> None:
    """Raise ValueError when a concrete value fails its test, or is no real number; a traced one passes."""
    if _is_traced(value):
        return
    concrete = _real_array(value)
    if concrete is None or not np.all(test(concrete)):
        raise ValueError(f"{name} is {shown(value)}; allowed: {allowed}")


def require_number(name: str, value, allowed: str, test) -> None:
    """`require` of one number, or of an array where scenes are batched: a list of numbers is neither."""
    if not is_real(value):
        raise ValueError(f"{name} is {shown(value)}; allowed: {allowed}")
    require(name, value, allowed, test)


def require_one(name: str, value, allowed: str, test) -> None:
    """`require` of one number: an array of several is refused, traced ones too; `jax.vmap` makes several of one."""
    if is_real(value) and np.ndim(value):
        raise ValueError(f"{name} is {shown(value)}; allowed: {allowed}, one number; jax.vmap over several")
    require_number(name, value, allowed, test)


def require_size(name: str, value, size: int, allowed: str) -> None:
    """Raise ValueError where a vector, or each one of a batch, has another number of components; traced ones too."""
    if np.shape(value)[-1:] != (size,):
        raise ValueError(f"{name} is {shown(value)}; allowed: {allowed}")


def require_pair(name: str, value) -> None:
    """Raise ValueError for what is no pair of finite angles; of traced ones only the number is known."""
    if isinstance(value, tuple | list):
        is_pair = len(value) == 2 and all(np.ndim(angle) == 0 for angle in value)
    else:
        is_pair = getattr(value, "shape", ()) == (2,)
    if not is_pair:
        raise ValueError(f"{name} is {shown(value)}; allowed: two angles in radians, about x and about y")
    require(name, value, "two finite angles in radians, about x and about y", finite)


def finite(value) -> bool:
    return bool(np.all(np.isfinite(value)))


def positive(value) -> bool:
    return bool(np.all(np.isfinite(value) & (value > 0)))


def require_tolerance(tolerance) -> None:
    """Raise ValueError for what is no positive number."""
    if not (isinstance(tolerance, int | float | np.number) and is_real(tolerance) and 0 < float(tolerance) < np.inf):
        raise ValueError(f"tolerance is {shown(tolerance)}; allowed: a positive number, such as 1e-3")


def require_whole(name: str, value, low: int = 1, high: int | None = None) -> None:
    """Raise ValueError for what is no whole number between two; None passes."""
    is_integer = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if value is not None and not (is_integer and low <= value and (high is None or value <= high)):
        allowed = f"{low} or more" if high is None else f"{low} to {high}"
        raise ValueError(f"{name} is {shown(value)}; allowed: {allowed}")


def require_choice(name: str, value, choices: tuple[str, ...]) -> None:
    """Raise ValueError for what is none of some words."""
    if not (isinstance(value, str) and value in choices):
        raise ValueError(f"{name} is {shown(value)}; allowed: {' or '.join(map(repr, choices))}")


def require_mapping(name: str, value) -> None:
    """Raise ValueError for what is no mapping from names; None passes."""
    if value is not None and not (isinstance(value, Mapping) and all(isinstance(key, str) for key in value)):
        raise ValueError(f"{name} is {shown(value)}; allowed: a mapping from names")


def path_of(path) -> Path:
    """The path of a file. Raises ValueError for what is none."""
    if not isinstance(path, str | os.PathLike) or "\0" in str(path):
        raise ValueError(f"path is {shown(path)}; allowed: the path of a file")
    return Path(path)


def names_in(name: str, value) -> tuple[str, ...]:
    """One name or several as a tuple; None is none. Raises ValueError for what holds no names."""
    names = () if value is None else (value,) if isinstance(value, str) else value
    if not (isinstance(names, tuple | list | Set) and all(isinstance(text, str) for text in names)):
        raise ValueError(f"{name} is {shown(value)}; allowed: a name, or a tuple of names")
    return tuple(names)
