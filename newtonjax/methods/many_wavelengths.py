"""Images in light of many wavelengths, or of a camera's channels, by a table of the path difference."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.fields import (
    GapMeans,
    Table,
    Waveform,
    closed_amplitudes,
    combined,
    faded,
    fringes_by_table,
    gap_means,
    image_in_channels,
    table_for,
    waveform,
)
from newtonjax.methods.gap_paths import (
    RANGE_POINTS,
    bounds_between,
    channels_over_source,
    path_range,
    turns_at_pixels,
)
from newtonjax.methods.node_waves import wave_count, wave_parts
from newtonjax.methods.pictures import AbstractPicture, starts
from newtonjax.numerics import (
    chebyshev,
    cos_turns,
    is_concrete,
    module_of,
    sin_turns,
    unchecked,
    x64,
)
from newtonjax.scene import (
    Camera,
    Channels,
    Gap,
    Light,
    Scene,
    channels_of,
    gap_between,
    lights_of_channels,
    of_channel,
)

# Of traced numbers the range is not known: a table of so many panels, which errs by less than 1e-4 up to 200 orders.
# Up to so many lines need none.
_TRACED, _FEW = Table(64, over_carrier=False, error=1e-4), 8


class Spectral(NamedTuple):
    """Tables of a light and a camera.

    - `waves`: Γ of each channel, in parts that have an envelope each; `levels`: what the channels take of all light.
    """

    waves: tuple[Waveform, ...]
    levels: Float[Any, " channels"]


def has_channels(light: Light, camera: Camera) -> bool:
    """Whether an image is more than that of one sharp line at points, to a camera that takes all wavelengths alike."""
    return light.spectrum is not None or light.extent is not None or camera.response is not None or camera.takes_means


def one_line(scene: Scene) -> Scene:
    """The scene in parallel light and a sharp line of its mean wavenumber, of its named beams alone."""
    light = scene.light
    if light.extent is not None or light.spectrum is not None:
        light = unchecked(light, extent=None, spectrum=None)
    return unchecked(scene, light=light, all_orders=None)


def table_of(channels: Channels, low, high, tolerance: float) -> Table:
    """How to tabulate what channels take between two path differences [turns]."""
    if not is_concrete(channels, low, high):
        return _TRACED
    return table_for(channels.lines, float(high - low), tolerance)


def spectral(channels: Channels, low, high, table: Table, *, only_real: bool, parts=None, means=None) -> Spectral:
    """The tables of channels between two path differences [turns].

    - `parts`: shares of each line in the parts that have an envelope each, [parts, lines]; None for one.
    - `means`: of pixels in a gap, as of `waveform`.
    """
    powers = [channels.powers] if parts is None else [channels.powers * shares for shares in parts]
    lines = channels.lines
    waves = tuple(waveform(lines, part, low, high, table, only_real=only_real, means=means) for part in powers)
    return Spectral(waves, channels.powers.sum(axis=1))


def equal_thickness(scene: Scene, camera: Camera, tolerance: float) -> Float[Array, "rows columns *channels"]:
    """Fringes of equal thickness, errors of the table within a tolerance of their amplitude.

    Of pixels that are means, what `means_error` says beside that.
    """
    x, y = camera.axes()
    gap, channels = gap_between(scene), channels_of(scene.light, camera.response)
    wavenumber, amplitudes = 1 / scene.wavelength, closed_amplitudes(scene)
    means = gap_means(gap, camera, wavenumber)
    if not is_concrete(scene, camera) and len(channels.lines.ratios) <= _FEW:
        image = _line_by_line(gap.opd(x[None, :], y[:, None]) * wavenumber, *amplitudes, channels, means)
    else:
        low, high = path_range(gap, camera, wavenumber)
        table = table_of(channels, low, high, tolerance)
        tables = spectral(channels, low, high, table, only_real=not table.over_carrier, means=means)
        image = _pixels(gap, wavenumber, *amplitudes, tables, x[None, :], y[:, None], table.over_carrier)
    return image if camera.response is not None else image[..., 0]


@partial(jax.jit, static_argnums=7)
def _pixels(gap: Gap, wavenumber, background, mutual, tables: Spectral, x, y, over_carrier: bool):
    turns = turns_at_pixels(gap, wavenumber, x, y)
    levels, wave = background * tables.levels, tables.waves[0]
    if over_carrier:
        return levels + fringes_by_table(mutual, None, turns, len(tables.levels), wave, over_carrier)
    cubics = (mutual * jnp.asarray(wave.cubics)).at[:, 0].add(levels)
    return wave._replace(cubics=cubics).at(turns)


def _line_by_line(turns, background, mutual, channels: Channels, means: GapMeans | None):
    """The sum over few lines at every pixel, for traced numbers."""
    lines = channels.lines
    ratios = lines.ratios.reshape(-1, 1, 1)
    waves = cos_turns(ratios * turns)
    if means is None:
        waves = waves * lines.fading(turns)
    else:
        waves, _ = faded(lines, means, turns, waves, sin_turns(ratios * turns))
    image = jnp.einsum("cl,lyx->yxc", jnp.asarray(channels.powers), waves, precision="highest")
    return background * channels.powers.sum(axis=1) + mutual * image


def by_channels(
    image: Callable[[Scene, Camera], Float[Array, "rows columns"]], scene: Scene, camera: Camera
) -> Float[Array, "rows columns channels"]:
    """The image of a camera with channels, of a function that makes those of one without."""
    channels = channel_by_channel(scene, camera)
    return jnp.stack([level * image(bench, eye) for bench, eye, level in channels], axis=-1)


def channel_by_channel(scene: Scene, camera: Camera) -> list[tuple[Scene, Camera, Any]]:
    """Of each channel the scene in its light, the camera of its pixels, and its level."""
    lights = [] if camera.response is None else lights_of_channels(scene.light, camera.response)
    return [
        (replace(scene, light=light), of_channel(camera, channel), level)
        for channel, (light, level) in enumerate(lights)
    ]


def require_points(camera: Camera, method: str) -> None:
    """Raise ValueError for a camera of pixels that are means."""
    if camera.takes_means:
        raise ValueError(
            f"{method} takes the light at pixels' centres: leave out aperture and blur, or use Chebyshev()"
        )


def turn_range(coefficients: Float[Any, "fields count count"]) -> tuple[Any, Any]:
    """Bounds of all pairs' path differences over an image [turns], of coefficients as `at_nodes` orders fields."""
    xp, pairs = module_of(coefficients), (len(coefficients) - 1) // 3
    basis = xp.asarray(chebyshev.basis(RANGE_POINTS, coefficients.shape[-1]))
    return bounds_between(basis.T @ coefficients[1 + 2 * pairs :] @ basis)


def on_nodes(coefficients: Float[Array, "fields count count"], scene: Scene, camera: Camera):
    """The image of traced coefficients, as `at_nodes` orders fields."""
    channels = channels_over_source(scene, camera)
    _, parts = wave_parts(channels.lines, wave_count(channels.lines, camera.takes_means))
    tables = spectral(channels, *turn_range(coefficients), _TRACED, only_real=False, parts=parts)
    image = combined(chebyshev.expand(coefficients, camera.shape), tables.levels, tables.waves, over_carrier=False)
    return image if camera.response is not None else image[..., 0]


@dataclass(frozen=True, eq=False)
class InChannels(AbstractPicture):
    """Pixels that are looked up in tables of a spectrum, from smooth fields.

    - `coefficients`: as `at_nodes` orders fields, in NumPy; `tables` of the spectrum, over the carrier or not.
    - `has_response`: whether the image has an axis for channels.
    - `result`: the type of an image.
    """

    coefficients: Float[np.ndarray, "fields nodes nodes"]
    shape: tuple[int, int]
    tables: Spectral
    over_carrier: bool
    has_response: bool
    result: str

    def image(self) -> Float[Array, "rows columns *channels"]:
        return self._rows(0, self.shape[0])

    def _rows(self, first: int, count: int) -> Array:
        levels, waves = self.tables.levels, self.tables.waves
        of_rows = image_in_channels(
            self.coefficients, self.shape, levels, waves, self.over_carrier, (first, count), self.has_response
        )
        with x64():
            return of_rows.astype(self.result)

    def blocks(self, rows: int) -> Iterator[tuple[int, Float[np.ndarray, "rows columns *channels"]]]:
        for first, count in starts(self.shape[0], rows):
            yield first, np.asarray(self._rows(first, count))
