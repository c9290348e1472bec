"""Options of the shell for the arguments of the ready benches, made of their table."""

import inspect
from collections.abc import Callable
from typing import Annotated, Any

from fitting.shell import lamps, quantities
from fitting.shell.options import expanded, option, parameter_of
from newtonjax.benches import ARGUMENTS, Argument

# What only the shell reads, after the help of a kind.
_ALSO = {"wavelength": " Or a line such as sodium.", "names": " As in direct,R2-R1 or R1,R2,R3."}
# The scenes of the verb `render` that are ready benches. A view is named instead of its bench.
SCENES = {"transmitted": "newton_rings", "reflected": "newton_rings", "wedge": "air_wedge"}
_METAVARS = {
    "length": "LENGTH", "wavelength": "LENGTH|LINE", "light": "LAMP", "screen": "LENGTH|gap",
    "angle": "ANGLE", "angles": "ANGLE,ANGLE",
    "index": "NUMBER|NAME", "fraction": "NUMBER", "names": "NAMES", "number": "NUMBER", "terms": "NUMBERS",
    "heights": "LENGTHS", "coating": "LAYERS",
}  # fmt: skip


def option_name(argument: str) -> str:
    """The option of an argument: `--lens-thickness` of `lens_thickness`."""
    return f"--{argument.replace('_', '-')}"


def arguments_of_scene(scene: str) -> tuple[str, ...]:
    """Names of the arguments that the verb offers for a ready bench."""
    return tuple(item.name for item in _OFFERED.values() if SCENES[scene] in item.benches)


def with_bench_options(verb: Callable[..., int]) -> Callable[..., int]:
    """The verb with an option for every argument of a bench."""
    return expanded(verb, "shape", [_parameter(argument) for argument in _OFFERED.values()])


def _parameter(argument: Argument) -> inspect.Parameter:
    what = argument.help + _ALSO.get(argument.kind, "")
    read = option(_reader(argument), _METAVARS[argument.kind], what, argument.shown, "Bench")
    return parameter_of(argument.name, Annotated[Any, read])


def _reader(argument: Argument) -> Callable[[str], Any]:
    """From the text of an option to a value in SI units."""
    if argument.kind == "length":
        return quantities.positive_length if argument.test in ("wavelength", "thickness") else quantities.length
    readers = {
        "wavelength": lamps.wavelength,
        "light": lamps.light,
        "coating": _coating,
        "screen": _screen,
        "angle": quantities.angle,
        "angles": _angles,
        "index": _index,
        "fraction": quantities.number,
        "number": quantities.number,
        "terms": lambda text: tuple(map(quantities.number, text.split(","))),
        "heights": lambda text: tuple(map(quantities.length, text.split(","))),
        "names": lambda text: text if text == "all" else tuple(text.split(",")),
    }
    return readers[argument.kind]


def _coating(text: str) -> str:
    """The words for a coating, checked. Raises ValueError, in one line, for what names none."""
    from newtonjax.scene import coating  # JAX, which the help does without

    coating(text)
    return text


def _index(text: str) -> float | str:
    """A refractive index, or the name of some matter, checked. Raises ValueError, in one line, for what is neither."""
    if text[:1].isdigit() or text[:1] in ".+-":
        return quantities.number(text)
    from newtonjax.scene import refractive_index  # JAX, which the help does without

    refractive_index(text, 589.3e-9)
    return text


def _screen(text: str) -> float | str:
    return "gap" if text == "gap" else quantities.length(text)


def _angles(text: str) -> tuple[float, float]:
    texts = text.split(",")
    if len(texts) != 2:
        raise ValueError(f"{text!r}; give two angles, about x and about y, such as 1mrad,0deg")
    return quantities.angle(texts[0]), quantities.angle(texts[1])


# By name; a view is the scene's name.
_OFFERED = {item.name: item for item in ARGUMENTS if item.kind != "view"}
