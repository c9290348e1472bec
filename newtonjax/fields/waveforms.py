"""What many wavelengths make of a path difference, tabulated: a pixel costs a look-up, however many lines there are.

Where amplitudes and refractive indices do not depend on the wavelength, the fringes of two beams are
Re[envelope Γ(turns)], Γ the Fourier transform of the spectrum, with the path difference in turns of the mean
wavenumber. Γ is known on equidistant nodes and cubic in between (Hermite's interpolation).
"""

from collections.abc import Callable
from functools import cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial.chebyshev import chebder, chebvander

from newtonjax.fields.means_in_gap import GapMeans, faded
from newtonjax.numerics import (
    chebyshev,
    cos_turns,
    fenced,
    module_of,
    namespace,
    sin_turns,
)
from newtonjax.scene import Lines

# Γ is summed over the lines at Chebyshev nodes of panels of so many cells, and interpolated within a panel: to 3e-8 as
# long as a cell is no longer than `_LONGEST` radians of the largest frequency.
_PANEL, _NODES, _LONGEST = 64, 24, 0.3
# Parts of a cell between whose ends a change of a table is straight: that errs by (h k / 8)² / 8 of it.
_CUTS = 8
# Panels of a table, in classes of which programs are compiled: no more than `_DIRECT` for Γ itself, beyond for Γ over
# the carrier.
_CLASSES = tuple(size for k in range(1, 12) for size in (2**k, 3 * 2 ** (k - 1)))
_DIRECT = 64
# Of a line of full width 1 at half maximum the fading's largest frequency, by profile [radians per turn].
_BANDWIDTHS = (3.5, np.pi, 2 * np.pi)


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
        return _look_up(_cubic, jnp.asarray(self.cubics), (turns - self.start) * self.density)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _look_up(between, cubics, place):
    return between(cubics, place)


def _look_up_jvp(between, primals, tangents):
    (cubics, place), (change, step) = primals, tangents
    parts = []
    if type(step) is not jax.custom_derivatives.SymbolicZero:
        parts.append(_rise(cubics, place, step))
    if type(change) is not jax.custom_derivatives.SymbolicZero:
        parts.append(_look_up(_linear, change, place))
    value = _look_up(between, cubics, place)
    return value, sum(parts[1:], parts[0]) if parts else jnp.zeros_like(value)


_look_up.defjvp(_look_up_jvp, symbolic_zeros=True)


def _cubic(cubics, place):
    def of(cubics, place):
        cell, u = _cell(len(cubics), place)
        c, u = _row(cubics, cell), u[..., None]
        return c[..., 0, :] + u * (c[..., 1, :] + u * (c[..., 2, :] + u * c[..., 3, :]))

    # Fused with a sum over its parts it would take ten times as long.
    return fenced(cubics, of, cubics, place)


def _linear(cubics, place):
    """As `_cubic`, but straight between the ends of parts of each cell: what is added up in reverse is half as much."""
    powers = np.vander(np.linspace(0, 1, _CUTS + 1), 4, increasing=True)
    ends = jnp.einsum("nkc,pk->npc", cubics, powers, precision="highest")
    lines = jnp.stack([ends[:, :-1], jnp.diff(ends, axis=1)], axis=2)
    lines = lines.reshape(-1, 2, cubics.shape[-1])
    cell, u = _cell(len(lines), place * _CUTS)
    line = _row(lines, cell)
    return line[..., 0, :] + u[..., None] * line[..., 1, :]


def _rise(cubics, place, step):
    """The slope times a step, part by part: one product of all parts takes ten times as long in reverse."""
    cell, u = _cell(len(cubics), place)
    slopes = (
        _row(c, cell) + u * (2 * _row(d, cell) + 3 * u * _row(e, cell)) for c, d, e in cubics[:, 1:].transpose(2, 1, 0)
    )
    return jnp.stack([slope * step for slope in slopes], axis=-1)


def _row(table, cell):
    return table.at[cell].get(mode="promise_in_bounds")


def _cell(cells: int, place):
    """The cell of each place, and where it lies in that."""
    cell = jnp.clip(jnp.floor(jax.lax.stop_gradient(place)), 0, cells - 1)
    return cell.astype(jnp.int32), place - cell


class Table(NamedTuple):
    """How a spectrum is tabulated: over how many panels, over the carrier or not, and by how much that errs."""

    panels: int
    over_carrier: bool
    error: float


def table_for(lines: Lines, reach: float, tolerance: float) -> Table:
    """The table of a spectrum over a range of path differences [turns] that keeps a tolerance.

    A cubic between values and slopes errs by (h k)⁴ / 384 of the amplitude, h the step and k the largest frequency.

    Raises ValueError where it would need more cells than are allowed.
    """
    frequency = float(largest_frequency(lines))
    over_carrier = _panels(reach * frequency, tolerance) > _DIRECT
    if over_carrier:
        frequency = 2 * np.pi * float(np.abs(np.asarray(lines.ratios) - 1).max()) + float(_bandwidth(lines))
    return table_of_frequency(frequency, reach, tolerance, over_carrier=over_carrier)


def table_of_frequency(frequency: float, reach: float, tolerance: float, *, over_carrier: bool = False) -> Table:
    """`table_for`, of the largest frequency [radians per turn]."""
    panels = _panels(reach * frequency, tolerance)
    fitting_class = next((size for size in _CLASSES if size >= panels), None)
    if fitting_class is None:
        raise ValueError(
            f"path differences over {reach:.3g} wavelengths of so wide a spectrum need a table of {panels:.0f} panels; "
            f"allowed: {_CLASSES[-1]}; use Traced()"
        )
    step = reach * frequency / ((fitting_class - 1) * _PANEL)
    return Table(fitting_class, over_carrier, step**4 / 384)


def fits_in_table(frequency, reach, tolerance: float, table: Table):
    """Whether a table holds numbers of a largest frequency [radians per turn], traced too, within a tolerance."""
    return _panels(reach * frequency, tolerance) <= table.panels


def largest_frequency(lines: Lines) -> Any:
    """Of the fringes of any line [radians per turn of the mean wavenumber]."""
    return 2 * np.pi * lines.ratios.max() + _bandwidth(lines)


def _panels(reach: Any, tolerance: float) -> Any:
    """How many take in a range of radians, one more since they begin at multiples of their length."""
    return 1 + reach / (_PANEL * min((384 * tolerance) ** 0.25, _LONGEST))


def _bandwidth(lines: Lines) -> Any:
    """Of the fading of lines that have widths, as a frequency [radians per turn]."""
    total = 0.0
    for width, factor in zip(lines.widths, _BANDWIDTHS, strict=True):
        total += 0.0 if width is None else factor * width.max()
    return total


def waveform(
    lines: Lines,
    powers: Float[Any, "channels lines"],
    low,
    high,
    table: Table,
    *,
    only_real: bool = False,
    means: GapMeans | None = None,
) -> Waveform:
    """Γ of channels that take these powers of the lines, tabulated between two path differences [turns].

    - `means`: of the pixels, where they are functions of the path difference.
    - `only_real`: without Γ's imaginary part, which real envelopes do without unless it is over the carrier.
    """
    shift = 1.0 if table.over_carrier else 0.0

    def parts(turns):
        xp = namespace(lines, powers, turns)
        waves = (lines.ratios - shift)[:, None] * turns
        if only_real and lines.are_sharp and means is not None and means.side is None:
            # What is below with one cosine in place of four: most of the cost of a blurred white picture's table.
            size, angle, *_ = means.blurred(lines.ratios[:, None], turns)
            return powers @ (size * _cosine(xp, waves + angle / (2 * np.pi)))
        along, aside = faded(lines, means, turns, _cosine(xp, waves), _sine(xp, waves))
        along = powers @ along
        return along if only_real else xp.concatenate([along, powers @ aside])

    return tabulated(parts, low, high, table.panels)


def _cosine(xp, turns):
    return np.cos(2 * np.pi * turns) if xp is np else cos_turns(turns)


def _sine(xp, turns):
    return np.sin(2 * np.pi * turns) if xp is np else sin_turns(turns)


def tabulated(
    function: Callable[[Float[Any, " n"]], Float[Any, "parts n"]],
    low: Float[Any, ""],
    high: Float[Any, ""],
    panels: int,
) -> Waveform:
    """A function of the path difference [turns], tabulated between two of them in so many panels."""
    xp = namespace(low, high)
    # From a multiple of a panel's length on: the cusp that a Lorentzian line has at 0 lies between two panels.
    length = xp.maximum(high - low, 1e-3) / (panels - 1)
    first = xp.floor(low / length)
    centres = (first + 0.5 + xp.arange(panels, dtype=float)) * length
    turns = (centres[:, None] + chebyshev.nodes(_NODES) * length / 2).reshape(-1)
    parts = function(turns)
    xp = module_of(parts)
    values, slopes = ((parts.reshape(-1, _NODES) @ matrix).reshape(len(parts), panels, -1) for matrix in _at_cells())
    rise, before, after = values[..., 1:] - values[..., :-1], slopes[..., :-1], slopes[..., 1:]
    cubics = [values[..., :-1], before, 3 * rise - 2 * before - after, before + after - 2 * rise]
    stacked = xp.stack(cubics).reshape(4, len(parts), -1).transpose(2, 0, 1)
    return Waveform(stacked, first * length, _PANEL / length)


@cache
def _at_cells() -> tuple[np.ndarray, np.ndarray]:
    """From values at a panel's nodes to values, and slopes per cell, at the ends of its cells [nodes, ends]."""
    ends, analysis = np.linspace(-1, 1, _PANEL + 1), chebyshev.analysis(_NODES)
    derivative = chebder(np.eye(_NODES))
    return (
        (chebvander(ends, _NODES - 1) @ analysis).T.copy(),
        (chebvander(ends, _NODES - 2) @ derivative @ analysis).T * (2 / _PANEL),
    )


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
