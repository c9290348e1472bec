"""Errors of the library in the words of the command: `--axis-sd` where Python says `axis_px_sd`."""

import re

import typer
from typer.main import get_command

# Arguments whose option has another name.
_RENAMED = {
    "axis_px": "axis", "axis_px_sd": "axis_sd", "priors": "prior", "scale": "scale_from", "columns": "column",
    "points": "point", "shared": "share",
}  # fmt: skip
# Of a cell of a file, whose columns and keys have the names that Python has.
_IN_FILE = re.compile(r"\.toml\b|, line \d+: |\bmanifest\b")


def in_words_of_shell(message: str, app: typer.Typer, verb: str) -> str:
    """The message with a verb's options in place of the arguments that they stand for.

    A name of several words is replaced wherever it stands without quotes and in no list of names, a plain word where
    the message begins with it: elsewhere it is English.
    """
    command = getattr(get_command(app), "commands", {}).get(verb)
    if command is None or _IN_FILE.search(message):
        return message
    options = {item.name: item.opts[0] for item in command.params if item.opts and item.opts[0].startswith("--")}
    options |= {name: options[option] for name, option in _RENAMED.items() if option in options}

    def as_option(match: re.Match) -> str:
        return options.get(match.group(), match.group())

    message = re.sub(r"\A[a-z]+(?=: | is | has | holds )", as_option, message)
    message = re.sub(r"\bfitting\.(?=[a-z]+\b)", "newtonjax ", message)
    return re.sub(r"(?<![\w'\"-])(?<!, )(?<!allowed: )[a-z]+(?:_[a-z]+)+(?![\w'\"])", as_option, message)
