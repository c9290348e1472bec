"""What parts add to the phase as polynomials about the rings' centre, and the derivatives of that."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from fitting.model.parts import POLYNOMIALS
from fitting.model.warp import Frame
from fitting.parameters import Numbers

_MONOMIALS = sorted({powers for terms in POLYNOMIALS.values() for powers in terms})
_LOWER = sorted({(i - 1, j) for i, j in _MONOMIALS if i} | {(i, j - 1) for i, j in _MONOMIALS if j})
_HIGHEST = max(max(powers) for powers in _MONOMIALS)
# Of the numbers' polynomials in the monomials, and of the monomials' derivatives in the lower ones.
_TABLE = np.array([[terms.get(powers, 0.0) for powers in _MONOMIALS] for terms in POLYNOMIALS.values()])
_BY_X = np.array([[float(i) * ((i - 1, j) == lower) for lower in _LOWER] for i, j in _MONOMIALS])
_BY_Y = np.array([[float(j) * ((i, j - 1) == lower) for lower in _LOWER] for i, j in _MONOMIALS])


def form_turns(frame: Frame, x, y, numbers: Numbers) -> Any:
    """What the parts add to the phase [turns], inside a transformation too."""
    values = jnp.stack([jnp.asarray(getattr(numbers, name), float) for name in POLYNOMIALS]) @ _TABLE
    along = _powers(frame, x, y, numbers)
    return sum(value * along[0][i] * along[1][j] for value, (i, j) in zip(values, _MONOMIALS, strict=True))


def form_slopes(frame: Frame, x, y, numbers: Numbers) -> tuple[Any, dict[str, np.ndarray]]:
    """What the parts add to the phase [turns], and its derivatives by number, by NumPy."""
    along_x, along_y = _powers(frame, x, y, numbers)
    monomials = _products(along_x, along_y, _MONOMIALS)
    slopes = dict(zip(POLYNOMIALS, _combined(_TABLE, monomials), strict=True))
    values = np.array([getattr(numbers, name) for name in POLYNOMIALS])
    if not values.any():
        return 0.0, slopes
    combined = values @ _TABLE
    lower = _products(along_x, along_y, _LOWER)
    for name, growth in (("centre_x", _BY_X), ("centre_y", _BY_Y)):
        slopes[name] = _combined(combined @ growth, lower) / -frame.reach
    return _combined(combined, monomials), slopes


def _products(along_x: list, along_y: list, powers: list[tuple[int, int]]) -> np.ndarray:
    products = np.empty((len(powers), *np.broadcast_shapes(np.shape(along_x[1]), np.shape(along_y[1]))))
    for at, (i, j) in enumerate(powers):
        products[at] = along_x[i] * along_y[j]
    return products


def _combined(table: np.ndarray, products: np.ndarray) -> np.ndarray:
    """Sums of products by a table's last axis."""
    return (table @ products.reshape(len(products), -1)).reshape(*table.shape[:-1], *products.shape[1:])


def _powers(frame: Frame, x, y, numbers: Numbers) -> tuple[list, list]:
    """Powers of pixel positions [px] from the rings' centre, over the reach of the field from there."""
    powers = []
    for at, middle, centre in zip((x, y), frame.middle, (numbers.centre_x, numbers.centre_y), strict=True):
        offset = ((at - middle) / frame.unit - centre) / frame.reach
        powers.append([1.0, offset])
        for _ in range(_HIGHEST - 1):
            powers[-1].append(powers[-1][-1] * offset)
    return tuple(powers)
