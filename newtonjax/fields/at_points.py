"""Smooth fields of a scene at points of the screen: background, fringe envelopes and phases."""

import math
from itertools import combinations
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float, Int

from newtonjax.numerics import as_complex, cos_turns, module_of, sin_turns
from newtonjax.rays import Arrival, arrive_all, gather
from newtonjax.scene import Scene, Source, itinerary, source_of


class Fields(NamedTuple):
    """I = background + Σ_pairs Re[envelope e^{2πi phase}], all smooth.

    The background is the sum of the beams' irradiances; a pair of beams (j, k) has the envelope 2 E_k·E_j* (summed
    over polarizations), and the phase, in turns, is by how much beam k is behind beam j. `rounding` bounds the
    phase's error [turns] from the rounding of the optical paths, which are far longer than their difference.
    """

    background: Float[Any, "..."]
    envelope: Complex[Any, "pairs ..."]
    phase: Float[Any, "pairs ..."]
    rounding: Float[Any, "..."]
    arrives: Bool[Any, "..."]


def pairs(scene: Scene) -> tuple[tuple[int, int], ...]:
    """Indices of the beams that interfere two by two, the beam with more gap crossings second."""
    lengths = [len(itinerary(word, len(scene.surfaces)).surface) for word in scene.beams]
    couples = combinations(range(len(lengths)), 2)
    return tuple((j, k) if lengths[j] <= lengths[k] else (k, j) for j, k in couples)


def arrivals_at(scene: Scene, points: Float[Array | np.ndarray, "n 2"]) -> Arrival:
    """Every beam at every point of the screen [beams, n]; points in metres. Compiled anew for each kind of scene."""
    return arrive_all(*gather(scene), jnp.asarray(points))


def fields_at(scene: Scene, points: Float[Array | np.ndarray, "n 2"]) -> Fields:
    """The fields of a scene at points of its screen [m], every ray traced."""
    couples = np.array(pairs(scene), dtype=int).reshape(-1, 2)
    return combine(arrivals_at(scene, points), couples, source_of(scene.light))


def combine(beams: Arrival, pairs: Int[Any, "pairs 2"], source: Source) -> Fields:
    """The fields of beams at points [beams, n]; NumPy makes NumPy. `pairs` [pairs, 2]: which interfere, see `pairs`."""
    xp = module_of(beams.path)
    first, second = pairs[:, 0], pairs[:, 1]
    mutual = source.mutual(beams.field[first], beams.field[second])
    envelope, turns = source.fringes(mutual, beams.path[second] - beams.path[first])
    longest = xp.abs(beams.path).max(axis=0) / source.wavelength
    rounding = 8 * xp.finfo(longest.dtype).eps * longest
    return Fields(
        background=source.irradiance(beams.field).sum(axis=0),
        envelope=envelope,
        phase=turns - (beams.quarter_turns[second] - beams.quarter_turns[first]) / 4,
        rounding=rounding if xp is np else jax.lax.stop_gradient(rounding),
        arrives=beams.arrives.all(axis=0),
    )


class Beats(NamedTuple):
    """As `Fields` in a sharp line, the quarter turns of the beams in the envelope: what any wavelength makes of it.

    I = background + Σ_pairs Re[envelope e^{2πi turns}], turns the path difference over the wavelength.
    """

    background: Float[Any, "..."]
    envelope: Complex[Any, "pairs ..."]
    turns: Float[Any, "pairs ..."]
    arrives: Bool[Any, "..."]


def beats(beams: Arrival, pairs: Int[Any, "pairs 2"], source: Source) -> Beats:
    """The beats of beams at points [beams, n]; NumPy makes NumPy."""
    first, second = pairs[:, 0], pairs[:, 1]
    xp = module_of(beams.path)
    turned = -np.pi / 2 * (beams.quarter_turns[second] - beams.quarter_turns[first])
    mutual = source.mutual(beams.field[first], beams.field[second])
    envelope = mutual * (as_complex(xp.cos(turned)) + 1j * as_complex(xp.sin(turned)))
    turns = (beams.path[second] - beams.path[first]) / source.wavelength
    return Beats(source.irradiance(beams.field).sum(axis=0), envelope, turns, beams.arrives.all(axis=0))


def opd_at(scene: Scene, points: Float[Array | np.ndarray, "n 2"]) -> tuple[Float[Array, " n"], Bool[Array, " n"]]:
    """Optical path difference of a scene's two beams at points of its screen [m], and whether both arrive."""
    return path_difference(arrivals_at(scene, points), np.array(pairs(scene)))


def path_difference(beams: Arrival, pairs: Int[np.ndarray, "1 2"]) -> tuple[Float[Any, " n"], Bool[Any, " n"]]:
    """`opd_at` of two beams that arrive at points; NumPy makes NumPy."""
    ((first, second),) = pairs
    return beams.path[second] - beams.path[first], beams.arrives.all(axis=0)


def intensity(fields: Fields) -> Float[Any, "..."]:
    """The irradiance that the fields make, over the incident one; NumPy makes NumPy."""
    if module_of(fields.phase) is np:
        turns = 2 * np.pi * (fields.phase - np.round(fields.phase))
        cosine, sine = np.cos(turns), np.sin(turns)
    else:
        cosine, sine = cos_turns(fields.phase), sin_turns(fields.phase)
    return fields.background + (fields.envelope.real * cosine - fields.envelope.imag * sine).sum(axis=0)


def polar(fields: Fields) -> tuple[Float[Any, "pairs ..."], Float[Any, "pairs ..."]]:
    """Signed modulus A and phase φ [turns] per pair with I = background + Σ A cos 2πφ, smooth where A changes sign.

    The envelope is turned to be nearly real by the argument of its largest value; what angle is left enters the phase
    through the arctangent of its slope. An envelope that circles zero has no smooth polar form: its coefficients then
    decay slowly, which the error estimate sees. NumPy makes NumPy.
    """
    xp = module_of(fields.envelope)
    flat = fields.envelope.reshape(len(fields.envelope), math.prod(fields.envelope.shape[1:]))
    largest = xp.take_along_axis(flat, abs(flat).argmax(axis=1)[:, None], axis=1)
    size = abs(largest)
    unit = xp.where(size > 0, largest * as_complex(1 / xp.where(size > 0, size, 1.0)), 1.0)
    unit = (unit if xp is np else jax.lax.stop_gradient(unit)).reshape(-1, *[1] * (fields.envelope.ndim - 1))
    turned = fields.envelope * unit.conj()
    slope = turned.imag / xp.where(turned.real == 0, 1.0, turned.real)
    angle = (xp.angle(unit) + xp.arctan(slope)) / (2 * np.pi)
    return turned.real * xp.sqrt(1 + slope * slope), fields.phase + angle
