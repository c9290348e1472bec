"""Numbers of 34 bits or more as sums of two float32: where float64 is not to be had.

Every product is taken of halves whose product is exact, so that a compiler which contracts a product and a sum into one
operation changes nothing (Dekker 1971, Numer. Math. 18, 224). A compiler that folds constants of a sum does: give it
none.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.numerics.quantities import is_concrete

_UPPER_HALF = np.uint32(0xFFFFF000)  # sign, exponent, and 12 bits of the fraction with its leading one


class Double(NamedTuple):
    """The sum of two float32 numbers or arrays, the second at most half a unit in the last place of the first."""

    high: Float[Array, "..."]
    low: Float[Array, "..."]

    def __add__(self, addend: "Double") -> "Double":  # pyright: ignore[reportIncompatibleMethodOverride]  # no tuples here
        total = self.high + addend.high
        carried = total - self.high
        rounding = (self.high - (total - carried)) + (addend.high - carried)
        return _settle(total, rounding + (self.low + addend.low))

    def __neg__(self) -> "Double":
        return Double(-self.high, -self.low)

    def __sub__(self, subtrahend: "Double") -> "Double":
        return self + (-subtrahend)

    def __mul__(self, factor: "Double") -> "Double":  # pyright: ignore[reportIncompatibleMethodOverride]  # no tuples here
        (a, rest_a), (b, rest_b) = _halves(self.high), _halves(factor.high)
        small = a * rest_b + rest_a * b + (rest_a * rest_b + (self.high * factor.low + self.low * factor.high))
        return _settle(a * b, small)

    def __truediv__(self, divisor: "Double") -> "Double":
        first = self.high / divisor.high
        remainder = self - divisor * exactly(first)
        return _settle(first, (remainder.high + remainder.low) / divisor.high)

    def turn(self) -> Float[Array, "..."]:
        """What is left of it when its whole number nearest to it is taken away, in float32."""
        return (self.high - jnp.round(self.high)) + self.low

    def at(self, *index) -> "Double":
        """Both parts under the same index."""
        return Double(self.high[index], self.low[index])


def double(value) -> Double:
    """A number in two parts: a concrete one with all the bits of its float64, a traced one with those it has."""
    if not is_concrete(value):
        return exactly(jnp.asarray(value, jnp.float32))
    exact = np.asarray(value, np.float64)
    high = exact.astype(np.float32)
    return Double(jnp.asarray(high), jnp.asarray((exact - high).astype(np.float32)))


def exactly(value: Float[Array, "..."]) -> Double:
    """A float32 number as it stands."""
    return Double(value, jnp.zeros_like(value))


def _settle(large: Array, small: Array) -> Double:
    total = large + small
    return Double(total, small - (total - large))


def _halves(value: Array) -> tuple[Array, Array]:
    bits = jax.lax.bitcast_convert_type(value, jnp.uint32)
    upper = jax.lax.bitcast_convert_type(bits & _UPPER_HALF, jnp.float32)
    return upper, value - upper
