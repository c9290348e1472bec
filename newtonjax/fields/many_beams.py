"""All orders between the two faces of a gap: Airy's sum in closed form, and its harmonics where lines have widths.

With a the amplitude reflected at the first face, b that of the first order through the gap over its phase factor E,
and g that of one more round trip, |a + b E + b g E² + ...|² = level + 2 Re[first E / (1 - g E)] with

    level = |a|² + |b|² / (1 - |g|²),    first = b a* + |b|² g / (1 - |g|²),

since harmonic m is first g^(m-1) (Born and Wolf, Principles of Optics, section 7.6.1); in transmission a is 0.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Complex, Float

from newtonjax.fields.means_in_gap import GapMeans, faded
from newtonjax.numerics import as_complex, namespace
from newtonjax.scene import FaceAmplitudes, Lines, Scene, face_amplitudes, itinerary, required_gap

# Of traced numbers the number of harmonics that matter is data: they are summed by chunks until what is left is below
# rounding, at most so many. Two mirrors of reflectance 0.99 then err by 1e-8 of the peak.
_CHUNK, _CHUNKS, _ROUNDING = 32, 64, 1e-10


class Airy(NamedTuple):
    """level + 2 Re[first E / (1 - round_trip E)], E = e^{2πi turns}: intensities over the incident one."""

    level: Float[Any, "..."]
    first: Complex[Any, "..."]
    round_trip: Complex[Any, "..."]

    def parts(self) -> tuple[Float[Any, "..."], ...]:
        """Real numbers that `airy_pixels` takes."""
        return self.level, self.first.real, self.first.imag, self.round_trip.real, self.round_trip.imag


def airy_pixels(parts: tuple[Float[Any, "..."], ...], cosine: Float[Any, "..."], sine: Float[Any, "..."]) -> Any:
    """The sum where E has this real and this imaginary part; `parts` as `Airy.parts`.

    The squares of 1 - g E and not 1 + |g|² - 2 Re g E, which cancels at the peaks of good mirrors.
    """
    level, first, aside, round_trip, turned = parts
    real = 1 - (round_trip * cosine - turned * sine)
    imaginary = round_trip * sine + turned * cosine
    excess = (first * cosine - aside * sine) * real - (first * sine + aside * cosine) * imaginary
    return level + 2 * excess / (real * real + imaginary * imaginary)


def airy_of(scene: Scene, wavelengths: Float[Any, "..."], squares: Float[Any, "..."]) -> Airy:
    """All orders in a scene's gap, or its two beams where it asks for no more, of s and p polarization, [2, ...].

    - `wavelengths`: in vacuum [m]; `squares`: of n sin θ, the same in all media.

    What the other faces of the bench reflect is lost. Raises ValueError where the scene's beams have no gap.
    """
    upper, orders, media = required_gap(scene), scene.all_orders, scene.media
    coatings = (None, None) if orders is None else (orders.upper, orders.lower)
    gap = media[upper + 1]
    above = face_amplitudes(coatings[0], media[upper], gap, wavelengths, squares)
    below = face_amplitudes(coatings[1], media[upper + 2], gap, wavelengths, squares)
    passed = _passed_outside(scene, upper, wavelengths, squares)
    round_trip = above.inside * below.inside
    if orders is None:
        return _two_beams(scene.view, passed, above, below)
    stored = 1 / (1 - _square(round_trip))
    if scene.view == "transmitted":
        level = passed * above.transmittance * below.transmittance * stored
        return Airy(level, as_complex(level) * round_trip, round_trip)
    entering = above.through * below.inside
    level = passed * (_square(above.outside) + _square(entering) * stored)
    first = entering * above.outside.conj() + as_complex(_square(entering) * stored) * round_trip
    return Airy(level, as_complex(passed) * first, round_trip)


def _two_beams(view: str, passed: Float[Any, "2 ..."], above: FaceAmplitudes, below: FaceAmplitudes) -> Airy:
    """The first two orders alone: as all of them of an amplitude of no further round trip."""
    none = 0.0 * above.inside
    if view == "transmitted":
        again = above.inside * below.inside
        level = passed * above.transmittance * below.transmittance
        return Airy(level * (1 + _square(again)), as_complex(level) * again, none)
    entering = above.through * below.inside
    level = passed * (_square(above.outside) + _square(entering))
    return Airy(level, as_complex(passed) * entering * above.outside.conj(), none)


def _passed_outside(scene: Scene, upper: int, wavelengths, squares) -> Float[Any, "2 ..."]:
    """Share of the flux that the faces outside of the gap let pass, there and back."""
    xp = namespace(scene.media, wavelengths, squares)
    path = itinerary(min(scene.beams, key=len), len(scene.surfaces))
    passed = xp.ones((2, *xp.broadcast_shapes(xp.shape(wavelengths), xp.shape(squares))))
    for surface, before, beyond in zip(path.surface, path.before, path.beyond, strict=True):
        if surface not in (upper, upper + 1):
            face = face_amplitudes(None, scene.media[before], scene.media[beyond], wavelengths, squares)
            passed = passed * face.transmittance
    return passed


def _square(amplitude: Complex[Any, "..."]) -> Float[Any, "..."]:
    return amplitude.real**2 + amplitude.imag**2


def harmonics_of(airy: Airy, tolerance: float) -> int:
    """How many harmonics matter: beyond, they add less than a tolerance of the first one. Known numbers."""
    strongest = float(np.sqrt(_square(airy.round_trip)).max())
    return 1 if strongest <= tolerance else 1 + int(np.ceil(_beyond_first(np, strongest, tolerance)))


def traced_harmonics_of(airy: Airy, tolerance: float) -> Float[Any, ""]:
    """The same of traced numbers, which need not be an integer."""
    strongest = jax.lax.stop_gradient(jnp.sqrt(jnp.max(_square(airy.round_trip))))
    return 1 + _beyond_first(jnp, jnp.maximum(strongest, tolerance), tolerance)


def _beyond_first(xp, strongest, tolerance: float):
    # The harmonics from m on add up to 2 first g^(m-1) / (1 - g).
    return xp.log(tolerance * (1 - strongest) / 2) / xp.log(strongest)


def airy_in_lines(
    airy: Airy,
    lines: Lines,
    powers: Float[Any, "channels lines"],
    shares,
    cosines,
    turns: Float[Any, " n"],
    count,
    means: GapMeans | None = None,
) -> Float[Any, "channels n"]:
    """The sum over lines, source points and polarizations at path differences [turns of the mean wavenumber].

    - `airy`: [2, lines, points]; `shares`: of the polarizations and points, [2, points]; `cosines`: of the light's
      angle in the gap, [points].
    - `count`: how many harmonics are summed where lines have widths of another form than Lorentz's, whose sum is
      closed, or pixels are means; None of traced numbers: as many as matter, up to 2048.
    - `means`: of the pixels; None where they are points.
    """
    xp = namespace(airy, lines, powers, shares, cosines, turns)

    def add(total, point):
        of_point, cosine, share = point
        of_lines = _of_lines(xp, of_point, lines, turns, cosine, count, means)
        return total + powers @ (share[:, None, None] * of_lines).sum(axis=0), None

    total = xp.zeros((len(powers), len(turns)))
    points = (Airy(*(xp.moveaxis(xp.asarray(part), -1, 0) for part in airy)), cosines, xp.asarray(shares).T)
    if xp is jnp:
        return jax.lax.scan(add, total, jax.tree.map(jnp.asarray, points))[0]
    for point in zip(*points[0], *points[1:], strict=True):
        total, _ = add(total, (Airy(*point[:3]), *point[3:]))
    return total


def _of_lines(
    xp, airy: Airy, lines: Lines, turns: Float[Any, " n"], cosine, count, means: GapMeans | None
) -> Float[Any, "2 lines n"]:
    ratios = lines.ratios[:, None] * cosine
    phase, path = 2 * np.pi * ratios * turns, turns * cosine
    wide = Airy(*(part[..., None] for part in airy))
    if lines.are_sharp and means is None:
        return airy_pixels(wide.parts(), xp.cos(phase), xp.sin(phase))
    if lines.gaussian is None and lines.triangle is None and means is None:
        # Harmonic m fades as the m-th power of the first: a loss of each round trip.
        loss = as_complex(lines.fading(path))
        lossy = wide._replace(first=wide.first * loss, round_trip=wide.round_trip * loss)
        return airy_pixels(lossy.parts(), xp.cos(phase), xp.sin(phase))
    wave = as_complex(xp.cos(phase)) + 1j * as_complex(xp.sin(phase))
    total, harmonic, step = wide.level + 0.0 * phase, wide.first * wave, wide.round_trip * wave

    def faded_part(order, harmonic):
        return faded(lines, means, turns, harmonic.real, harmonic.imag, order * cosine)[0]

    if count is None:
        return _summed_in_chunks(total, harmonic, step, faded_part)
    for order in range(1, 1 + count):
        total = total + 2 * faded_part(order, harmonic)
        harmonic = harmonic * step
    return total


def _summed_in_chunks(total, first, step, faded_part):
    """The sum of harmonics of traced numbers; chunks that only rounding would see are left out."""
    # What the rest adds up to, beside the first harmonic.
    size = jax.lax.stop_gradient(jnp.sqrt(jnp.max(_square(step))))

    def add(state, order):
        total, harmonic = state
        return (total + 2 * faded_part(order, harmonic), harmonic * step), None

    @jax.checkpoint
    def add_chunk(state, begin):
        def added(state):
            return jax.lax.scan(add, state, begin + jnp.arange(_CHUNK, dtype=begin.dtype))[0]

        matters = size ** (begin - 1) > _ROUNDING * (1 - size)
        return jax.lax.cond(matters, added, lambda state: state, state), None

    return jax.lax.scan(add_chunk, (total, first), 1 + _CHUNK * jnp.arange(_CHUNKS, dtype=total.dtype))[0][0]
