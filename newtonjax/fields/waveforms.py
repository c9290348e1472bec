"""What many wavelengths make of a path difference, tabulated: a pixel costs a look-up, however many lines there are.

Where amplitudes and refractive indices do not depend on the wavelength, the fringes of two beams are
Re[envelope Γ(turns)], Γ the Fourier transform of the spectrum, with the path difference in turns of the mean
wavenumber. Γ is known on equidistant nodes and cubic in between (Hermite's interpolation).
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.numerics import cos_turns, namespace, sin_turns
from newtonjax.scene import Lines

# Cells of a table; a table of Γ itself has no more than `_DIRECT`, beyond it is one of Γ over the carrier.
_FEWEST, _DIRECT, _MOST = 2**8, 2**12, 2**17
# Nodes beyond either end, from which slopes are taken there.
_MARGIN = 3
_SLOPES = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60


class Waveform(NamedTuple):
    """Γ of every channel between equidistant nodes, NumPy for known numbers.

    - `cubics`: coefficients by powers of the place in a cell, of the real part of Γ in each channel and then of its
      imaginary part, [cells, 4, 2 channels]; without the imaginary parts where envelopes are real.
    - `start`: of the first cell [turns]; `density`: cells per turn.
    """

    cubics: Float[Any, "cells 4 parts"]
    start: Float[Any, ""]
    density: Float[Any, ""]

    def at(self, turns: Float[Array, "..."]) -> Float[Array, "... parts"]:
        """The parts of Γ at path differences [turns]; beyond the ends the last cubics go on."""
        return _look_up(jnp.asarray(self.cubics), (turns - self.start) * self.density)


@jax.custom_jvp
def _look_up(cubics, place):
    c, u = _cell(cubics, place)
    return c[..., 0, :] + u * (c[..., 1, :] + u * (c[..., 2, :] + u * c[..., 3, :]))


def _slope(cubics, place):
    c, u = _cell(cubics, place)
    return c[..., 1, :] + u * (2 * c[..., 2, :] + 3 * u * c[..., 3, :])


def _cell(cubics, place):
    """The coefficients of each place's cell, and where it lies in that."""
    cell = jnp.clip(jnp.floor(jax.lax.stop_gradient(place)), 0, len(cubics) - 1)
    return cubics.at[cell.astype(jnp.int32)].get(mode="promise_in_bounds"), (place - cell)[..., None]


def _look_up_jvp(primals, tangents):
    (cubics, place), (change, step) = primals, tangents
    parts = []
    if type(step) is not jax.custom_derivatives.SymbolicZero:
        parts.append(_slope(cubics, place) * step[..., None])
    if type(change) is not jax.custom_derivatives.SymbolicZero:
        parts.append(_look_up(change, place))
    value = _look_up(cubics, place)
    return value, sum(parts[1:], parts[0]) if parts else jnp.zeros_like(value)


_look_up.defjvp(_look_up_jvp, symbolic_zeros=True)


class Table(NamedTuple):
    """How a spectrum is tabulated: over how many cells, over the carrier or not, and by how much that errs."""

    cells: int
    over_carrier: bool
    error: float


def table_for(lines: Lines, reach: float, tolerance: float) -> Table:
    """The table of a spectrum over a range of path differences [turns] that keeps a tolerance.

    A cubic between values and slopes errs by (h k)⁴ / 384 of the amplitude, h the step and k the largest frequency.

    Raises ValueError where it would need more cells than are allowed.
    """
    frequency = 2 * np.pi * float(np.max(lines.ratios)) + _bandwidth(lines)
    cells = _cells(reach * frequency, tolerance)
    over_carrier = cells > _DIRECT
    if over_carrier:
        frequency = 2 * np.pi * float(np.abs(np.asarray(lines.ratios) - 1).max()) + _bandwidth(lines)
        cells = _cells(reach * frequency, tolerance)
    if cells > _MOST:
        raise ValueError(
            f"path differences over {reach:.3g} wavelengths of so wide a spectrum need a table of {cells} cells; "
            f"allowed: {_MOST}; use Traced()"
        )
    return Table(cells, over_carrier, (reach * frequency / cells) ** 4 / 384)


def _cells(reach: float, tolerance: float) -> int:
    needed = max(reach / (384 * tolerance) ** 0.25, 1.0)
    return max(_FEWEST, 1 << int(np.ceil(np.log2(needed))))


def _bandwidth(lines: Lines) -> float:
    """Of the fading of lines that have widths, as a frequency [radians per turn]."""
    total = 0.0
    for width, factor in ((lines.gaussian, 3.5), (lines.lorentzian, np.pi), (lines.triangle, 2 * np.pi)):
        total += 0.0 if width is None else factor * float(np.max(width))
    return total


def waveform(
    lines: Lines, powers: Float[Any, "channels lines"], low, high, table: Table, *, only_real: bool = False
) -> Waveform:
    """Γ of channels that take these powers of the lines, tabulated between two path differences [turns].

    - `only_real`: without Γ's imaginary part, which real envelopes do without unless it is over the carrier.
    """
    xp = namespace(lines, powers, low, high)
    density = table.cells / xp.maximum(high - low, 1e-3)
    turns = low + xp.arange(-_MARGIN, table.cells + 1 + _MARGIN, dtype=float) / density
    phase = 2 * np.pi * (lines.ratios - (1.0 if table.over_carrier else 0.0))[:, None] * turns
    faded = lines.fading(turns)
    parts = powers @ (faded * xp.cos(phase))
    if not only_real:
        parts = xp.concatenate([parts, powers @ (faded * xp.sin(phase))])
    nodes = len(turns) - 2 * _MARGIN
    windows = xp.stack([parts[:, k : k + nodes] for k in range(len(_SLOPES))], axis=-1)
    slopes = windows @ _SLOPES
    values = parts[:, _MARGIN:-_MARGIN]
    rise, before, after = values[:, 1:] - values[:, :-1], slopes[:, :-1], slopes[:, 1:]
    cubics = [values[:, :-1], before, 3 * rise - 2 * before - after, before + after - 2 * rise]
    return Waveform(xp.stack(cubics).transpose(2, 0, 1), low, density)


def fringes_by_table(real, imaginary, turns, channels: int, wave: Waveform, over_carrier: bool):
    """Re[envelope Γ(turns)] at pixels, [..., channels].

    - `real`, `imaginary`: parts of the envelope; None for an imaginary part of 0.
    - `wave`: with Γ's imaginary parts, unless the envelope is real and Γ not over the carrier.
    """
    parts = wave.at(turns)
    if over_carrier:
        real, imaginary = _turned(real, imaginary, turns)
    if imaginary is None:
        return _wide(real) * parts[..., :channels]
    return _wide(real) * parts[..., :channels] - _wide(imaginary) * parts[..., channels:]


def _turned(real, imaginary, turns):
    """The envelope times e^{2πi turns}."""
    cosine, sine = cos_turns(turns), sin_turns(turns)
    if imaginary is None:
        return real * cosine, real * sine
    return real * cosine - imaginary * sine, real * sine + imaginary * cosine


def _wide(factor):
    return factor[..., None] if jnp.ndim(factor) else factor
