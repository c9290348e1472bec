"""Whether the lamp of a line has further lines that a channel of a colour photograph sees, and what they do."""

from typing import Any

from fitting.colour import ColourReason, lamp_of_line, lines_of
from fitting.photo import Rings, read_channels
from fitting.photograph.colours import fringe_scale, measured_under, with_light
from fitting.photograph.light_words import LampLight
from fitting.photograph.rival import Finding
from fitting.photograph.task import Task
from newtonjax.scene import lamp

# A relative change of the fringe scale below this is not spoken of.
_LEAST = 2e-3
NAME = "further lines"


def further_lines(task: Task, rings: Rings, arguments: dict[str, Any], scale: float) -> Finding | None:
    """What a fit of all channels under the lamp says of the fringe scale that one line gave.

    `scale`: of that fit [turns per px²]. The channel of a camera without a filter sees the lines beside the one that is
    given; their beats move the rings' phase. Light that is no named lamp's, or of one line, has none of it.
    """
    wavelength = task.quantities.given.get("wavelength")
    is_colour = task.photograph.channel in ("red", "green", "blue")
    if task.scene is not None or wavelength is None or not is_colour:
        return None
    if (name := lamp_of_line(wavelength)) is None:
        return None
    light = LampLight(lines_of(lamp(name)))
    source, transfer, mask, page = (arguments[key] for key in ("image", "transfer", "mask", "page"))
    photographs = with_light(read_channels(source, transfer, mask, page))
    fit = measured_under(task, rings, photographs, light)
    change = abs(fringe_scale(fit, light) * light.reference / wavelength / scale - 1)
    if not change > _LEAST:
        return None
    words = ColourReason.FURTHER_LINES(lamp=name, change=change)
    return Finding(NAME, change, _LEAST, "warning", words, change)
