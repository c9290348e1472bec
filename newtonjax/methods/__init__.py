"""Ways to an image, each with what it honours and what it errs by."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
