"""Rings in a photograph without a start, and what speaks for them."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
