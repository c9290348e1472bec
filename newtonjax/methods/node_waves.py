"""Envelopes at nodes that depend on the wavelength: by the means of pixels, and by the directions of a source."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Complex, Float

from newtonjax.fields import (
    Beats,
    Fields,
    GapMeans,
    error_of,
    means_along,
    pixel_factors,
    smooth,
)
from newtonjax.numerics import as_complex, chebyshev, is_concrete, module_of, namespace
from newtonjax.scene import Camera, Lines

# At how many wavenumbers such envelopes are computed, by the range of wavenumbers over the mean one.
_WAVES = ((2e-3, 1), (0.05, 2), (0.3, 4), (np.inf, 7))
# Nodes to a side at which the fringes of few lines are summed, so many that fields of fewer may be cut from these; and
# most terms of these sums.
_FINE, _COUNTS, _TERMS = 17, (5, 9, 13), 64
# Imaginary parts of envelopes, over the largest envelope, that are rounding.
_REAL = 1e-12


class NodeLight(NamedTuple):
    """As `Beats` at nodes, of light of one direction or more, which adds up with weights.

    - `sines`: of the directions, along x and y about the mean one.
    """

    background: Float[Any, "directions n"]
    envelope: Complex[Any, "directions pairs n"]
    turns: Float[Any, "directions pairs n"]
    arrives: Bool[Any, "directions n"]
    weights: Float[Any, " directions"]
    sines: Float[Any, "directions 2"]

    def mean_turns(self) -> Float[Any, "pairs n"]:
        """The path differences of the carrier [turns]."""
        return (self.weights[:, None, None] * self.turns).sum(axis=0) / self.weights.sum()

    def summed(self) -> tuple[Any, Any]:
        """The background [n], and amplitudes [pairs, n] whose real parts are the mean line's fringes."""
        waves = self.envelope * np.exp(2j * np.pi * self.turns)
        return self.weights @ self.background, np.tensordot(self.weights, waves, 1)

    def envelopes(self, camera: Camera, ratios: Float[Any, " waves"], means: GapMeans | None = None):
        """Over the carrier, of waves of these wavenumbers over the mean one, [waves, pairs, n].

        - `means`: what a table has of what pixels leave of the fringes.
        """
        xp, mean = module_of(self.turns), self.mean_turns()
        waves = self.envelope[None] * as_complex(self.weights[:, None, None])
        if camera.takes_means:
            factors = pixel_factors(self.turns.reshape(-1, self.turns.shape[-1]), camera, ratios)
            waves = waves * factors.reshape(-1, *self.turns.shape)
        if len(self.weights) > 1:
            phase = 2 * np.pi * ratios[:, None, None, None] * (self.turns - mean)
            waves = waves * (as_complex(xp.cos(phase)) + 1j * as_complex(xp.sin(phase)))
        return waves.sum(axis=1) / _in_table(means, ratios, mean)

    def on_finer_nodes(self, nodes: int) -> "NodeLight":
        """The light at nodes x nodes points, by polynomials between those at which it is known."""
        count = round(self.turns.shape[-1] ** 0.5)
        to_finer = chebyshev.values(count, nodes) @ chebyshev.analysis(count)

        def finer(part):
            grid = part.reshape(*part.shape[:-1], count, count)
            return (to_finer @ grid @ to_finer.T).reshape(*part.shape[:-1], -1)

        arrives = np.broadcast_to(self.arrives.all(), (len(self.arrives), nodes * nodes))
        return self._replace(
            background=finer(self.background), envelope=finer(self.envelope), turns=finer(self.turns), arrives=arrives
        )


def of_one_direction(beats: Beats) -> NodeLight:
    """The light of parallel beams."""
    background, envelope, turns, arrives = (part[None] for part in beats)
    return NodeLight(background, envelope, turns, arrives, np.ones(1), np.zeros((1, 2)))


def _in_table(means: GapMeans | None, ratios, turns) -> Any:
    if means is None:
        return 1.0
    real, imaginary = means.of(ratios[:, None, None], turns, 1.0, 0.0)
    return as_complex(real) + 1j * as_complex(imaginary)


def wave_count(lines: Lines, depends_on_wave: bool) -> int:
    """At how many wavenumbers envelopes are computed: one for a line or lines within 2e-3."""
    reach = float(np.ptp(lines.ratios)) if is_concrete(lines) else 1.0
    return next(number for limit, number in _WAVES if reach <= limit) if depends_on_wave else 1


def wave_parts(lines: Lines, count: int) -> tuple[Float[Any, " parts"], Float[Any, "parts lines"]]:
    """Wavenumbers over the mean one at which envelopes are computed, and what each line takes of which.

    Between these wavenumbers they are interpolated by polynomials.
    """
    xp = namespace(lines)
    ratios, low, high = lines.ratios, lines.ratios.min(), lines.ratios.max()
    if len(ratios) == 1 or count == 1:
        return xp.stack([(low + high) / 2]), xp.ones((1, len(ratios)))
    at = (low + high) / 2 + chebyshev.nodes(count) * xp.maximum(high - low, 1e-9) / 2
    shares = []
    for k in range(count):
        factors = [(ratios - at[n]) / (at[k] - at[n]) for n in range(count) if n != k]
        shares.append(xp.stack(factors).prod(axis=0))
    return at, xp.stack(shares)


class Waves(NamedTuple):
    """How what pixels leave of the fringes is shared between a table and envelopes.

    - `number`: of the wavenumbers for `wave_parts`; `means`: what the table has; None for nothing.
    - `rounding`: imaginary parts of so little, over the largest envelope, are 0.
    """

    number: int
    means: GapMeans | None = None
    rounding: float = _REAL


def waves_for(light: NodeLight, camera: Camera, lines: Lines, tolerance: float) -> Waves:
    """The fewest wavenumbers that keep a tolerance of the envelopes, of known numbers.

    Where the means over pixels are nearly a function of the path difference, the table has most of them, and what is
    left hardly depends on the wavenumber. Of several pairs of beams the table has none.
    """
    has_directions = len(light.weights) > 1
    most, pairs = wave_count(lines, camera.takes_means or has_directions), light.turns.shape[1]
    if pairs != 1 or not (camera.takes_means or has_directions):
        return Waves(most)
    means = means_along(light.mean_turns()[0], camera) if camera.takes_means else None
    some = np.linspace(lines.ratios.min(), lines.ratios.max(), 2 * most)
    exact, size = light.envelopes(camera, some, means), abs(_in_table(means, some, light.mean_turns()))
    allowance = tolerance * abs(light.envelope).max()
    for count in (number for _, number in _WAVES if number <= most):
        ratios, shares = wave_parts(lines._replace(ratios=some), count)
        interpolated = np.einsum("kw,kpn->wpn", shares, light.envelopes(camera, ratios, means))
        if (abs(interpolated - exact) * size).max() <= allowance:
            return Waves(count, means, tolerance)
    return Waves(most)


def of_few_lines(
    light: NodeLight, camera: Camera, lines: Lines, tolerance: float
) -> Float[np.ndarray, "fields count count"] | None:
    """Coefficients of background, moduli and phases [turns] of all lines together, where these are smooth.

    Pixels then cost what they do in one line. None where as many nodes as are tried err by more than a tolerance of
    the peak, and where there are many lines, or lines with widths that pixels are means over.
    """
    if len(lines.ratios) * len(light.weights) > _TERMS or (camera.takes_means and not lines.are_sharp):
        return None
    light = light.on_finer_nodes(_FINE)
    turns = light.mean_turns()
    waves = light.envelopes(camera, lines.ratios) * (lines.shares[:, None, None] * lines.fading(turns))
    phase = 2 * np.pi * (lines.ratios[:, None, None] - 1) * turns
    envelope = (waves * (np.cos(phase) + 1j * np.sin(phase))).sum(axis=0)
    background = light.weights @ light.background
    arrives = light.arrives.all(axis=0)
    nodes = smooth(Fields(background, envelope, turns, np.zeros(len(background)), arrives))
    counts = (count for count in _COUNTS if error_of(nodes, count).intensity <= tolerance)
    count = next(counts, None)
    return None if count is None else nodes.coefficients[:, :count, :count]


def at_nodes(light: NodeLight, camera: Camera, ratios: Float[Any, " parts"], waves: Waves) -> Float[Any, "fields n"]:
    """Fields at nodes, smooth whatever the spectrum: background, parts of the envelopes, turns.

    - `ratios`: wavenumbers at which envelopes are computed, see `wave_parts`.
    """
    xp, turns = module_of(light.turns), light.mean_turns()
    envelope = light.envelopes(camera, ratios, waves.means)
    envelope = envelope.reshape(-1, envelope.shape[-1])
    if xp is np and abs(envelope.imag).max(initial=0.0) <= waves.rounding * abs(envelope).max(initial=0.0):
        envelope = envelope.real + 0j
    background = (light.weights[:, None] * light.background).sum(axis=0)
    turns = xp.tile(turns, (len(envelope) // len(turns), 1))
    return xp.concatenate([background[None], envelope.real, envelope.imag, turns])
