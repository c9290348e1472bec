"""NAME=VALUE at the shell, in the unit that the name has."""

from collections.abc import Callable
from typing import Any

from fitting.shell import lamps, quantities

# Numbers that are lengths, among those that a chain takes priors of.
_LENGTHS = ("radius", "wavelength", "pixel_size", "contact_radius")
# Those that a chain draws, and a fit takes no prior of.
OF_CHAIN = (
    *_LENGTHS,
    "gap_index",
    "fringe_scale_per_px2",
    "centre_x_px",
    "centre_y_px",
    "contact_radius_px",
    "gap_turns",
)
# An assignment as it may be, by option.
_EXAMPLES = {
    "--vary": "wavelength=400nm:700nm",
    "--sd": "wavelength=0.1nm",
    "--choose": "wavelength=532nm,589.3nm",
    "--fix": "gap=0nm",
    "--start": "radius=1m",
}
# Numbers of `fitting.fit` whose names there have a unit.
_ARGUMENTS = {"centre": "centre_px", "fringe_scale": "fringe_scale_per_px2"}


def pairs(option: str, texts: list[str]) -> list[tuple[str, str]]:
    """(name, what it is given) of each text; several names may stand in one, with spaces between."""
    assignments = []
    for text in (part for group in texts for part in group.split()):
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise ValueError(f"{option} {text!r}: give NAME=..., such as {_EXAMPLES[option]}")
        assignments.append((name.replace("-", "_"), value))
    if twice := {name for name, _ in assignments if [n for n, _ in assignments].count(name) > 1}:
        raise ValueError(f"{option} names {sorted(twice)[0]} twice; give it once")
    return assignments


def span(name: str, text: str, units: dict[str, str]) -> tuple[float, float]:
    """LOW:HIGH."""
    low, colon, high = text.partition(":")
    if not colon:
        raise ValueError(f"{name}={text}: give LOW:HIGH, such as 400nm:700nm")
    return number(name, low, units), number(name, high, units)


def number(name: str, text: str, units: dict[str, str]) -> float:
    """A number in the unit that its name has. Raises ValueError for names and texts that are none."""
    if name not in units:
        raise ValueError(f"{name!r} is not a number of this scene; allowed: {', '.join(units)}")
    if name == "wavelength":
        return lamps.wavelength(text).given
    if units[name] == "m":
        return quantities.length(text)
    if units[name] == "rad":
        return quantities.angle(text)
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{name}={text}: give a plain number{f' of {units[name]}' if units[name] else ''}") from None


def deviations(texts: list[str], units: dict[str, str]) -> dict[str, float | str]:
    """Standard deviations by name: in the unit of the number, or as a percentage of it."""
    return {name: text if text.endswith("%") else number(name, text, units) for name, text in pairs("--sd", texts)}


def priors(texts: list[str]) -> dict[str, tuple[float, float | str]]:
    """(value, standard deviation) by name, of NAME=VALUE:SD; a deviation may be a percentage of its value."""
    stated = {}
    for text in (part for group in texts for part in group.split()):
        name, _, pair = text.partition("=")
        value, colon, sd = pair.partition(":")
        name = name.strip().replace("-", "_")
        if not (name and colon):
            raise ValueError(f"--prior {text!r}: give NAME=VALUE:SD, such as distortion=0:0.02")
        if name in stated:
            raise ValueError(f"--prior names {name} twice; give it once")
        try:
            is_length = name in _LENGTHS
            read, read_sd = (
                (quantities.length, quantities.length_sd) if is_length else (quantities.number, quantities.number_sd)
            )
            stated[name] = read(value), read_sd(sd)
        except ValueError as error:
            raise ValueError(f"--prior {text!r}: {error}") from None
    return stated


def place(text: str) -> tuple[float, float]:
    """X,Y in pixels. Raises ValueError for what is no pair of numbers."""
    x, comma, y = text.partition(",")
    if not comma:
        raise ValueError(f"{text!r}; give X,Y in pixels, such as 640,480")
    return quantities.number(x), quantities.number(y)


def noise(text: str) -> str | tuple[float, float]:
    """Words for the noise, or FULL_WELL,READ_NOISE in photoelectrons. Raises ValueError for anything else."""
    if text in ("estimated", "shot"):
        return text
    full_well, comma, read_noise = text.partition(",")
    if not comma:
        raise ValueError(f"{text!r}; give estimated, shot, or FULL_WELL,READ_NOISE in photoelectrons, such as 10000,3")
    return quantities.number(full_well), quantities.number(read_noise)


def held(texts: list[str]) -> dict[str, Any]:
    """What a fit holds, by the names of `fitting.fit`, of gap=LENGTH and centre=X,Y."""
    return _named("--fix", texts, {"gap": quantities.length})


def start(texts: list[str]) -> dict[str, Any]:
    """What a fit starts from, of centre=X,Y with radius=LENGTH or fringe-scale=NUMBER [per px²]."""
    readers = {"radius": quantities.positive_length, "fringe_scale": quantities.number}
    values = _named("--start", texts, readers)
    if "centre_px" not in values or len(values) != 2:
        raise ValueError(f"--start is {', '.join(texts)}; give centre=X,Y, and radius=LENGTH or fringe-scale=NUMBER")
    return values


def _named(option: str, texts: list[str], readers: dict[str, Callable[[str], Any]]) -> dict[str, Any]:
    readers = {"centre": place, **readers}
    values = {}
    for name, text in pairs(option, texts):
        if name not in readers:
            allowed = ", ".join(name.replace("_", "-") for name in readers)
            raise ValueError(f"{option} names {name!r}; allowed: {allowed}")
        try:
            values[_ARGUMENTS.get(name, name)] = readers[name](text)
        except ValueError as error:
            raise ValueError(f"{option} {name}={text}: {error}") from None
    return values
