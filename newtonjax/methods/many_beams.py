"""Images of all orders in the gap, where the bench has a closed form: functions of the path difference alone.

Of one sharp line Airy's sum at every pixel; of more, tables of it as for many wavelengths.
"""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.fields import (
    Airy,
    Table,
    Waveform,
    airy_in_lines,
    airy_of,
    airy_pixels,
    closed_amplitudes,
    harmonics_of,
    largest_frequency,
    table_of_frequency,
    tabulated,
)
from newtonjax.methods.closed_form_float32 import closed_turns
from newtonjax.methods.many_wavelengths import path_range, require_points
from newtonjax.numerics import cosine_and_sine, fraction, is_concrete
from newtonjax.scene import Camera, Channels, Gap, Lines, Scene, Surface, channels_of, gap_between

# Of traced numbers neither range nor harmonics are known: a table of so many panels.
_TRACED = Table(256, over_carrier=False, error=1e-4)
# Sources in parallel light: one direction, in which both polarizations have the same amplitudes.
_SINES, _COSINES, _SHARES = np.zeros(1), np.ones(1), np.full((2, 1), 0.5)


def all_orders(scene: Scene, camera: Camera, tolerance: float) -> Float[Array, "rows columns *channels"]:
    """All orders between the faces of the gap, errors of a table within a tolerance of the fringes' amplitude.

    Raises ValueError for a camera of pixels that are means, and where a table would be too large.
    """
    require_points(camera, "all_orders")
    gap, channels = gap_between(scene), channels_of(scene.light, camera.response)
    airy = orders_in_lines(scene, channels)
    if len(channels.lines.ratios) == 1 and _is_sharp(channels.lines):
        term = Airy(*(part[0, 0, 0] for part in airy))
        image = _one_term(scene, camera, gap, term)[..., None] * jnp.asarray(channels.powers[:, 0])
    else:
        image = _by_table(scene, camera, gap, channels, airy, tolerance)
    return image if camera.response is not None else image[..., 0]


def orders_in_lines(scene: Scene, channels: Channels) -> Airy:
    """All orders of each polarization, line and direction of the light, [2, lines, directions]."""
    return airy_of(scene, (scene.wavelength / channels.lines.ratios)[:, None], _SINES[None])


def profile_of(scene: Scene, camera: Camera, turns: Float[np.ndarray, " n"]) -> Float[np.ndarray, "channels n"]:
    """What each channel takes at path differences [turns of the mean wavenumber], of known numbers."""
    channels = channels_of(scene.light, camera.response)
    airy = orders_in_lines(scene, channels)
    count = harmonics_of(airy, 1e-6)
    return airy_in_lines(airy, channels.lines, channels.powers, _SHARES, _COSINES, turns, count)


def change_by_orders(scene: Scene, camera: Camera) -> float:
    """Largest change of intensity over the peak between all orders in the gap and its two beams on bare glass."""
    turns = np.linspace(0.0, 1.0, 1001)
    profile = profile_of(scene, camera, turns)
    background, mutual = closed_amplitudes(scene)
    level = channels_of(scene.light, camera.response).powers.sum(axis=1)
    two_beams = level[:, None] * (background + mutual * np.cos(2 * np.pi * turns))
    return float(abs(profile - two_beams).max() / profile.max())


def _is_sharp(lines: Lines) -> bool:
    return lines.gaussian is None and lines.lorentzian is None and lines.triangle is None


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


def _by_table(scene: Scene, camera: Camera, gap: Gap, channels: Channels, airy: Airy, tolerance: float):
    wavenumber = 1 / scene.wavelength
    low, high = path_range(gap, camera, wavenumber)
    table, count = _TRACED, None
    if is_concrete(scene, camera):
        count = harmonics_of(airy, tolerance)
        table = table_of_frequency(count * largest_frequency(channels.lines), float(high - low), tolerance)

    def profile(turns):
        return airy_in_lines(airy, channels.lines, channels.powers, _SHARES, _COSINES, turns, count)

    wave = tabulated(profile, low, high, table.panels)
    x, y = camera.axes()
    return _looked_up(gap, wavenumber, wave, x[None, :], y[:, None])


@jax.jit
def _looked_up(gap: Gap, wavenumber, wave: Waveform, x, y) -> Float[Array, "rows columns channels"]:
    def image(profile) -> Any:
        turns = gap.opd(x, y, profile) * wavenumber
        return wave.at(jnp.broadcast_to(turns, jnp.broadcast_shapes(x.shape, y.shape)))

    return jax.lax.cond(gap.is_shallow(x, y), lambda: image(Surface.shallow_sag), lambda: image(Surface.sag))
