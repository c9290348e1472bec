"""From a file to light, mask and block means."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
