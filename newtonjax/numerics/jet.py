"""Numbers that carry their derivatives, in NumPy: nothing is compiled, whatever the names and shapes.

A jet is a value with tangents at one or more levels. Level by level the tangents multiply to nothing among themselves
(dual numbers, Clifford 1873; forward differentiation, Griewank and Walther 2008, chapters 3 and 13), so that one level
gives first derivatives and two give the mixed second ones. The formulas of the tracer take jets as they take numbers.
"""

from functools import cache
from itertools import product
from typing import Any, no_type_check

import numpy as np

_ALL = slice(None)
_VALUE, _TANGENTS = slice(0, 1), slice(1, None)


# Its operations are the inner loop of the studies: a checker of types and shapes, where one is hooked in, sees the
# functions that take jets, not each sum and product.
@no_type_check
class Jet:
    """An array with tangents: `parts` has one leading axis a level, its entry 0 the value, the others the tangents.

    A level of length 1 has no tangents there. `shape` and `dtype` are those of the array without them.
    """

    __slots__ = ("levels", "parts")
    __array_ufunc__ = None  # of an array and a jet the jet's own arithmetic is asked

    def __init__(self, parts: Any, levels: int):
        self.parts, self.levels = parts, levels

    @property
    def shape(self) -> tuple[int, ...]:
        return self.parts.shape[self.levels :]

    @property
    def ndim(self) -> int:
        return self.parts.ndim - self.levels

    @property
    def dtype(self) -> np.dtype:
        return self.parts.dtype

    @property
    def value(self) -> Any:
        return self.parts[(0,) * self.levels]

    @property
    def real(self) -> "Jet":
        return Jet(self.parts.real, self.levels)

    @property
    def imag(self) -> "Jet":
        return Jet(self.parts.imag, self.levels)

    def conj(self) -> "Jet":
        return Jet(self.parts.conj(), self.levels)

    def astype(self, dtype) -> "Jet":
        return Jet(self.parts.astype(dtype, copy=False), self.levels)

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self):
        return (self[k] for k in range(len(self)))

    def __getitem__(self, index) -> "Jet":
        index = index if isinstance(index, tuple) else (index,)
        return Jet(self.parts[(_ALL,) * self.levels + index], self.levels)

    def reshape(self, *shape: int) -> "Jet":
        return Jet(self.parts.reshape(*self.parts.shape[: self.levels], *shape), self.levels)

    def at_level(self, level: int, index: int | slice) -> "Jet":
        """The jet with only some of the entries of a level: 0 leaves its tangents out, k is the k-th tangent alone."""
        part = slice(index, index + 1) if isinstance(index, int) else index
        return Jet(self.parts[(_ALL,) * level + (part,)], self.levels)

    def sum(self, axis: int) -> "Jet":
        return Jet(self.parts.sum(axis=axis + self.levels if axis >= 0 else axis), self.levels)

    def _beside(self, operand) -> "list[np.ndarray] | tuple[np.ndarray, np.ndarray]":
        if isinstance(operand, Jet) and operand.parts.ndim == self.parts.ndim:
            return self.parts, operand.parts
        return aligned(self, operand)

    def __neg__(self) -> "Jet":
        return Jet(-self.parts, self.levels)

    def __abs__(self) -> "Jet":
        return self * np.sign(self.value)

    def __add__(self, addend) -> "Jet":
        a, b = self._beside(addend)
        if a.shape[: self.levels] == b.shape[: self.levels]:
            return Jet(a + b, self.levels)
        total = _room(a, b, self.levels)
        total[tuple(map(slice, a.shape[: self.levels]))] += a
        total[tuple(map(slice, b.shape[: self.levels]))] += b
        return Jet(total, self.levels)

    __radd__ = __add__

    def __sub__(self, subtrahend) -> "Jet":
        return self + (-subtrahend)

    def __rsub__(self, minuend) -> "Jet":
        return -self + minuend

    def __mul__(self, factor) -> "Jet":
        if isinstance(factor, float | int | complex):
            return Jet(self.parts * factor, self.levels)
        a, b = self._beside(factor)
        return Jet(_multiply(a, b, self.levels), self.levels)

    __rmul__ = __mul__

    def __matmul__(self, vector) -> "Jet":
        """Of two vectors."""
        return (self * vector).sum(0)

    __rmatmul__ = __matmul__

    def __truediv__(self, divisor) -> "Jet":
        if isinstance(divisor, Jet):
            return self * divisor.reciprocal()
        return self * (1 / np.asarray(divisor))

    def __rtruediv__(self, dividend) -> "Jet":
        return self.reciprocal() * dividend

    def __pow__(self, power: int) -> "Jet":
        if power != 2:
            raise ValueError(f"power is {power}; allowed: 2")
        return self * self

    def reciprocal(self) -> "Jet":
        inverse = 1 / self.value
        return self.through([inverse, -(inverse**2), inverse**3, -(inverse**4)])

    def through(self, taylor: list) -> "Jet":
        """A function of the jet, from its Taylor coefficients f, f', f''/2, ... at the value."""
        tangents = self.parts.copy()
        tangents[(0,) * self.levels] = 0
        total = tangents * taylor[1]
        total[(0,) * self.levels] += taylor[0]
        power = tangents
        for coefficient in taylor[2 : sum(n > 1 for n in tangents.shape[: self.levels]) + 1]:
            power = _multiply(power, tangents, self.levels)
            total += power * coefficient
        return Jet(total, self.levels)

    # Comparisons are of values.
    def __lt__(self, operand):
        return self.value < value_of(operand)

    def __le__(self, operand):
        return self.value <= value_of(operand)

    def __gt__(self, operand):
        return self.value > value_of(operand)

    def __ge__(self, operand):
        return self.value >= value_of(operand)

    def __eq__(self, operand):
        return self.value == value_of(operand)

    def __ne__(self, operand):
        return self.value != value_of(operand)

    __hash__ = None  # pyright: ignore[reportAssignmentType]


@no_type_check
def value_of(number) -> Any:
    """A number without its tangents."""
    return number.value if isinstance(number, Jet) else number


@no_type_check
def without_tangents(number) -> Any:
    """A jet of the same levels without tangents; what is none stays as it is."""
    return Jet(number.parts[(_VALUE,) * number.levels], number.levels) if isinstance(number, Jet) else number


@no_type_check
def _parts(number, levels: int) -> np.ndarray:
    if isinstance(number, Jet):
        return number.parts
    number = np.asarray(number)
    return number.reshape((1,) * levels + number.shape)


@no_type_check
def aligned(*numbers) -> list[np.ndarray]:
    """Parts of one rank: axes of length 1 stand between the levels and those of a smaller array."""
    levels = next(number.levels for number in numbers if isinstance(number, Jet))
    parts = [_parts(number, levels) for number in numbers]
    rank = max([part.ndim for part in parts])
    return [
        part
        if part.ndim == rank
        else part.reshape(part.shape[:levels] + (1,) * (rank - part.ndim) + part.shape[levels:])
        for part in parts
    ]


@no_type_check
def _room(a: np.ndarray, b: np.ndarray, levels: int) -> np.ndarray:
    sizes = tuple(map(max, a.shape[:levels], b.shape[:levels]))
    return np.zeros(sizes + np.broadcast_shapes(a.shape[levels:], b.shape[levels:]), np.result_type(a, b))


@no_type_check
def _multiply(a: np.ndarray, b: np.ndarray, levels: int) -> np.ndarray:
    """Level by level a tangent of the product is one factor's tangent times the other's value."""
    if a.size < b.size:
        a, b = b, a
    covers_all, steps = _plan(a.shape[:levels], b.shape[:levels])
    if covers_all:
        of_a, of_b, _ = steps[0]
        total = a[of_a] * b[of_b]
        steps = steps[1:]
    else:
        total = _room(a, b, levels)
    for of_a, of_b, at in steps:
        total[at] += a[of_a] * b[of_b]
    return total


@no_type_check
@cache
def _plan(first: tuple[int, ...], second: tuple[int, ...]) -> tuple[bool, list]:
    """Which entries are multiplied, and where the products go; and whether the first product has all entries."""
    steps = []
    for by_second in product(*[(False, True) if n > 1 else (False,) for n in second]):
        # In the levels of `by_second` the tangents are the second factor's, else the entries are the first one's.
        of_first = tuple(_VALUE if tangent else _ALL for tangent in by_second)
        of_second = tuple(_TANGENTS if tangent else _VALUE for tangent in by_second)
        at = tuple(_TANGENTS if tangent else slice(0, n) for tangent, n in zip(by_second, first, strict=True))
        steps.append((of_first, of_second, at))
    return all(m >= n for m, n in zip(first, second, strict=True)), steps
