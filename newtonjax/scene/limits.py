"""What can be meant by a number of a bench or of a photograph: beyond these limits a unit was mistaken.

One table for scenes, benches, TOML files, the shell, fits and ring tables. Few imports: the shell's `--help` reads it.
"""

from typing import Any, NamedTuple


class Limit(NamedTuple):
    """The smallest and the largest size that can be meant, in SI units, and what both are called in a message."""

    low: float
    high: float
    words: str

    def holds(self, values: Any) -> Any:
        """Whether numbers lie between both, one by one; NaN does not."""
        return (values >= self.low) & (values <= self.high)


RADIUS = Limit(1e-5, 1e5, "10 um to 100 km (in metres)")
WAVELENGTH = Limit(1e-8, 1e-3, "10 nm to 1 mm in vacuum (in metres)")
PIXEL_SIZE = Limit(1e-9, 1e-1, "1 nm to 10 cm (in metres)")
INDEX = Limit(0.1, 10.0, "0.1 to 10")
# Of glass, its distance and its height: more than a nanometre where it cannot be 0.
THICKNESS = Limit(1e-9, 100.0, "1 nm to 100 m (in metres)")
HEIGHT = Limit(-100.0, 100.0, "-100 to 100 m")
DISTANCE = Limit(-1e5, 1e5, "up to 100 km (in metres)")
# Of surfaces, against the bench's axis: 45 degrees.
TILT = Limit(-0.7853982, 0.7853982, "below 45 degrees, 0.7854 rad, in size")
# Of every pixel, as a standard deviation in incident irradiance.
NOISE = Limit(1e-12, 1e6, "1e-12 to 1e6")
# Pixels of a picture file: cameras have up to 150 million, and a small file may say that it holds any number.
PICTURE_PIXELS = 2e8
# A standard deviation over its value: a number that is less well known is not known.
RELATIVE_SD = 0.25
