"""What a person types on the page, as arguments of `fit`, as a command for the shell, and as lines of Python."""

import json
import shlex
from collections.abc import Mapping
from typing import Any, NamedTuple

from fitting.parameters import PART_OPTIONS
from fitting.shell.fit_arguments import FitOptions, arguments_of
from fitting.shell.manifest import options_with

# Files that the repeating commands read, beside the photograph.
MASK, SCALE = "mask.png", "scale.json"
# What may be typed; options that name files of the server's machine are none of it.
_TYPED = (
    *("wavelength", "wavelength_sd", "pixel_size", "pixel_size_sd", "radius", "radius_sd", "view"),
    *("prior", "fix", "start"),
    *PART_OPTIONS,
)


class Settings(NamedTuple):
    """Texts by the names of the shell's options, with their units; a mask was drawn; a scale is taken from a result.

    Of a part of the model the text is "yes" or "no"; without one the image decides. `before`: the command that measures
    the scale.
    """

    texts: Mapping[str, str] = {}
    has_mask: bool = False
    scale: Mapping[str, Any] | None = None
    before: tuple[str, ...] = ()

    def arguments(self) -> dict[str, Any]:
        """Keyword arguments of `fitting.fit`, without mask and scale. Raises ValueError for texts that are none."""
        check_lamp(self.texts.get("wavelength", ""))
        if surplus := [name for name in self.texts if name not in _TYPED]:
            raise ValueError(f"{surplus[0]} cannot be given on the page; allowed: {', '.join(_TYPED)}")
        arguments = arguments_of(options_with(self.texts, FitOptions()))
        if self.scale is not None:
            arguments.pop("pixel_size")
        return {name: value for name, value in arguments.items() if value is not None}

    def shell_lines(self, photo: str) -> list[str]:
        """Commands that do the same, one a line; the photograph by its file's name."""
        words = ["newtonjax", "fit", photo]
        for name, text in self._stated():
            flag = name.replace("_", "-")
            if name in PART_OPTIONS:
                words.append(f"--{flag}" if text == "yes" else f"--no-{flag}")
            else:
                words += [f"--{flag}", text]
        words += ["--mask", MASK] if self.has_mask else []
        words += ["--scale-from", SCALE] if self.scale is not None else []
        return [shlex.join(self.before), shlex.join(words)] if self.before else [shlex.join(words)]

    def python_lines(self, photo: str) -> list[str]:
        """Lines of Python that do the same."""
        arguments = self.arguments()
        arguments |= {"mask": MASK} if self.has_mask else {}
        arguments |= {"scale": SCALE} if self.scale is not None else {}
        named = "".join(f", {name}={_literal(value)}" for name, value in arguments.items())
        return ["import fitting", "", f"result = fitting.fit({_literal(photo)}{named})", "print(result)"]

    def _stated(self) -> list[tuple[str, str]]:
        return [(name, text.strip()) for name, text in self.texts.items() if text.strip()]


def check_lamp(text: str) -> None:
    """Raise ValueError for a lamp that the shell would read from a file: the page reads none but what is sent."""
    if text.strip().lower().endswith(".csv"):
        raise ValueError(f"{text!r} names a file; give a lamp by its name, such as sodium, or a wavelength")


def _literal(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
