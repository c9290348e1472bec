"""Smooth fields at points, and sums of them over the pixels of an image."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
