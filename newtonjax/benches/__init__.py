"""Ready scenes, and scenes in TOML files."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
