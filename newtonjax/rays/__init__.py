"""One ray, one beam, one point of the screen."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
