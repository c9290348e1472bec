"""Made pictures of twenty kinds of fringes that resemble Newton's, or are Newton's with something over them."""

from dataclasses import dataclass

import numpy as np

from experiments.truth.ring_field import WAVELENGTH, RingField, compressed, light_of

# No lens makes these: an answer is wrong, whatever it says. Of the others the lens's own radius is right: of many beams
# the sphere's, of two systems that of the stronger one, of an astigmatic lens that of the mean curvature.
WITHOUT_RADIUS = ("equidistant circles", "fourth power", "spiral", "saddle", "cylinder")


@dataclass(frozen=True)
class RivalPicture:
    """A picture [rows, columns], how strong the kind's effect is, and the radius that is right [m]; None for none."""

    image: np.ndarray
    strength: float
    radius: float | None


def _equidistant(field: RingField) -> tuple[np.ndarray, float]:
    count = field.drawn(3, 25)
    return light_of(count * field.rho + field.start), count


def _fourth_power(field: RingField) -> tuple[np.ndarray, float]:
    count = field.drawn(3, 20)
    return light_of(count * field.rho**4 + field.start), count


def _spiral(field: RingField) -> tuple[np.ndarray, float]:
    """Arms of one to three turns, half of them around rings, half around equidistant circles."""
    arms = float(field.rng.integers(1, 4))
    law = field.orders * field.rho ** (2 if field.rng.random() < 0.5 else 1)
    return light_of(law + arms * field.azimuth / (2 * np.pi)), arms


def _saddle(field: RingField) -> tuple[np.ndarray, float]:
    along, across = field.along()
    ratio = field.rng.uniform(0.3, 1.0)
    return light_of(field.orders * (along**2 - ratio * across**2) + field.start), ratio


def _cylinder(field: RingField) -> tuple[np.ndarray, float]:
    return light_of(field.orders * field.along()[0] ** 2 + field.start), 1.0


def _many_beams(field: RingField) -> tuple[np.ndarray, float]:
    """Airy's rings of coefficient 0.2 to 200."""
    finesse = field.drawn(0.2, 200.0)
    return 0.1 + 0.8 / (1 + finesse * np.sin(np.pi * field.turns) ** 2), finesse


def _second_system(field: RingField) -> tuple[np.ndarray, float]:
    """Rings of another radius about another centre, 0.1 to 0.9 of the contrast."""
    share, ratio = field.drawn(0.1, 0.9), field.drawn(0.5, 2.0)
    shift = field.rng.uniform(-0.6, 0.6, 2)
    along, across = field.along()
    turns = ratio * field.orders * ((along - shift[0]) ** 2 + (across - shift[1]) ** 2) + field.rng.uniform()
    return 0.5 + 0.4 / (1 + share) * (np.cos(2 * np.pi * field.turns) + share * np.cos(2 * np.pi * turns)), share


def _ghost(field: RingField) -> tuple[np.ndarray, float]:
    """The same rings once more, shifted by 3 to 60 pixels, 0.05 to 0.5 as bright."""
    share, shift = field.drawn(0.05, 0.5), field.drawn(3, 60) / field.unit
    along, across = field.along()
    ghost = light_of(field.orders * ((along - shift) ** 2 + across**2) + field.start)
    return (field.rings() + share * ghost) / (1 + share), share


def _moire(field: RingField) -> tuple[np.ndarray, float]:
    """A grid of lines over the rings, a period of 2.2 to 12 pixels."""
    depth, period = field.drawn(0.05, 0.5), field.drawn(2.2, 12)
    along, _ = field.along()
    return field.rings() * (1 - depth * (0.5 + 0.5 * np.sign(np.cos(2 * np.pi * along * field.unit / period)))), depth


def _astigmatic(field: RingField) -> tuple[np.ndarray, float]:
    """Principal curvatures that differ by 0.5 to 60 % of their mean."""
    share = field.drawn(0.005, 0.6)
    along, across = field.along()
    return light_of(field.orders * ((1 + share / 2) * along**2 + (1 - share / 2) * across**2) + field.start), share


def _wavy(power: int, fold: int):
    def made(field: RingField) -> tuple[np.ndarray, float]:
        size = field.drawn(0.02, 1.0)
        return light_of(field.turns + size * field.rho**power * np.cos(fold * field.azimuth)), size

    return made


def _two_lines(field: RingField) -> tuple[np.ndarray, float]:
    """A second line 0.1 to 3 nm off, 0.2 to 1 as bright, in contact; the wavelength that is given is their mean."""
    distance, share = field.drawn(0.1e-9, 3e-9), field.rng.uniform(0.2, 1.0)
    first, second = (1 + part * distance / WAVELENGTH for part in (share / (1 + share), -1 / (1 + share)))
    wave = np.cos(2 * np.pi * field.turns * first) + share * np.cos(2 * np.pi * field.turns * second)
    return 0.5 + 0.4 * wave / (1 + share), distance * 1e9


def _motion(field: RingField) -> tuple[np.ndarray, float]:
    """Rings that moved by 2 to 12 pixels while the shutter was open."""
    length = field.drawn(2, 12)
    along, across = field.along()
    steps = (np.arange(24) / 24 - 0.48) * length / field.unit
    return np.mean(
        [light_of(field.orders * ((along - s) ** 2 + across**2) + field.start) for s in steps], axis=0
    ), length


def _interlaced(field: RingField) -> tuple[np.ndarray, float]:
    """Every other row is of a later moment: the rings moved by 0.5 to 6 pixels, with the mean in the middle."""
    shift = field.drawn(0.5, 6)
    along, across = field.along()
    halves = np.array([-0.5, 0.5]) * shift / field.unit
    earlier, later = (light_of(field.orders * ((along + half) ** 2 + across**2) + field.start) for half in halves)
    return np.where(np.arange(field.x.shape[0])[:, None] % 2 == 0, earlier, later), shift


def _overexposed(field: RingField) -> tuple[np.ndarray, float]:
    """One half so bright that 0.2 to 0.9 of its fringes' swing is cut off, in eight bits."""
    cut = field.rng.uniform(0.2, 0.9)
    gain = np.where(np.cos(field.angle) * field.u + np.sin(field.angle) * field.v > 0, 1 / (0.9 - 0.8 * cut), 1.0)
    return _coded(field.noisy(field.rings() * gain)), cut


def _jpeg(field: RingField) -> tuple[np.ndarray, float]:
    quality = int(field.rng.integers(30, 96))
    return compressed(field.noisy(field.rings()), quality), quality


def _coded(light: np.ndarray) -> np.ndarray:
    """Eight bits, in which the brightest are cut off."""
    return np.round(255 * np.clip(light, 0, 1)) / 255


def _printed(field: RingField) -> tuple[np.ndarray, float]:
    """One to six lines of text, black or white, and a scale bar with its ticks."""
    light, rows, columns = field.rings(), *field.x.shape
    lines, ink = int(field.rng.integers(1, 7)), float(field.rng.choice([0.0, 1.0]))
    height = int(field.rng.integers(8, 18))
    for _ in range(lines):
        row, column = int(field.rng.integers(0, rows - height)), int(field.rng.integers(0, columns // 2))
        for _ in range(int(field.rng.integers(4, 20))):
            letter = field.rng.random((5, 3)) < 0.6
            glyph = np.kron(letter, np.ones((max(1, height // 5), max(1, height // 6)))) > 0
            part = light[row : row + glyph.shape[0], column : column + glyph.shape[1]]
            part[glyph[: part.shape[0], : part.shape[1]]] = ink
            column += glyph.shape[1] + 2
    row, length = int(rows * field.rng.uniform(0.85, 0.95)), columns // 3
    light[row : row + 3, 10 : 10 + length] = ink
    for tick in range(10, 10 + length, max(6, length // 10)):
        light[row - 5 : row + 3, tick : tick + 2] = ink
    return light, float(lines)


def _crossed(field: RingField) -> tuple[np.ndarray, float]:
    """A dark crosshair of two to six pixels near the middle."""
    width = field.rng.uniform(2, 6)
    light = field.rings()
    x, y = field.rng.uniform(0.35, 0.65, 2) * field.x.shape[::-1]
    lean = field.rng.uniform(-0.1, 0.1)
    off = np.abs(field.x - x - lean * field.y) < width / 2, np.abs(field.y - y + lean * field.x) < width / 2
    return np.where(off[0] | off[1], 0.1 * light, light), width


def _droplets(field: RingField) -> tuple[np.ndarray, float]:
    """Five to forty droplets: lenses that bend the rings, with a dark rim."""
    light, count = field.turns, int(field.rng.integers(5, 41))
    rim = np.ones_like(light)
    for _ in range(count):
        at, size = field.rng.uniform(0, 1, 2) * field.x.shape[::-1], field.drawn(3, 18)
        share = ((field.x - at[0]) ** 2 + (field.y - at[1]) ** 2) / size**2
        light = np.where(share < 1, light + field.rng.uniform(0.2, 2) * (1 - share), light)
        rim = np.where((share < 1) & (share > 0.6), 0.4, rim)
    return light_of(light) * rim, float(count)


_MAKERS = {
    "equidistant circles": _equidistant,
    "fourth power": _fourth_power,
    "spiral": _spiral,
    "saddle": _saddle,
    "cylinder": _cylinder,
    "many beams": _many_beams,
    "second system": _second_system,
    "ghost": _ghost,
    "moire": _moire,
    "astigmatism": _astigmatic,
    "coma": _wavy(3, 1),
    "trefoil": _wavy(3, 3),
    "two lines": _two_lines,
    "motion blur": _motion,
    "interlace": _interlaced,
    "half overexposed": _overexposed,
    "JPEG": _jpeg,
    "text": _printed,
    "crosshair": _crossed,
    "droplets": _droplets,
}
KINDS = tuple(_MAKERS)


def picture(kind: str, seed: int) -> RivalPicture:
    """A picture of one kind: 5 to 20 rings on 256 to 420 pixels a side, noise of 0.5 to 5 % of the white."""
    field = RingField(np.random.default_rng([seed, KINDS.index(kind), 71]))
    light, strength = _MAKERS[kind](field)
    image = light if kind in ("JPEG", "half overexposed") else field.noisy(light)
    return RivalPicture(image, strength, None if kind in WITHOUT_RADIUS else field.radius)
