"""From a file to light, mask and block means; and rings in it without a start, and what speaks for them."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
