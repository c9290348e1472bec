"""newtonjax: a differentiable simulator of Newton's rings and other fringes of equal thickness."""

from importlib import import_module
from importlib.metadata import version

# Exported lazily: the shell answers --help without importing JAX.
_HOME = {
    "Beam": "beams",
    "Blocks": "row_blocks",
    "Camera": "camera",
    "Chebyshev": "methods",
    "ClosedForm": "methods",
    "CollectingLens": "imaging",
    "Light": "light",
    "Plan": "planning",
    "Scene": "scene",
    "Shield": "imaging",
    "Splat": "splatting",
    "Surface": "surfaces",
    "Traced": "methods",
    "air_wedge": "benches",
    "blocks": "row_blocks",
    "choose_beams": "scene",
    "cos_turns": "turns",
    "Explanation": "explaining",
    "Omission": "explaining",
    "enumerate_beams": "beams",
    "explain": "explaining",
    "load_scene": "files",
    "meeting_height": "localization",
    "NormalEquations": "normal",
    "newton_rings": "benches",
    "normal_equations": "normal",
    "opd": "rendering",
    "plan": "planning",
    "render": "rendering",
    "save_scene": "files",
    "sin_turns": "turns",
    "splat": "splatting",
    "sweep": "sweeping",
    "spread": "splatting",
}

__all__ = sorted(_HOME)  # pyright: ignore[reportUnsupportedDunderAll]  # lazy exports: one table names them
__version__ = version("newtonjax")


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'newtonjax' has no attribute {name!r}; it has {', '.join(__all__)}")
    return getattr(import_module(f"newtonjax.{_HOME[name]}"), name)


def __dir__():
    return sorted({*globals(), *__all__})
