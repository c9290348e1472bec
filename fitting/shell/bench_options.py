"""Options of the shell for the arguments of the ready benches, made of their table."""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Annotated, Any

from fitting.shell import lamps, quantities
from fitting.shell.options import option
from newtonjax.benches import ARGUMENTS, Argument

# What only the shell reads, after the help of a kind.
_ALSO = {"wavelength": " Or a line such as sodium.", "names": " As in direct,R2-R1 or R1,R2,R3."}
# The scenes of the verb `render` that are ready benches. A view is named instead of its bench.
SCENES = {"transmitted": "newton_rings", "reflected": "newton_rings", "wedge": "air_wedge"}
_METAVARS = {
    "length": "LENGTH", "wavelength": "LENGTH|LINE", "screen": "LENGTH|gap", "angle": "ANGLE", "angles": "ANGLE,ANGLE",
    "index": "NUMBER", "fraction": "NUMBER", "names": "NAMES",
}  # fmt: skip


def option_name(argument: str) -> str:
    """The option of an argument: `--lens-thickness` of `lens_thickness`."""
    return f"--{argument.replace('_', '-')}"


def arguments_of_scene(scene: str) -> tuple[str, ...]:
    """Names of the arguments that the verb offers for a ready bench."""
    return tuple(item.name for item in _OFFERED.values() if SCENES[scene] in item.benches)


def with_bench_options(verb: Callable[..., int]) -> Callable[..., int]:
    """The verb with an option for every bench argument where it has the parameter `bench`: a mapping of what was given.

    An option is None, and not in the mapping, where it is not given.
    """

    @wraps(verb)
    def with_options(**options: Any) -> int:
        values = {name: options.pop(name) for name in _OFFERED}
        return verb(bench={name: value for name, value in values.items() if value is not None}, **options)

    parameters = []
    for parameter in inspect.signature(verb).parameters.values():
        parameters += map(_parameter, _OFFERED.values()) if parameter.name == "bench" else [parameter]
    vars(with_options).update(
        __signature__=inspect.Signature(parameters, return_annotation=int),
        __annotations__={parameter.name: parameter.annotation for parameter in parameters} | {"return": int},
    )
    return with_options


def _parameter(argument: Argument) -> inspect.Parameter:
    what = argument.help + _ALSO.get(argument.kind, "")
    read = option(_reader(argument), _METAVARS[argument.kind], what, argument.shown)
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    return inspect.Parameter(argument.name, kind, default=None, annotation=Annotated[Any, read])


def _reader(argument: Argument) -> Callable[[str], Any]:
    """From the text of an option to a value in SI units."""
    if argument.kind == "length":
        return quantities.positive_length if argument.test in ("wavelength", "thickness") else quantities.length
    readers = {
        "wavelength": lamps.wavelength,
        "screen": _screen,
        "angle": quantities.angle,
        "angles": _angles,
        "index": _number,
        "fraction": _number,
        "names": lambda text: tuple(text.split(",")),
    }
    return readers[argument.kind]


def _screen(text: str) -> float | str:
    return "gap" if text == "gap" else quantities.length(text)


def _angles(text: str) -> tuple[float, float]:
    texts = text.split(",")
    if len(texts) != 2:
        raise ValueError(f"{text!r}; give two angles, about x and about y, such as 1mrad,0deg")
    return quantities.angle(texts[0]), quantities.angle(texts[1])


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{text!r} is not a number; give one without a unit, such as 1.5") from None


# By name; a view is the scene's name.
_OFFERED = {item.name: item for item in ARGUMENTS if item.kind != "view"}
