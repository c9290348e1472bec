"""The verb `scale`: the pixel size from a ruled grid, or from two points."""

from fitting.reticle.measuring import scale as scale
from fitting.reticle.result import Scale as Scale
