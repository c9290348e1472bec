"""Rings in the channels of a colour photograph: one geometry, and a waveform of several lines for each channel."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
