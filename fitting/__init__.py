"""fitting: the layer that turns an image of rings into a lens radius with a standard deviation."""

from importlib import import_module

_HOME = {
    "Chain": "chain",
    "Design": "designs",
    "FitResult": "result",
    "FrameFit": "frame_fit",
    "Information": "fisher",
    "Parameter": "result",
    "RingsResult": "rings_result",
    "Sensitivity": "sensitivities",
    "Spread": "sobol",
    "design": "designs",
    "fit": "measure",
    "fit_stack": "stack",
    "information": "fisher",
    "measurement": "implicit",
    "read": "photo",
    "result_figure": "plot",
    "rings": "orders",
    "rings_figure": "line_plot",
    "sample": "mcmc",
    "sensitivity": "sensitivities",
    "scale": "reticle",
    "spread": "sobol",
    "Scale": "scale_result",
}

__all__ = sorted(_HOME)  # pyright: ignore[reportUnsupportedDunderAll]  # lazy exports: one table names them


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'fitting' has no attribute {name!r}; it has {', '.join(__all__)}")
    return getattr(import_module(f"fitting.{_HOME[name]}"), name)


def __dir__():
    return sorted({*globals(), *__all__})
