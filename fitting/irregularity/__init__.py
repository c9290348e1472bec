"""The verb `form`: from one picture of fringes to the form of a surface."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
