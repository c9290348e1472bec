"""The verb `scale`: the pixel size from a ruled grid."""

from fitting.reticle.lattice import scale as scale
from fitting.reticle.result import Scale as Scale
