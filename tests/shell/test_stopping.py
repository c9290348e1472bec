"""Signals end the command at once, whatever it does; nothing half written stays, and what is complete is named."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fitting.parameters import output

SAMPLE = Path(__file__).resolve().parents[2] / "fitting/data/sample.png"
# Long enough for the busiest machine; none of these tests is a measurement of time.
PATIENCE = 120.0
# A verb that writes, and that swallows whatever a handler raises, as a callback of JAX does.
WRITER = """
import sys, time
from pathlib import Path
from fitting.parameters import output
from fitting.shell import stopping
folder = Path(sys.argv[1])
with stopping.watched():
    output.make_folder(folder / "empty")
    output.write(folder / "complete.txt", "all of it", False)
    with output.in_one_step(folder / "half.txt") as neighbour:
        neighbour.write_text("half of it")
        print("ready", flush=True)
        while True:
            try:
                time.sleep(0.01)
            except BaseException:
                pass
"""
# The command, to which a signal comes while it imports.
IMPORTING = """
import os, signal, sys
class Sender:
    def find_spec(self, name, *_):
        if name == "typer":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Sender())
from fitting.shell.entry import main
sys.exit(main())
"""
# A verb in a step that is not to be broken off, and that does not end.
STUCK = """
import threading, time
from pathlib import Path
from fitting.shell import stopping
stopping._PATIENCE = stopping._LIMIT = 1000.0
lock = threading.Lock()
with stopping.watched(), lock:
    stopping.keep(Path("step"), "stays", lock)
    print("ready", flush=True)
    time.sleep(1000.0)
"""


def started(*command) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, *map(str, command)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


# A verb that has another process at work for it, and waits.
WITH_CHILD = """
import subprocess, sys, time
from fitting.shell import stopping
with stopping.watched():
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(1000)"])
    stopping.ends_with_us(child)
    print(child.pid, flush=True)
    time.sleep(1000.0)
"""


@pytest.mark.parametrize(
    ("number", "status", "name"), [(signal.SIGTERM, 143, "SIGTERM"), (signal.SIGINT, 130, "Ctrl-C")]
)
def test_a_signal_ends_what_swallows_exceptions_and_removes_what_is_half_written(tmp_path, number, status, name):
    process = started("-c", WRITER, tmp_path)
    assert process.stdout.readline() == "ready\n"
    process.send_signal(number)
    _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == status
    assert said == f"newtonjax: stopped by {name}; complete: {tmp_path / 'complete.txt'}\n"
    assert [path.name for path in tmp_path.iterdir()] == ["complete.txt"]


def test_a_signal_while_the_command_is_imported_prints_no_traceback():
    process = started("-c", IMPORTING, "--help")
    assert process.communicate(timeout=PATIENCE) == ("", "")
    assert process.returncode == -signal.SIGINT


def test_a_second_signal_ends_at_once_what_the_first_waits_for():
    process = started("-c", STUCK)
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGINT)
    time.sleep(0.6)  # a second one within 0.3 s is taken for the first one's echo
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=PATIENCE) == ("", "")
    assert process.returncode == 130


def test_no_process_that_a_verb_has_started_goes_on_alone():
    process = started("-c", WITH_CHILD)
    assert int(process.stdout.readline())
    process.send_signal(signal.SIGTERM)
    # The child has its parent's stderr, whose end comes with that of both.
    assert "stopped by SIGTERM" in process.communicate(timeout=PATIENCE)[1]


def test_a_signal_that_the_parent_ignores_stays_ignored(tmp_path):
    process = started("-c", f"import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n{WRITER}", tmp_path)
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGHUP)
    process.send_signal(signal.SIGTERM)
    _, message = process.communicate(timeout=PATIENCE)
    assert "stopped by SIGTERM" in message
    assert process.returncode == 143


def test_a_program_that_may_be_half_written_does_not_stay_in_the_cache(tmp_path):
    fresh, old = tmp_path / "fresh-cache", tmp_path / "old-cache"
    for path in (fresh, old):
        path.write_bytes(b"half of it")
    os.utime(old, (0, 0))
    program = f"import jax; jax.config.update('jax_compilation_cache_dir', {str(tmp_path)!r})"
    process = started("-c", f"{program}\n{WRITER}", tmp_path / "results")
    assert process.stdout.readline() == "ready\n"
    fresh.touch()
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=PATIENCE)
    assert old.exists()
    assert not fresh.exists()


def test_a_chain_that_is_stopped_leaves_the_fit_and_its_own_steps(tmp_path):
    import emcee

    folder = tmp_path / "result"
    command = ("fit", SAMPLE, "--wavelength", "sodium", "--pixel-size", "8um", "--mcmc", "--output-dir", folder)
    process = started("-c", "import sys; from fitting.shell.cli import main; sys.exit(main())", *command)
    chain, patience = folder / "chain.h5", time.monotonic() + PATIENCE
    # To read the file would lock it for the chain: that it has changed several times tells as much.
    changes = set()
    while len(changes) < 6 and process.poll() is None and time.monotonic() < patience:
        changes |= {chain.stat().st_mtime_ns} if chain.exists() else set()
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, said
    assert "stopped by Ctrl-C" in said
    assert f"{chain} (the same command with --force goes on with it)" in said
    assert json.loads((folder / "result.json").read_text())["status"] == "ok"
    assert sorted(path.name for path in folder.iterdir()) == ["chain.h5", "report.txt", "result.json", "result.png"]
    assert emcee.backends.HDFBackend(str(chain), read_only=True).iteration > 0


# A verb whose third step of a kind says so, and does not end.
THIRD = """
import importlib, sys, time
from fitting.shell.cli import main
module, owner, name = sys.argv[1:4]
owner = getattr(importlib.import_module(module), owner)
step, count = getattr(owner, name), 0
def until_the_third(*arguments):
    global count
    count += 1
    if count == 3:
        print("third", flush=True)
        time.sleep(1000.0)
    return step(*arguments)
setattr(owner, name, until_the_third)
sys.exit(main(sys.argv[4:]))
"""
BENCH = """[newton_rings]
radius = 1.0
wavelength = 589.3e-9
view = "reflected"
screen = "gap"
[camera]
shape = [48, 48]
pixel_size = 60e-6
"""


@pytest.mark.parametrize(
    ("step", "verb", "words", "files", "steps_in"),
    [
        (
            ("fitting.studies.designs", "Search", "run"),
            ("design", "scene.toml", "--vary", "pixel_size=20um:200um"),
            "the best of 2 searches",
            ("design.csv", "design.json", "design.toml"),
            lambda answer: len(answer["starts"]),
        ),
        (
            ("fitting.studies.timing", "_Comparison", "nodes"),
            ("tradeoff", "scene.toml"),
            "3 methods",
            ("tradeoff.csv", "tradeoff.json"),
            lambda answer: len(answer["timings"]),
        ),
        (
            ("fitting.shell.selftest_verb", "selftest", "photograph_trial"),
            ("selftest",),
            "the limits for 2 photographs and 0 tables",
            ("selftest.csv", "selftest.json"),
            lambda answer: answer["checks"][0]["trials"],
        ),
    ],
    ids=["design", "tradeoff", "selftest"],
)
def test_what_a_verb_has_done_so_far_is_printed_and_written(tmp_path, step, verb, words, files, steps_in):
    (tmp_path / "scene.toml").write_text(BENCH)
    arguments = [tmp_path / word if word == "scene.toml" else word for word in verb]
    process = started("-c", THIRD, *step, *arguments, "--output-dir", tmp_path / "out")
    assert process.stdout.readline() == "third\n", process.communicate()[1]
    process.send_signal(signal.SIGINT)
    printed, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    written = [tmp_path / "out" / name for name in files]
    kept = f"kept: {words} in {', '.join(map(str, written))}"
    assert said == f"newtonjax: stopped by Ctrl-C; {kept}; complete: nothing\n"
    assert sorted((tmp_path / "out").iterdir()) == written
    assert f"{steps_in(json.loads(written[1].read_text()))} " in words
    assert len(printed.splitlines()) > 3


def test_what_cannot_be_written_is_refused_before_the_work(tmp_path, monkeypatch):
    def refuse(path, **_):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "touch", refuse)
    with pytest.raises(PermissionError, match=r"cannot be written \(Permission denied\); name another file"):
        output.check_free([tmp_path / "result.png"], force=False)


def test_a_refused_command_leaves_no_empty_folder(tmp_path, capsys):
    from fitting.shell.cli import main

    (tmp_path / "no.png").write_text("this is text")
    assert main(["fit", str(tmp_path / "no.png"), "--wavelength", "sodium", "--output-dir", str(tmp_path / "new")]) == 2
    assert "no.png" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()
