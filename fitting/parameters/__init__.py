"""The numbers of a bench and of a photograph by name, what may be given of them, and files of results written whole."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
