"""The light of a picture about its pupil, at the size that its fringes need, in the picture's own units."""

from typing import NamedTuple

import numpy as np

from fitting.irregularity.disc import Pupil, reduced
from fitting.irregularity.zernike import at_points, slopes

# What is looked at beyond the rim, as a share of the radius: blur brings light from there.
_MARGIN = 0.06
# Largest and least diameters of a picture that is fitted [px], and pixels that the finest fringe gets.
_LARGEST, _LEAST, _FINEST = 256, 90, 9.0


class LitDisc(NamedTuple):
    """Light about a pupil.

    - `light` [rows, columns], float32; `used` [rows, columns]: the pixels that are fitted.
    - `u` [columns], `v` [rows]: pupil radii; `radius` [px]; `block`: pixels of the picture along the side of a pixel.
    """

    light: np.ndarray
    used: np.ndarray
    u: np.ndarray
    v: np.ndarray
    radius: float
    block: int

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """U and v of the pixels that are used [n]."""
        u, v = np.meshgrid(self.u, self.v)
        return u[self.used], v[self.used]


def lit_disc(image: np.ndarray, usable: np.ndarray, pupil: Pupil, diameter: float, edge: float) -> LitDisc:
    """The disc of a picture [rows, columns], used within `edge` radii, of at most about `diameter` pixels."""
    margin = int(np.ceil(_MARGIN * pupil.radius)) + 2
    rows, columns = (
        slice(max(int(middle - pupil.radius) - margin, 0), max(int(middle + pupil.radius) + margin + 1, 0))
        for middle in (pupil.y, pupil.x)
    )
    circle = Pupil(pupil.x - columns.start, pupil.y - rows.start, pupil.radius)
    # Half of the excess is borne, so that a picture is not halved for a few pixels.
    block = max(int(2.2 * pupil.radius / diameter), 1)
    light, used = reduced(image[rows, columns].astype(float), usable[rows, columns], block)
    circle = circle.reduced(block)
    u = (np.arange(light.shape[1]) - circle.x) / circle.radius
    v = (np.arange(light.shape[0]) - circle.y) / circle.radius
    inside = np.square(v)[:, None] + np.square(u) <= edge**2
    return LitDisc(light.astype(np.float32), inside & used, u, v, circle.radius, block)


def diameter_for(form: np.ndarray) -> float:
    """The diameter at which a form's finest fringe is some pixels wide."""
    angle = np.linspace(0, 2 * np.pi, 90)
    rings = [(r * np.cos(angle), r * np.sin(angle)) for r in (0.5, 0.95)]
    rises = [[at_points(part[: len(form)], u, v) @ form for part in slopes()] for u, v in rings]
    return float(np.clip(2 * _FINEST * max(np.hypot(*rise).max() for rise in rises), _LEAST, _LARGEST))
