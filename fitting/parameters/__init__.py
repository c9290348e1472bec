"""The numbers of a bench and of a photograph by name, and what may be given of them."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
