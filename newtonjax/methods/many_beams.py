"""Images that are functions of the path difference alone, where the bench has a closed form.

All orders in the gap, or two beams, and light of many directions: of one term Airy's sum at every pixel; of more lines
or directions tables of the whole sum, as for many wavelengths.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.fields import (
    Airy,
    GapMeans,
    Table,
    Waveform,
    airy_in_lines,
    airy_of,
    airy_pixels,
    closed_amplitudes,
    fits_in_table,
    gap_means,
    harmonics_of,
    largest_frequency,
    table_of_frequency,
    tabulated,
    traced_harmonics_of,
)
from newtonjax.methods.closed_form_float32 import closed_turns
from newtonjax.methods.gap_paths import (
    of_points,
    path_range,
    source_points,
    turns_at_pixels,
)
from newtonjax.numerics import cosine_and_sine, fraction, is_concrete, namespace
from newtonjax.scene import Camera, Channels, Directions, Gap, Light, Scene, Surface, channels_of, gap_between

# Of traced numbers neither range nor harmonics are known: a table of so many panels where it errs by less, and else
# the sum at every pixel.
_TRACED, _TRACED_ERROR = Table(256, over_carrier=False, error=1e-4), 1e-7


class Profile(NamedTuple):
    """What a pixel takes as a function of the path difference.

    - `channels`: of light and camera; `airy`: orders of each polarization, line and direction, [2, lines, directions].
    - `shares`: of polarizations and directions, [2, directions]; `cosines`: of the light's angle in the gap.
    - `harmonics`: that count; None where numbers are traced.
    - `means`: of the camera's pixels; None where they are points.
    """

    channels: Channels
    airy: Airy
    shares: Float[Any, "2 directions"]
    cosines: Float[Any, " directions"]
    harmonics: int | None
    means: GapMeans | None

    def at(self, turns: Float[Any, " n"]) -> Float[Any, "channels n"]:
        """In each channel, at path differences [turns of the mean wavenumber]."""
        lines, powers = self.channels
        return airy_in_lines(self.airy, lines, powers, self.shares, self.cosines, turns, self.harmonics, self.means)


def by_profile(scene: Scene, camera: Camera, tolerance: float) -> Float[Array, "rows columns *channels"]:
    """An image by its profile, errors of a table within a tolerance of the fringes' amplitude.

    Raises ValueError where a table would be too large.
    """
    gap, profile = gap_between(scene), profile_of(scene, camera, tolerance)
    channels = profile.channels
    terms = len(channels.lines.ratios) * len(profile.cosines)
    if terms == 1 and channels.lines.are_sharp and profile.means is None:
        term = Airy(*(part[0, 0, 0] for part in profile.airy))
        image = _one_term(scene, camera, gap, term)[..., None] * jnp.asarray(channels.powers[:, 0])
    else:
        image = _by_table(scene, camera, gap, profile, tolerance)
    return image if camera.response is not None else image[..., 0]


def profile_of(scene: Scene, camera: Camera, tolerance: float = 1e-6) -> Profile:
    """The profile of a scene's gap; harmonics and directions by a tolerance."""
    channels = channels_of(scene.light, camera.response)
    index = scene.media[0]
    directions = source_points(scene, camera, 0.1 * tolerance)
    squares = directions.squares() * (index * index)
    gap = gap_between(scene)
    xp = namespace(squares, gap.refractive_index)
    airy = airy_of(scene, (scene.wavelength / channels.lines.ratios)[:, None], squares[None])
    count: int | None = 1
    if scene.all_orders is not None:
        count = harmonics_of(airy, tolerance) if is_concrete(scene) else None
    cosines = xp.sqrt(1 - squares / (gap.refractive_index * gap.refractive_index))
    means = gap_means(gap, camera, 1 / scene.wavelength)
    return Profile(channels, airy, _shares(scene.light, directions), cosines, count, means)


def _shares(light: Light, directions: Directions) -> Float[Any, "2 directions"]:
    """Of s and p polarization: half each, but for a map in polarized light (Born and Wolf, section 1.4.2)."""
    weights, extent = directions.weights, light.extent
    xp = namespace(light, directions)
    if light.polarization is None or extent is None or extent.radiances is None:
        return xp.stack([weights, weights]) / 2
    degree = 1.0 if light.degree is None else light.degree
    if light.ellipticity is not None:
        degree = degree * xp.cos(2 * light.ellipticity)
    along = directions.x * xp.cos(light.polarization) + directions.y * xp.sin(light.polarization)
    squares = directions.squares()
    of_plane = xp.where(squares > 0, along * along / xp.where(squares > 0, squares, 1.0), 0.5)
    in_plane = 0.5 + degree * (of_plane - 0.5)
    return xp.stack([1 - in_plane, in_plane]) * weights


def change_by_orders(scene: Scene, camera: Camera) -> float:
    """Largest change of intensity over the peak between all orders in the gap and its two beams on bare glass."""
    turns = np.linspace(0.0, 1.0, 1001)
    profile = profile_of(scene, of_points(camera)).at(turns)
    background, mutual = closed_amplitudes(scene)
    level = channels_of(scene.light, camera.response).powers.sum(axis=1)
    two_beams = level[:, None] * (background + mutual * np.cos(2 * np.pi * turns))
    return float(abs(profile - two_beams).max() / profile.max())


def _one_term(scene: Scene, camera: Camera, gap: Gap, term: Airy) -> Float[Array, "rows columns"]:
    if jnp.result_type(float) == jnp.float32:
        waves = cosine_and_sine(closed_turns(scene, camera))
        return airy_pixels(tuple(jnp.asarray(part) for part in term.parts()), *waves)
    x, y = camera.axes()
    return _airy(gap, 1 / scene.wavelength, term.parts(), x[None, :], y[:, None])


@jax.jit
def _airy(gap: Gap, wavenumber, parts, x, y) -> Float[Array, "rows columns"]:
    def image(profile):
        return airy_pixels(parts, *cosine_and_sine(fraction(gap.opd(x, y, profile) * wavenumber)))

    return jax.lax.cond(gap.is_shallow(x, y), lambda: image(Surface.shallow_sag), lambda: image(Surface.sag))


def _by_table(scene: Scene, camera: Camera, gap: Gap, profile: Profile, tolerance: float):
    wavenumber = 1 / scene.wavelength
    low, high = path_range(gap, camera, wavenumber)
    table = _TRACED
    if is_concrete(scene, camera) and profile.harmonics is not None:
        frequency = profile.harmonics * float(largest_frequency(profile.channels.lines))
        table = table_of_frequency(frequency, float(high - low), tolerance)
    wave = tabulated(profile.at, low, high, table.panels)
    x, y = camera.axes()
    if scene.all_orders is None or is_concrete(scene, camera):
        return _looked_up(gap, wavenumber, wave, x[None, :], y[:, None])
    frequency = traced_harmonics_of(profile.airy, _TRACED_ERROR) * largest_frequency(profile.channels.lines)
    return jax.lax.cond(
        fits_in_table(frequency, high - low, _TRACED_ERROR, _TRACED),
        lambda: _looked_up(gap, wavenumber, wave, x[None, :], y[:, None]),
        lambda: _summed(gap, wavenumber, profile, x[None, :], y[:, None]),
    )


@jax.jit
def _summed(gap: Gap, wavenumber, profile: Profile, x, y) -> Float[Array, "rows columns channels"]:
    def image(sag) -> Any:
        turns = jnp.broadcast_to(gap.opd(x, y, sag) * wavenumber, jnp.broadcast_shapes(x.shape, y.shape))
        return jnp.moveaxis(profile.at(turns.ravel()).reshape(-1, *turns.shape), 0, -1)

    return jax.lax.cond(gap.is_shallow(x, y), lambda: image(Surface.shallow_sag), lambda: image(Surface.sag))


@jax.jit
def _looked_up(gap: Gap, wavenumber, wave: Waveform, x, y) -> Float[Array, "rows columns channels"]:
    return wave.at(turns_at_pixels(gap, wavenumber, x, y))
