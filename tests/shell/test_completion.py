"""What the shell completes: verbs, options, choices and lamps, in bash, zsh and fish, without the heavy imports."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from fitting.shell.cli import main

ROOT = Path(__file__).resolve().parents[2]
HEAVY = ("equinox", "jax", "matplotlib", "numpy", "pint", "scipy", "skimage")
# By shell, how it hands over the words typed so far, the last of them being completed.
ASKING = {
    "bash": lambda words: {"COMP_WORDS": words, "COMP_CWORD": str(len(words.split(" ")) - 1)},
    "zsh": lambda words: {"_TYPER_COMPLETE_ARGS": words},
    "fish": lambda words: {"_TYPER_COMPLETE_ARGS": words, "_TYPER_COMPLETE_FISH_ACTION": "get-args"},
}


def question(shell: str, words: str) -> dict[str, str]:
    return {"_NEWTONJAX_COMPLETE": f"complete_{shell}", **ASKING[shell](words)}


@pytest.fixture
def answer(monkeypatch, capsys):
    def ask(shell: str, words: str) -> str:
        for name, value in question(shell, words).items():
            monkeypatch.setenv(name, value)
        assert main([]) == 0
        return capsys.readouterr().out

    return ask


@pytest.mark.parametrize("shell", ASKING)
@pytest.mark.parametrize(
    ("words", "expected", "absent"),
    [
        ("newtonjax r", ["render", "rings"], "scale"),
        ("newtonjax fit --wavelength-", ["--wavelength-sd"], "--pixel-size"),
        ("newtonjax fit --view ", ["reflected", "transmitted"], "sodium"),
        ("newtonjax fit --wavelength so", ["sodium", "sodium-d1"], "mercury-green"),
        ("newtonjax render --light me", ["mercury", "mercury-green"], "sodium"),
        ("newtonjax render --wavelength he", ["hene", "helium-yellow"], "sodium"),
    ],
)
def test_the_shell_completes_verbs_options_choices_and_lamps(answer, shell, words, expected, absent):
    text = answer(shell, words)
    assert all(word in text for word in expected)
    assert absent not in text


def test_a_tab_does_without_the_heavy_imports():
    program = (
        "import sys; from fitting.shell.cli import main; code = main([]); "
        f"heavy = [name for name in {HEAVY!r} if name in sys.modules]; "
        "sys.exit(f'loaded {heavy}' if heavy else code)"
    )
    environment = os.environ | question("bash", "newtonjax render --light so")
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT, env=environment)
    assert (done.returncode, done.stdout.split()[0]) == (0, "sodium"), done.stderr


@pytest.mark.parametrize("shell", ASKING)
def test_the_command_gives_the_script_that_a_shell_reads(monkeypatch, capsys, shell):
    monkeypatch.setenv("_NEWTONJAX_COMPLETE", f"source_{shell}")
    assert main([]) == 0
    assert f"_NEWTONJAX_COMPLETE=complete_{shell}" in capsys.readouterr().out


# Run by a shell of each kind: it takes the script of ours, and completes by it.
RUNNING = {
    "bash": (
        'eval "$(_NEWTONJAX_COMPLETE=source_bash newtonjax)"; COMP_WORDS=(newtonjax fit --wavelength so); '
        'COMP_CWORD=3; _newtonjax_completion newtonjax; echo "${COMPREPLY[@]}"'
    ),
    "fish": '_NEWTONJAX_COMPLETE=source_fish newtonjax | source; complete -C "newtonjax fit --wavelength so"',
    # It completes where somebody types, which another zsh does here; the last lamps are waited for.
    "zsh": """
        zmodload zsh/zpty
        zpty terminal 'zsh -f -i'
        zpty -w terminal "autoload -Uz compinit; compinit -u -D; source =(_NEWTONJAX_COMPLETE=source_zsh newtonjax)"
        zpty -n -w terminal $'newtonjax fit --wavelength so\\t\\t'
        zpty -r terminal answer '*sodium-d1*sodium-d2*'
        print -r -- "$answer"
    """,
}


@pytest.mark.parametrize("shell", RUNNING)
def test_a_shell_takes_the_script_and_completes_by_it(tmp_path, shell):
    if shutil.which(shell) is None:
        pytest.skip(f"there is no {shell}")
    command = tmp_path / "newtonjax"
    start = "from fitting.shell.entry import main; main()"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "{start}" "$@"\n', encoding="utf-8")
    command.chmod(0o755)
    environment = os.environ | {
        "PATH": f"{tmp_path}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT), "HOME": str(tmp_path), "TERM": "dumb"
    }  # fmt: skip
    done = subprocess.run(
        [shell, "-c", RUNNING[shell]], capture_output=True, text=True, check=False, env=environment, timeout=120
    )
    assert {"sodium", "sodium-d1", "sodium-d2"} <= set(done.stdout.split()), done.stderr


def test_no_verb_is_refused_where_no_shell_asks(capsys):
    assert main([]) == 2
    assert "no verb given" in capsys.readouterr().err
