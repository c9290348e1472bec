"""Checks of what a bench is called with, by the table of arguments."""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec

import numpy as np

from newtonjax.benches.arguments import Argument, arguments_of, refuse_old_names
from newtonjax.numerics import finite, is_concrete, is_real, require, require_pair, shown
from newtonjax.scene import (
    DISTANCE,
    HEIGHT,
    INDEX,
    RADIUS,
    THICKNESS,
    TILT,
    WAVELENGTH,
    Coating,
    Scene,
    Spectrum,
    refractive_index,
)

_Parameters = ParamSpec("_Parameters")
_TESTS = {
    "finite": finite,
    # A plane has no end of a radius.
    "radius": lambda value: RADIUS.holds(np.abs(value)) | np.isinf(value),
    "wavelength": WAVELENGTH.holds,
    "index": INDEX.holds,
    "height": HEIGHT.holds,
    "thickness": THICKNESS.holds,
    "tilt": TILT.holds,
    "tilts": TILT.holds,
    "radius_of_source": lambda value: TILT.holds(value) & (value >= 0),
    "aperture": lambda value: (value >= 0) & (value < 2),
    "lamp": lambda value: THICKNESS.holds(value) | (value == 0),
    "screen": DISTANCE.holds,
    "fraction": lambda value: (value >= 0) & (value <= 1),
}


def checked(bench: Callable[_Parameters, Scene]) -> Callable[_Parameters, Scene]:
    """The bench, which refuses arguments that no bench can have in one line; traced values pass."""
    signature, table = inspect.signature(bench), {item.name: item for item in arguments_of(bench.__name__)}

    @wraps(bench)
    def with_checks(*args: _Parameters.args, **kwargs: _Parameters.kwargs) -> Scene:
        refuse_old_names(bench.__name__, kwargs)
        for name, value in signature.bind(*args, **kwargs).arguments.items():
            _check(table[name], value)
        if kwargs.get("light") is not None and not _is_default(table["wavelength"], signature, args, kwargs):
            raise ValueError("wavelength and light are both given; allowed: one of them")
        return bench(*args, **kwargs)

    return with_checks


def _is_default(argument: Argument, signature: inspect.Signature, args, kwargs) -> bool:
    """Whether an argument is not given, or as it would be then."""
    value = signature.bind(*args, **kwargs).arguments.get(argument.name, argument.default)
    return is_concrete(value) and value == argument.default


def _check(argument: Argument, value) -> None:
    if value is None and argument.default is None:
        return
    if value is None or isinstance(value, bool):
        raise _refusal(argument, value)
    if argument.test in ("tilts", "angles"):
        require_pair(argument.name, value)
        if argument.test == "tilts":
            require(argument.name, value, argument.allowed, _TESTS["tilts"])
    elif argument.test == "view":
        if not (isinstance(value, str) and value in ("transmitted", "reflected")):
            raise _refusal(argument, value)
    elif argument.test == "light":
        if not isinstance(value, str | Spectrum):
            raise _refusal(argument, value)
    elif argument.test == "terms":
        require(argument.name, value, argument.allowed, finite)
        if np.ndim(value) != 1:
            raise _refusal(argument, value)
    elif argument.test == "index" and isinstance(value, str):
        _check_matter(argument, value)
    elif argument.test == "coating":
        if not isinstance(value, str | Coating):
            raise _refusal(argument, value)
    elif argument.test == "names":
        if value != "all" and not (isinstance(value, tuple | list) and all(isinstance(beam, str) for beam in value)):
            raise _refusal(argument, value)
    elif not (argument.test == "screen" and isinstance(value, str) and value == "gap"):
        if not is_real(value):
            raise _refusal(argument, value)
        if np.ndim(value):
            raise ValueError(f"{argument.name} is {shown(value)}; allowed: one number; vmap over several")
        require(argument.name, value, argument.allowed, _TESTS[argument.test])


def _check_matter(argument: Argument, name: str) -> None:
    """Raise ValueError for a name of no matter."""
    try:
        refractive_index(name, 589.3e-9)
    except ValueError as error:
        raise ValueError(f"{argument.name}: {error}") from None


def _refusal(argument: Argument, value) -> ValueError:
    return ValueError(f"{argument.name} is {shown(value)}; allowed: {argument.allowed}")
