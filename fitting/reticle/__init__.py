"""The verb `scale`: the pixel size from a ruled grid."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
