"""The verb `rings`: radii from tables of ring readings; and `wedge`, from positions of straight fringes."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
