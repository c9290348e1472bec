"""Rings in the channels of a colour photograph: one geometry, and for each channel the waveform of its light."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
