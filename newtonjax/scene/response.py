"""What a camera's channels take of each wavelength, and colours as a screen shows them."""

from typing import Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from newtonjax.numerics import as_vector, is_real, namespace, require, require_whole, shown
from newtonjax.scene.illuminants import cie_table
from newtonjax.scene.limits import WAVELENGTH


def _rows(curves) -> Any:
    return np.asarray(curves, dtype=float) if isinstance(curves, list | tuple) else curves


class Response(eqx.Module):
    """Spectral responses of a camera's channels, sampled and linear in between, 0 beyond the ends.

    - `wavelengths`: of the samples, ascending, in vacuum [m], [samples].
    - `curves`: response to power in each channel, [channels, samples].
    - `white`: the channel over which all are, as seen by the bare light; None for each one over itself, which is a
      camera whose white balance is the lamp's. Static.
    """

    wavelengths: Float[Any, " samples"] = eqx.field(converter=as_vector)
    curves: Float[Any, "channels samples"] = eqx.field(converter=_rows)
    white: int | None = eqx.field(static=True, default=None)

    def __check_init__(self):
        require("wavelengths", self.wavelengths, f"ascending, {WAVELENGTH.words}", _ascending)
        require("curves", self.curves, "finite numbers, a row for each channel", np.isfinite)
        if np.ndim(self.curves) != 2 or np.shape(self.curves)[1:] != np.shape(self.wavelengths):
            raise ValueError(
                f"curves has shape {np.shape(self.curves)}; allowed: (channels, {np.size(self.wavelengths)}), "
                "a response at every wavelength"
            )
        require_whole("white", self.white, 0, len(self.curves) - 1)

    def powers(self, wavelengths: Float[Any, " lines"], shares: Float[Any, " lines"]) -> Float[Any, "channels lines"]:
        """What each channel takes of each line, over what the channel `white` (or it itself) takes of all."""
        xp = namespace(self, wavelengths, shares)
        curves = xp.stack([xp.interp(wavelengths, self.wavelengths, row, left=0.0, right=0.0) for row in self.curves])
        taken_up = curves * shares
        total = taken_up.sum(axis=1, keepdims=True)
        total = total if self.white is None else total[self.white : self.white + 1]
        return taken_up / xp.where(total > 0, total, 1.0)


def _ascending(at: np.ndarray) -> bool:
    return bool(np.all(WAVELENGTH.holds(at)) and np.all(np.diff(at) > 0) and np.size(at) > 1)


def cie_1931() -> Response:
    """X, Y, Z of the CIE's standard observer of 1931 (2 degrees), Y of the bare light being 1."""
    table = cie_table()
    return Response(table["wavelength"], np.stack([table[name] for name in "xyz"]), white=1)


# From X, Y, Z to linear red, green and blue of primaries ITU-R BT.709 and the white D65 (IEC 61966-2-1:1999).
_TO_RGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
# Bradford's matrix of cone responses (ICC.1:2022, annex E).
_CONES = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
_D65 = np.array([0.95047, 1.0, 1.08883])


def to_srgb(
    xyz: Float[Array | np.ndarray, "*pixels 3"], white: Float[Array | np.ndarray, "3"] | None = None
) -> Float[Any, "*pixels 3"]:
    """Red, green and blue from 0 to 1 as files hold them, of X, Y, Z in which a white of Y = 1 is (1, 1, 1).

    IEC 61966-2-1; what a screen cannot show is clipped. `white`: X, Y, Z that is shown as white, by Bradford's
    adaptation (ICC.1:2022, annex E); None for D65, the screen's.

    Raises ValueError for arrays whose last axis is not three numbers.
    """
    for name, value in (("xyz", xyz), ("white", white)):
        if value is not None and not (is_real(value) and np.shape(value)[-1:] == (3,)):
            raise ValueError(f"{name} is {shown(value)}; allowed: an array whose last axis is X, Y, Z")
    xp = namespace(xyz, white)
    matrix = _TO_RGB
    if white is not None:
        gains = (_CONES @ _D65) / (_CONES @ white)
        matrix = _TO_RGB @ np.linalg.inv(_CONES) @ (gains[:, None] * _CONES)
    linear = xp.clip(xyz @ matrix.T, 0.0, 1.0)
    small = linear <= 0.0031308
    return xp.where(small, 12.92 * linear, 1.055 * xp.where(small, 1.0, linear) ** (1 / 2.4) - 0.055)
