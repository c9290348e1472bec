"""What a user calls on a scene and a camera."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
