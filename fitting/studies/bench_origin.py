"""Where the result of a study comes from: the bench as a scene file, and what was asked of it."""

import functools
import inspect
from collections.abc import Callable
from dataclasses import replace
from typing import Any, ParamSpec, TypeVar

from fitting.parameters import AbstractResult, origin_of
from newtonjax.benches import scene_text
from newtonjax.numerics import shown

Result = TypeVar("Result", bound=AbstractResult)
Arguments = ParamSpec("Arguments")


def says_its_bench(study: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """A study whose result says of which scene and camera it is, by the hash of their TOML, and what else was given.

    So do those that it calls `so_far` with.
    """
    signature = inspect.signature(study)

    @functools.wraps(study)
    def with_origin(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        def with_own(result: Result) -> Result:
            arguments = signature.bind(*args, **kwargs).arguments
            data = scene_text(arguments.pop("scene"), arguments.pop("camera")).encode()
            return replace(result, origin=origin_of(data, arguments))  # pyright: ignore[reportArgumentType]  # a dataclass

        so_far: Any = kwargs.get("so_far")
        if so_far is not None:
            if not callable(so_far):
                raise ValueError(f"so_far is {shown(so_far)}; allowed: a function of the result so far, or None")
            kwargs["so_far"] = lambda result: so_far(with_own(result))
        return with_own(study(*args, **kwargs))

    return with_origin
