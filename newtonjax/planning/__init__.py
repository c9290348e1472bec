"""Which way to an image, and what it costs."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
