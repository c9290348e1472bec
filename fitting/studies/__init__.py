"""What an image would determine of a bench: information, sensitivity, spread, speed; the bench that measures best."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
