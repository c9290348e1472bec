"""The command `newtonjax`."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
