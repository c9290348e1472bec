"""Functions of jets, and of NumPy's numbers: what the tracer's formulas take in place of `jax.numpy`."""

from typing import Any, no_type_check

import numpy as np

from newtonjax.numerics.jet import Jet, aligned, value_of


def variable(value, tangents: np.ndarray, level: int, levels: int) -> Jet:
    """A jet with tangents [tangents, ...] at one level."""
    value = np.asarray(value)
    parts = np.concatenate([np.broadcast_to(value, tangents.shape[1:])[None], tangents])
    shape = [1] * levels
    shape[level] = len(parts)
    return Jet(parts.reshape(*shape, *parts.shape[1:]), levels)


@no_type_check
def sqrt(number) -> Any:
    if not isinstance(number, Jet):
        return np.sqrt(number)
    root = np.sqrt(number.value)
    return number.through([root, 0.5 / root, -0.125 / root**3, 0.0625 / root**5])


def sin(number) -> Any:
    s, c = np.sin(value_of(number)), np.cos(value_of(number))
    return number.through([s, c, -s / 2, -c / 6]) if isinstance(number, Jet) else s


def cos(number) -> Any:
    s, c = np.sin(value_of(number)), np.cos(value_of(number))
    return number.through([c, -s, -c / 2, s / 6]) if isinstance(number, Jet) else c


def log(number) -> Any:
    if not isinstance(number, Jet):
        return np.log(number)
    slope = 1 / number.value
    return number.through([np.log(number.value), slope, -(slope**2) / 2, slope**3 / 3])


def arctan(number: Jet) -> Jet:
    x = number.value
    f = 1 / (1 + x * x)
    return number.through([np.arctan(x), f, -x * f**2, (3 * x * x - 1) * f**3 / 3])


@no_type_check
def asarray(number, dtype=None) -> Any:
    """`numpy.asarray`; a jet as it is."""
    return number if isinstance(number, Jet) else np.asarray(number, dtype)


@no_type_check
def zeros_like(number):
    return np.zeros_like(value_of(number))


@no_type_check
def where(condition, if_true, if_false) -> Any:
    """`numpy.where`; of a single truth value the number itself."""
    if np.ndim(condition) == 0:
        return if_true if condition else if_false
    if not isinstance(if_true, Jet) and not isinstance(if_false, Jet):
        return np.where(condition, if_true, if_false)
    levels = (if_true if isinstance(if_true, Jet) else if_false).levels
    a, b = (_full(part, _sizes(levels, if_true, if_false)) for part in aligned(if_true, if_false))
    return Jet(np.where(condition, a, b), levels)


@no_type_check
def stack(numbers, axis: int = 0) -> Any:
    """`numpy.stack` of jets and numbers."""
    if not any(isinstance(number, Jet) for number in numbers):
        return np.stack(numbers, axis)
    levels = next(number.levels for number in numbers if isinstance(number, Jet))
    sizes = _sizes(levels, *numbers)
    parts = [_full(part, sizes) for part in aligned(*numbers)]
    shape = np.broadcast_shapes(*(part.shape for part in parts))
    return Jet(np.stack([np.broadcast_to(part, shape) for part in parts], axis + levels if axis >= 0 else axis), levels)


def matmul(first, second) -> Any:
    """`numpy.matmul`, of jets of one level."""
    if not isinstance(first, Jet) and not isinstance(second, Jet):
        return first @ second
    a, b = (number.parts if isinstance(number, Jet) else np.asarray(number)[None] for number in (first, second))
    total = a @ b[:1] if len(a) > 1 else a @ b
    if len(a) > 1 and len(b) > 1:
        total[1:] += a[:1] @ b[1:]
    return Jet(total, 1)


def inverse(matrix) -> Any:
    """`numpy.linalg.inv`, of a jet of one level: d(A⁻¹) = -A⁻¹ dA A⁻¹. NaN where there is none."""
    try:
        value = np.linalg.inv(value_of(matrix))
    except np.linalg.LinAlgError:
        value = np.full(matrix.shape, np.nan)
    if not isinstance(matrix, Jet):
        return value
    return Jet(np.concatenate([value[None], -value @ matrix.parts[1:] @ value]), 1)


@no_type_check
def peak(number, axes: int) -> Any:
    """The largest over the last axes; where there are several, the first."""
    value = value_of(number)
    lead = value.shape[: value.ndim - axes]
    at = value.reshape(*lead, -1).argmax(axis=-1)
    flat = number.reshape(*lead, -1)
    return stack([flat[k, at[k]] for k in range(len(at))]) if lead else flat[at]


@no_type_check
def _sizes(levels: int, *numbers) -> tuple[int, ...]:
    parts = [number.parts.shape for number in numbers if isinstance(number, Jet)]
    return tuple(max(shape[k] for shape in parts) for k in range(levels))


@no_type_check
def full(number: Jet, sizes: tuple[int, ...]) -> Jet:
    """The jet with all entries at its levels, zeros where it has no tangents."""
    return Jet(_full(number.parts, sizes), number.levels)


@no_type_check
def _full(part: np.ndarray, sizes: tuple[int, ...]) -> np.ndarray:
    """With zeros for the tangents that a part does not have."""
    short = part.shape[: len(sizes)]
    if short == sizes:
        return part
    total = np.zeros(sizes + part.shape[len(sizes) :], part.dtype)
    total[tuple(map(slice, short))] = part
    return total
