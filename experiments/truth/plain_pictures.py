"""Made pictures of plain Newton's rings: with noise alone, with a laboratory's ordinary defects, and as JPEG."""

import numpy as np
from scipy import ndimage

from experiments.truth.ring_field import RingField, compressed, light_of
from experiments.truth.rival_pictures import RivalPicture

ORDINARY = ("vignette", "dust", "tilt", "distortion", "camera curve", "scratches")
# Without a pixel size the scale of a distorted picture is that of its mean, not of its middle: these have none.
UNSCALED = 4  # one picture in so many
# A camera's blur takes light from beyond its frame; a filter mirrors the edge, which moves rings by up to three
# standard deviations: so many pixels are cut off.
_RIM = 3


def jpeg_50(seed: int) -> RivalPicture:
    """Plain rings, saved as a JPEG of quality 50."""
    field = RingField(np.random.default_rng([seed, 50, 73]))
    return RivalPicture(compressed(field.noisy(field.rings()), 50), 50.0, field.radius)


def on_model(seed: int) -> RivalPicture:
    """Plain rings with noise alone."""
    field = RingField(np.random.default_rng([seed, 79]))
    return RivalPicture(field.noisy(field.rings()), 0.0, field.radius)


def ordinary(seed: int) -> RivalPicture:
    """Plain rings with two of the defects that every laboratory has."""
    rng = np.random.default_rng([seed, 83])
    field, defects = RingField(rng), rng.choice(ORDINARY, 2, replace=False)
    defects = [defect for defect in defects if seed % UNSCALED or defect != "distortion"]
    if "distortion" in defects:
        factor = 1 + rng.uniform(-0.02, 0.02) * (field.u**2 + field.v**2) / 2
        rows, columns = field.x.shape
        field.x = (columns - 1) / 2 + (field.x - (columns - 1) / 2) * factor
        field.y = (rows - 1) / 2 + (field.y - (rows - 1) / 2) * factor
    along, across = field.along()
    tilt = np.cos(np.radians(rng.uniform(2, 8))) if "tilt" in defects else 1.0
    light = light_of(field.orders * (along**2 / tilt + across**2 * tilt) + field.start)
    if "vignette" in defects:
        light *= 1 - rng.uniform(0.1, 0.5) * (field.u**2 + field.v**2) / 2
    if "dust" in defects:
        for _ in range(20):
            at, size = rng.uniform(0, 1, 2) * field.u.shape[::-1], rng.uniform(1, 4)
            light[(field.x - at[0]) ** 2 + (field.y - at[1]) ** 2 < size**2] *= 0.4
    if "scratches" in defects:
        for _ in range(3):
            angle, place = rng.uniform(0, np.pi), rng.uniform(-0.7, 0.7)
            light[np.abs(np.cos(angle) * field.u + np.sin(angle) * field.v - place) < 0.006] *= 1.3
    light = field.noisy(light)
    if "camera curve" in defects:
        light = ndimage.gaussian_filter(np.maximum(light, 0), 0.5)[_RIM:-_RIM, _RIM:-_RIM]
        light = light ** (1 / rng.uniform(1.0, 2.2))
    return RivalPicture(light, 0.0, field.radius)
