"""What stands on the bench: surfaces, light, screen, camera, and the beams between them."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
