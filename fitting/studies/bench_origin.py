"""Where the result of a study comes from: the bench as a scene file, and what was asked of it."""

import functools
import inspect
from collections.abc import Callable
from dataclasses import replace
from typing import ParamSpec, TypeVar

from fitting.parameters import AbstractResult, origin_of
from newtonjax.benches import scene_text

Result = TypeVar("Result", bound=AbstractResult)
Arguments = ParamSpec("Arguments")


def says_its_bench(study: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """A study whose result says of which scene and camera it is, by the hash of their TOML, and what else was given."""
    signature = inspect.signature(study)

    @functools.wraps(study)
    def with_origin(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        result = study(*args, **kwargs)
        arguments = signature.bind(*args, **kwargs).arguments
        data = scene_text(arguments.pop("scene"), arguments.pop("camera")).encode()
        return replace(result, origin=origin_of(data, arguments))  # pyright: ignore[reportArgumentType]  # a dataclass

    return with_origin
