"""What speaks for rings in a photograph before any fit: a few numbers at the search's phase, and their verdict."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fitting.photo.matched_filter import Rings
from fitting.photo.reading import Photograph
from fitting.photo.view import View, orders_of, pixels_of, plane_wave, resolving_view, view_of
from fitting.reasons import Reason
from newtonjax.numerics import Statement

# Tiles that a field is cut into: four to a fringe and direction, within these bounds; and pixels to a side of a tile.
_FEWEST_TILES, _MOST_TILES, _SMALLEST_TILE = 25, 400, 5
# Wider tiles, in which harmonics are told from planes: so many fringes to each.
_WIDE = 1.5
_EXPONENTS = np.exp(np.linspace(np.log(0.3), np.log(3.5), 9))
# Straight fringes behind a camera's distortion of a few percent bend by so many turns, and so many more a fringe, up to
# one. The search's scale of so few of them says nothing about their bend; the fit's does.
_BEND, _WARPED, _FEW_STRAIGHT = 0.15, 0.03, 3.6
# A plane wave that explains more than this of the fringe power is the reason for a poor match.
PLANE = 0.3
# Rings of a match above the second need no other evidence; below the first none suffices; between, share and coherence
# have to be so much as the match falls short. Rings of the experiment `refusals` and of real photographs have a match
# of 0.48 and 0.26 or more; the latter's share and coherence are 0.8 or more where their match is below 0.4.
_NO_MATCH, _MATCH = 0.2, 0.42
# White noise is taken off up to this share of the variance; then rings take so much of the rest.
_MOST_NOISE, _CLEAR = 0.9, 0.85
# Harmonics that no power law of a camera leaves of two beams' fringes: rings have up to 0.07, Fabry and Perot's 0.43
# and 0.2; made ones of a finesse of 3 have 0.25 where they are bright, -0.15 where they are dark.
_SECOND, _THIRD = 0.14, 0.12
# Share of both below which no exponent of the light need be looked for.
_SMALL = 0.75
# Harmonics are judged where more than this share of the lit pixels is not saturated.
_UNCUT = 0.8


@dataclass(frozen=True)
class RingEvidence:
    """Numbers that tell rings from what is none, before any fit, and what they say.

    - `match`: share of the fringe power that the search's rings explain.
    - `orders`: fringes over the field; `bend`: turns by which one of them bends over it.
    - `share`: of the variance that planes leave of small tiles, what cosines of the rings' phase take, their amplitude
      and phase free in each tile.
    - `coherence`: mean cosine of the phase difference of neighbouring tiles, weighted by their share.
    - `second`, `third`: harmonics of the fringes over their amplitude, after the exponent that makes the second
      least; 0 where the crests are saturated.
    - `noise`: share of white noise in the variance that planes leave.
    - `plane`: share of the fringe power that straight, evenly spaced fringes explain; 0 where the match is good.
    """

    match: float
    orders: float
    bend: float
    share: float
    coherence: float
    second: float
    third: float
    noise: float
    plane: float

    @property
    def verdict(self) -> str:
        """What the numbers say: "rings", "straight", "no rings" or "many beams"."""
        if are_straight(self.orders, self.bend):
            return "straight"
        agreement = min(self.share, self.coherence)
        if (agreement < self.least_agreement or self.match < _NO_MATCH) and not self.clear_beside_noise:
            return "straight" if self.plane > PLANE else "no rings"
        return "many beams" if abs(self.second) > _SECOND or abs(self.third) > _THIRD else "rings"

    @property
    def clear_beside_noise(self) -> bool:
        """Whether rings explain nearly all that white noise does not: it lowers match and share, not coherence."""
        signal = 1.0 - min(self.noise, _MOST_NOISE)
        return self.match > _MATCH * signal and self.share > _CLEAR * signal and self.coherence > _CLEAR

    @property
    def least_agreement(self) -> float:
        """Share and coherence that rings of this match need."""
        return float(np.clip((_MATCH - self.match) / (_MATCH - _NO_MATCH), 0.0, 1.0))

    @property
    def reason(self) -> Statement | None:
        """Why no radius can be had: what was measured and what is required; None for rings."""
        match self.verdict:
            case "straight":
                return self._straight
            case "no rings":
                return self._no_rings
            case "many beams":
                return Reason.MANY_BEAMS(second=self.second, third=self.third, most_second=_SECOND, most_third=_THIRD)
            case _:
                return None

    @property
    def _straight(self) -> Statement:
        least = _least_bend(self.orders)
        if self.bend < least:
            return Reason.STRAIGHT_BEND(orders=self.orders, bend=self.bend, least=least)
        return Reason.STRAIGHT_WAVE(plane=self.plane, match=self.match)

    @property
    def _no_rings(self) -> Statement:
        if self.match < _NO_MATCH:
            return Reason.NO_RINGS_MATCH(match=self.match, least=_NO_MATCH)
        share, coherence = max(self.share, 0.0), max(self.coherence, 0.0)
        return Reason.NO_RINGS_AGREEMENT(match=self.match, share=share, coherence=coherence, least=self.least_agreement)


def are_straight(orders: float, bend: float, *, judges_few: bool = False) -> bool:
    """Whether so many fringes bend less over the field than rings do [turns]; few only where few are judged, too."""
    return orders > (0.0 if judges_few else _FEW_STRAIGHT) and bend < _least_bend(orders)


def _least_bend(orders: float) -> float:
    """Turns by which rings of so many fringes bend at least."""
    return min(1.0, _BEND + _WARPED * orders)


def evidence_of(photograph: Photograph, rings: Rings, view: View | None = None) -> RingEvidence:
    """The evidence for rings that a search found; `view`: the photograph's `resolving_view` of them."""
    x, y = pixels_of(photograph.mask)
    orders = orders_of(photograph, rings)
    bend = rings.scale * float(((x - x.mean()) ** 2 + (y - y.mean()) ** 2).max()) if len(x) else 0.0
    view = resolving_view(photograph, rings) if view is None else view
    tiles = Tiles.of(view, view.shown(rings), np.clip(4 * orders**2, _FEWEST_TILES, _MOST_TILES))
    second, third = 0.0, 0.0
    # Crests that are cut off leave harmonics undetermined; those of two levels are the threshold's.
    if not photograph.has_two_levels and photograph.mask.sum() > _UNCUT * photograph.lit.sum():
        unsaturated = view_of(photograph, view.factor, photograph.mask)
        tiles_of_few = np.clip((orders / _WIDE) ** 2, 4, _MOST_TILES)
        second, third = Tiles.of(unsaturated, unsaturated.shown(rings), tiles_of_few).harmonics
    plane = plane_wave(view) if rings.match < _MATCH else 0.0
    return RingEvidence(rings.match, orders, bend, tiles.share, tiles.coherence, second, third, tiles.noise, plane)


@dataclass(frozen=True)
class Tiles:
    """A view cut into tiles [rows, columns, pixels]: light, use (0 or 1), and the rings' phase [radians].

    `plane` [pixels, 3]: a constant and the place within a tile; `variance`: of a pixel's white noise.
    """

    light: np.ndarray
    used: np.ndarray
    phase: np.ndarray
    plane: np.ndarray
    variance: float

    @classmethod
    def of(cls, view: View, rings: Rings, count: float) -> "Tiles":
        """About so many tiles of a view, `rings` on its blocks; those of which less than half is lit are left out."""
        rows, columns = view.means.shape
        size = int(np.clip(np.sqrt(rows * columns / count), _SMALLEST_TILE, min(rows, columns)))
        variance = noise_variance(view.means, view.mask)
        x, y = np.arange(columns), np.arange(rows)[:, None]
        circles = (x - rings.centre[0]) ** 2 + (y - rings.centre[1]) ** 2
        r2 = circles if rings.bend is None else rings.bend.squared_distance(x, y, rings.centre)
        turns = (rings.scale * r2 + rings.phase) % 1.0
        tables = (view.means, view.mask, 2 * np.pi * turns)
        light, used, phase = (_cut(table.astype(np.float32), size) for table in tables)
        used *= used.mean(axis=2, keepdims=True) >= 0.5
        place = (np.arange(size) - (size - 1) / 2) / size
        plane = np.stack([np.ones(size**2), np.tile(place, size), np.repeat(place, size)], axis=1)
        return cls(light, used, phase, plane.astype(np.float32), variance)

    @cached_property
    def waves(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Per tile [rows, columns]: variance that planes leave, what a cosine takes of it, its complex amplitude."""
        light = self.light[..., None]
        before, _ = self._least_squares(light, [])
        after, coefficients = self._least_squares(light, [np.cos(self.phase), np.sin(self.phase)])
        amplitude = coefficients[..., 3, 0] - 1j * coefficients[..., 4, 0]
        return before[..., 0], np.maximum(before - after, 0.0)[..., 0], amplitude

    @property
    def share(self) -> float:
        """Share of the variance left by planes that cosines of the rings' phase take."""
        before, by_cosines, _ = self.waves
        return float(by_cosines.sum() / max(float(before.sum()), 1e-300))

    @property
    def noise(self) -> float:
        """Share of white noise in the variance that planes leave."""
        pixels = np.maximum(self.used.sum(axis=2, dtype=float) - 3, 0.0).sum()
        unexplained = float(self.waves[0].sum())
        return float(min(self.variance * pixels / unexplained, 1.0)) if unexplained > 0 else 0.0

    @property
    def coherence(self) -> float:
        """Mean cosine of the phase difference of neighbouring tiles, weighted by the share that their cosines take."""
        before, by_cosines, amplitude = self.waves
        share = np.sqrt(by_cosines / np.maximum(before, 1e-300))
        unit = share * amplitude / np.maximum(np.abs(amplitude), 1e-300)
        cosine = weight = 0.0
        for axis in (0, 1):
            later, earlier = (np.moveaxis(unit, axis, 0)[part] for part in (slice(1, None), slice(None, -1)))
            cosine += float(np.real(later * np.conj(earlier)).sum())
            weight += float((np.abs(later) * np.abs(earlier)).sum())
        return cosine / max(weight, 1e-300)

    @property
    def harmonics(self) -> tuple[float, float]:
        """Second and third harmonic over the first: of the light as it is where they are small, else after an exponent.

        The exponent is the one that makes the second least; it takes nine times as long.
        """
        second, third = self._harmonics(self.light[..., None])
        if abs(second) < _SMALL * _SECOND and abs(third) < _SMALL * _THIRD:
            return second, third
        brightness = np.log(np.maximum(self.light / (self.light.max() or 1.0), 1e-6))[..., None]
        return self._harmonics(np.exp(brightness * _EXPONENTS.astype(np.float32)))

    def _harmonics(self, images: np.ndarray) -> tuple[float, float]:
        """Of the one of images [rows, columns, pixels, k] whose second is least; 0 without fringes."""
        _, by_cosines, amplitude = self.waves
        phase = self.phase + np.angle(amplitude).astype(np.float32)[..., None]
        _, coefficients = self._least_squares(images, [np.cos(k * phase) for k in (1, 2, 3)])
        first, second, third = ((by_cosines[..., None] * coefficients[..., k, :]).sum(axis=(0, 1)) for k in (3, 4, 5))
        if not np.all(first > 0):  # no fringes, whose harmonics could be told
            return 0.0, 0.0
        second, third = second / first, third / first
        least = int(np.argmin(np.abs(second)))
        return float(second[least]), float(third[least])

    def _least_squares(self, light: np.ndarray, waves: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Sums of squares that planes and waves leave of images [rows, columns, pixels, k] per tile, and their numbers.

        Images are taken about their tile's mean: it would drown the fringes in single precision.
        """
        planes = np.broadcast_to(self.plane, (*self.used.shape, 3))
        design = np.concatenate([planes, *(wave[..., None] for wave in waves)], axis=3)
        used = self.used[..., None]
        count = np.maximum(used.sum(axis=2, keepdims=True), 1.0)
        light = light - (used * light).sum(axis=2, keepdims=True) / count
        weighed = np.swapaxes(design * used, 2, 3)
        normal = (weighed @ design).astype(float) + 1e-6 * count * np.eye(design.shape[3])
        right = (weighed @ light).astype(float)
        coefficients = np.linalg.solve(normal, right)
        square = (used * light**2).sum(axis=2, dtype=float)
        return np.maximum(square - (coefficients * right).sum(axis=2), 0.0), coefficients


def _cut(table: np.ndarray, size: int) -> np.ndarray:
    """A table cut into tiles of `size` to a side [rows, columns, pixels]; what is left at the far edges is cut off."""
    rows, columns = (n // size for n in table.shape)
    tiles = table[: rows * size, : columns * size].reshape(rows, size, columns, size)
    return tiles.transpose(0, 2, 1, 3).reshape(rows, columns, size**2)


def median(values: np.ndarray) -> float:
    """The middle one of values, the upper one of an even number: in a third of the time that both take."""
    middle = values.size // 2
    return float(np.partition(values, middle, axis=None)[middle]) if values.size else float("nan")


def noise_variance(image: np.ndarray, mask: np.ndarray) -> float:
    """Variance of a pixel's noise, from differences of four neighbours: whatever is smooth drops out."""
    four = image[1:, 1:] - image[1:, :-1] - image[:-1, 1:] + image[:-1, :-1]
    unmasked = mask[1:, 1:] & mask[1:, :-1] & mask[:-1, 1:] & mask[:-1, :-1]
    if unmasked.sum() < 16:
        return 0.0
    return float(1.4826 * median(np.abs(four[unmasked]))) ** 2 / 4
