"""The manual page `newtonjax.1`: made of the command's own help, and read by `man` without a complaint.

python tests/architecture/test_man_page.py      # writes man/newtonjax.1 anew
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from typer.main import get_command

from fitting.shell.cli import app

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "man" / "newtonjax.1"
SEE_ALSO = "The manual (make docs, in a copy of the project's folder) has examples of every verb."


def _roff(text: str) -> str:
    """Text whose backslashes, hyphens and leading dots are no requests of roff."""
    plain = " ".join(text.split()).replace("\\", "\\e").replace("-", "\\-")
    return f"\\&{plain}" if plain[:1] in (".", "'") else plain


def _paragraphs(text: str) -> list[str]:
    return [line for part in text.split("\n\n") for line in (".PP", _roff(part))]


def _records(command) -> list[str]:
    """A tagged paragraph for each argument and option."""
    context = command.make_context(command.name, [], resilient_parsing=True)
    records = (parameter.get_help_record(context) for parameter in command.get_params(context))
    return [line for name, text in filter(None, records) for line in (".TP", f".B {_roff(name)}", _roff(text) or "\\&")]


def _verb(name: str, command) -> list[str]:
    context = command.make_context(name, [], resilient_parsing=True)
    usage = _roff(" ".join(command.collect_usage_pieces(context)))
    return [f".SS {name}", f".B newtonjax {name}", usage, *_paragraphs(command.help or ""), *_records(command)]


def man_page() -> str:
    """The page as the command's help has it."""
    command = get_command(app)
    version, date = re.findall(r"^## (\S+) \((.*)\)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)[0]
    head = [
        f'.TH NEWTONJAX 1 "{date}" "newtonjax {version}" "User commands"',
        ".SH NAME",
        "newtonjax \\- Newton's rings: images of them, and a lens radius from a photograph",
        ".SH SYNOPSIS",
        ".B newtonjax",
        "VERB [OPTIONS] ...",
        ".SH DESCRIPTION",
        *_paragraphs(command.help or "")[1:],
        *_paragraphs((command.epilog or "").split(" Exit status:")[0]),
        ".SH OPTIONS",
        *_records(command),
        ".SH VERBS",
    ]
    verbs = [line for name, verb in command.commands.items() for line in _verb(name, verb)]
    status = [".SH EXIT STATUS", _roff((command.epilog or "").split("Exit status: ")[1])]
    return "\n".join([*head, *verbs, *status, ".SH SEE ALSO", _roff(SEE_ALSO)]) + "\n"


def test_the_manual_page_is_that_of_the_command_as_it_is():
    assert PAGE.read_text(encoding="utf-8") == man_page()


def test_the_manual_page_has_every_verb_with_every_option():
    text = PAGE.read_text(encoding="utf-8").replace("\\-", "-")
    for name, command in get_command(app).commands.items():
        section = text.split(f".SS {name}\n")[1].split("\n.S")[0]
        options = [option for parameter in command.params for option in parameter.opts if option.startswith("--")]
        assert not [option for option in options if not re.search(rf"{option}\b", section)]


@pytest.mark.skipif(shutil.which("man") is None, reason="there is no man")
def test_man_shows_the_page_without_a_warning():
    command = ["man", "--warnings=w", "-l", str(PAGE)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "--wavelength-sd" in done.stdout


@pytest.mark.skipif(shutil.which("mandoc") is None, reason="there is no mandoc")
def test_mandoc_finds_no_error_in_the_page():
    command = ["mandoc", "-T", "lint", "-W", "warning", str(PAGE)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


if __name__ == "__main__":
    PAGE.write_text(man_page(), encoding="utf-8")
