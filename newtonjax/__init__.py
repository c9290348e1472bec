"""newtonjax: a differentiable simulator of Newton's rings and other fringes of equal thickness."""

from newtonjax.doors import door

_exported, __dir__ = door(__name__)


def __getattr__(name: str):
    if name == "__version__":
        from importlib.metadata import version  # 20 ms of every start

        return version("newtonjax")
    return _exported(name)
