"""Least squares on block means: sums, illumination, outliers."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
