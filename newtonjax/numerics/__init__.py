"""Arrays and numbers: nothing of optics."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
