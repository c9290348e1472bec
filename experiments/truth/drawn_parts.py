"""What a camera and a bench do to rings, drawn at random from the priors that an answer's budget goes by, in NumPy.

Each set of warps is as likely as any other, as in `fitting.photograph.averaging`, and each number of a part is normal
as its prior says. So are the lens's index and thickness (1.5 +- 0.1, 5 mm +- 50 %), and the gap is up to the 5 um of
`fitting.photograph.uncertainty`. The formulae are those of `fitting.model`, written again. A contact, which a search
finds, has no prior size and is never drawn.
"""

from typing import NamedTuple

import numpy as np

from fitting.model import PARTS, PRIORS, WARPS, numbers_of
from fitting.photograph.averaging import sets_of

# A gap that dust holds open, and a lens [m].
_WIDEST, _THINNEST = 5e-6, 0.5e-3


class DrawnParts(NamedTuple):
    """Parts by name, and their numbers by name; a number that is not there is 0.

    `gap` [m] at the apex; `glass`: index and thickness [m] of the lens.
    """

    names: tuple[str, ...]
    numbers: dict[str, float]
    gap: float
    glass: dict[str, float]

    def of(self, *names: str) -> list[float]:
        """Numbers by name."""
        return [self.numbers.get(name, 0.0) for name in names]


def draw_parts(seed: int) -> DrawnParts:
    """A set of parts, and its numbers from their priors."""
    rng = np.random.default_rng([seed, 23])
    sets = sets_of(WARPS)
    parts = sets[rng.integers(len(sets))]
    names = tuple(part for part in PARTS if part in parts)
    numbers = {name: float(rng.normal(*PRIORS[name])) for name in numbers_of(names)}
    thickness = max(5e-3 * (1 + 0.5 * rng.normal()), _THINNEST)
    glass = {"lens_index": 1.5 + 0.1 * rng.normal(), "lens_thickness": thickness}
    return DrawnParts(names, numbers, rng.uniform(0, _WIDEST), glass)


def view_of(parts: DrawnParts) -> float:
    """Cosine of the angle between the view and the normal."""
    stretch, shear = parts.of("stretch", "shear")
    return float(np.exp(-np.hypot(stretch, shear)))


def squared_distance(parts: DrawnParts, size: int, centre: tuple[float, float], x, y) -> np.ndarray:
    """On the object, from the rings' centre [px²], of pixels of a square picture."""
    half = (size - 1) / 2
    unit = np.hypot(half, half)
    kappa, fifth, axis_x, axis_y = parts.of("distortion", "distortion_fifth_order", "axis_x", "axis_y")

    def on_object(px, py, most):
        ux, uy = (px - half) / unit - axis_x, (py - half) / unit - axis_y
        u2 = np.minimum(ux**2 + uy**2, most)
        factor = unit * (1 + kappa * u2 + fifth * u2**2)
        return ux * factor, uy * factor

    # Nothing is known of a lens beyond the frame.
    from_x, from_y = on_object(*centre, 1.0)
    at_x, at_y = on_object(x, y, np.inf)
    dx, dy = at_x - from_x, at_y - from_y
    stretch, shear = parts.of("stretch", "shear")
    azimuth, cosine = np.arctan2(shear, stretch) / 2, view_of(parts)
    along, across = np.cos(azimuth) * dx + np.sin(azimuth) * dy, np.cos(azimuth) * dy - np.sin(azimuth) * dx
    return (along / cosine) ** 2 + across**2


def form_turns(parts: DrawnParts, size: int, centre: tuple[float, float], x, y) -> np.ndarray:
    """What the lens's form adds to the phase [turns]: waves about the rings' centre, over the furthest corner's."""
    corners = np.array([0, size - 1, (size - 1) * 1j, (size - 1) * (1 + 1j)])
    middle = centre[0] + 1j * centre[1]
    z = (x + 1j * y - middle) / np.abs(corners - middle).max()
    waves = {
        "coma": np.abs(z) ** 2 * z,
        "trefoil": z**3,
        "astigmatism": np.abs(z) ** 2 * z**2,
        "tetrafoil": z**4,
    }
    turns = np.zeros(np.shape(z))
    for name, wave in waves.items():
        along_x, along_y = parts.of(f"{name}_x", f"{name}_y")
        turns = turns + along_x * wave.real + along_y * wave.imag
    return turns
