"""Files written whole: JSON, PNG, TIFF, HTML."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
