"""fitting: the layer that turns an image of rings into a lens radius with a standard deviation."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
