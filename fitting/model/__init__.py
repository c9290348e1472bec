"""From numbers to the phase of the fringes."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
