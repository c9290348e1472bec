"""Checks of what a bench is called with, by the table of arguments."""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec

import numpy as np

from newtonjax.benches.arguments import Argument, arguments_of, refuse_old_names
from newtonjax.numerics import finite, positive, require, require_pair, shown
from newtonjax.scene import Scene

_Parameters = ParamSpec("_Parameters")
_TESTS = {
    "finite": finite,
    "positive": positive,
    "nonzero": lambda value: np.all((value != 0) & ~np.isnan(value)),
    "steep": lambda value: np.all(np.abs(value) < 1.5),
    "screen": finite,
    "fraction": lambda value: np.all((value >= 0) & (value <= 1)),
}


def checked(bench: Callable[_Parameters, Scene]) -> Callable[_Parameters, Scene]:
    """The bench, which refuses arguments that no bench can have in one line; traced values pass."""
    signature, table = inspect.signature(bench), {item.name: item for item in arguments_of(bench.__name__)}

    @wraps(bench)
    def with_checks(*args: _Parameters.args, **kwargs: _Parameters.kwargs) -> Scene:
        refuse_old_names(bench.__name__, kwargs)
        for name, value in signature.bind(*args, **kwargs).arguments.items():
            _check(table[name], value)
        return bench(*args, **kwargs)

    return with_checks


def _check(argument: Argument, value) -> None:
    if value is None and argument.default is None:
        return
    if value is None or isinstance(value, bool):
        raise _refusal(argument, value)
    if argument.test == "pair":
        require_pair(argument.name, value)
    elif argument.test == "view":
        if not (isinstance(value, str) and value in ("transmitted", "reflected")):
            raise _refusal(argument, value)
    elif argument.test == "names":
        if isinstance(value, str):
            raise _refusal(argument, value)
    elif not (argument.test == "screen" and isinstance(value, str) and value == "gap"):
        require(argument.name, value, argument.allowed, _TESTS[argument.test])


def _refusal(argument: Argument, value) -> ValueError:
    return ValueError(f"{argument.name} is {shown(value)}; allowed: {argument.allowed}")
