"""The verb `doctor`: what it says of an environment that is right, and of JAX that raises, hangs or is killed."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fitting.shell import doctor_verb, jax_probe, requirements
from fitting.shell.cli import main

ROOT = Path(__file__).resolve().parents[2]


def advice_of(facts) -> list[str]:
    return [fact.advice for fact in facts if fact.advice]


@pytest.fixture
def broken(tmp_path, monkeypatch):
    """A package `jax` with this text, before the one that is installed."""

    def write(text: str) -> Path:
        (tmp_path / "jax").mkdir()
        (tmp_path / "jax" / "__init__.py").write_text(text, encoding="utf-8")
        monkeypatch.syspath_prepend(tmp_path)
        return tmp_path

    return write


def test_it_says_versions_devices_and_the_cache_of_a_right_environment(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(tmp_path))
    status = main(["doctor", "--json"])
    answer = json.loads(capsys.readouterr().out)
    assert (status, answer["ok"], answer["advice"]) == (0, True, [])
    assert answer["versions"]["numpy"] == requirements.installed("numpy")
    assert answer["jax"]["float64"] == "True"
    assert ": " in answer["jax"]["devices"]
    assert set(answer["extras"]) == {"app", "cluster", "raw", "nuts", "video", "sheets"}
    assert answer["cache"]["folder"].startswith(str(tmp_path))


def test_it_says_all_else_where_jax_cannot_be_imported(broken):
    folder = broken("raise ImportError('no such symbol')")
    program = "from fitting.shell.cli import main; raise SystemExit(main(['doctor']))"
    environment = os.environ | {"PYTHONPATH": f"{folder}{os.pathsep}{ROOT}"}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT, env=environment)
    assert (done.returncode, done.stderr) == (1, "")
    assert f"numpy                  {requirements.installed('numpy')}\n" in done.stdout
    assert "ended with 1: ImportError: no such symbol" in done.stdout
    assert done.stdout.splitlines()[-1].endswith("--force-reinstall jax jaxlib")


def test_it_does_not_wait_for_a_jax_that_never_answers(broken):
    broken("import time; time.sleep(60)")
    probe = jax_probe.probe([], limit=0.5)
    assert (probe.status, probe.ended_in()) == (None, "jax")
    assert advice_of(doctor_verb._jax(probe)) == ["JAX_PLATFORMS=cpu leaves other devices out"]


def test_it_says_which_signal_ended_jax(broken):
    broken("import os, signal; os.kill(os.getpid(), signal.SIGILL)")
    (advice,) = advice_of(doctor_verb._jax(jax_probe.probe([])))
    assert "SIGILL" in advice
    assert "processor lacks an instruction" in advice


def test_it_names_a_package_that_is_installed_and_broken():
    facts = {"jax": "1", "devices": ["cpu: cpu"], "float64": False, "imports": {"scipy": "ImportError: libgfortran"}}
    advice = advice_of(doctor_verb._jax(jax_probe.Probe(facts, 0, "")))
    assert len(advice) == 2
    assert "less than 64 bits" in advice[0]
    assert advice[1].endswith("--force-reinstall scipy")


def test_it_advises_on_a_cache_that_cannot_be_written_or_that_others_may_write(tmp_path):
    (tmp_path / "file").touch()
    (advice,) = advice_of(doctor_verb._cache(tmp_path / "file"))
    assert "name a folder that can be written" in advice
    (tmp_path / "programs").mkdir()
    assert advice_of(doctor_verb._cache(tmp_path)) == []
    (tmp_path / "programs").chmod(0o777)
    (advice,) = advice_of(doctor_verb._cache(tmp_path))
    assert advice.startswith(f"chmod -R go-w {tmp_path}")


def test_it_counts_the_compiled_programs(tmp_path):
    (tmp_path / "programs").mkdir()
    for name in ("a-cache", "programs/b.program", "programs/.1.part"):
        (tmp_path / name).write_bytes(b"x" * 500_000)
    assert "2 files, 1 MB" in [fact.value for fact in doctor_verb._cache(tmp_path)][1]


def test_what_is_needed_is_read_from_the_package_itself():
    needed = {(item.package, item.extra): item for item in requirements.requirements()}
    assert needed["jax", ""].lowest == "0.10"
    assert needed["jax", ""].lack() == ""
    assert needed["rawpy", "raw"].extra in requirements.EXTRAS


@pytest.mark.parametrize(
    ("installed", "lack"), [("", "missing"), ("0.9.2", "0.9.2 is older than 0.10"), ("0.10.0rc1", ""), ("1.2", "")]
)
def test_a_version_is_compared_by_its_numbers(installed, lack):
    assert requirements.Requirement("jax", "0.10", "", installed).lack() == lack


def test_a_missing_extra_comes_with_its_command_and_is_not_amiss():
    needed = [requirements.Requirement("rawpy", "0.24", "raw", "")]
    facts = {fact.name: fact for fact in doctor_verb._extras(needed)}
    assert facts["raw"].value.endswith("rawpy missing: pip install 'newtonjax[raw]'")
    assert not any(fact.advice for fact in facts.values())
