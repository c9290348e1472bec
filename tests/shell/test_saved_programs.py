"""Programs kept between runs: loaded without tracing, and never where anything is amiss."""

import os
import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from fitting.shell import saved_programs
from fitting.shell.saved_programs import SavedProgram

PROGRAM = """
import jax
from jax import monitoring
traced = []
monitoring.register_event_duration_secs_listener(lambda name, _, **more: traced.append(name.endswith("trace_duration")))
from fitting.shell import session
session.prepare()
session.keep_rays()
import newtonjax as nj
plan = nj.plan(nj.newton_rings({radius}, 589e-9, view="transmitted", screen=1e-3), nj.Camera((64, 64), 2e-5))
print(sum(traced), plan.method.nodes, plan.intensity_error.hex())
"""


def fresh_plan(cache: Path, radius: float = 1.0) -> list[str]:
    """What a process of its own traces and plans with a cache's folder."""
    environment = os.environ | {"JAX_COMPILATION_CACHE_DIR": str(cache)}
    command = [sys.executable, "-c", PROGRAM.format(radius=radius)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    return done.stdout.split()


def test_a_second_process_plans_another_bench_without_tracing_and_the_first_one_alike(tmp_path):
    first = fresh_plan(tmp_path)
    assert int(first[0]) > 0
    second = fresh_plan(tmp_path)
    assert int(second[0]) == 0
    assert second[1:] == first[1:]
    assert int(fresh_plan(tmp_path, 2.0)[0]) == 0


calls = []


@jax.jit
def twice(x):
    calls.append(x.shape)
    return {"result": 2 * x}


@pytest.fixture
def folder(tmp_path):
    calls.clear()
    return tmp_path / "programs"


THREE = np.arange(3.0)


def use(folder, x=THREE):
    """A fresh program of the folder used once: how often it was traced. JAX forgets what it traced before."""
    jax.clear_caches()
    calls.clear()
    assert np.array_equal(SavedProgram(twice, folder)(x)["result"], 2 * x)
    return len(calls)


def test_a_program_is_traced_once_for_each_kind_of_arguments(folder):
    assert [use(folder), use(folder)] == [1, 0]
    assert [use(folder, np.arange(4.0)), use(folder, np.arange(4, dtype=np.float32)), use(folder, np.arange(4.0))] == [
        1,
        1,
        0,
    ]


def test_a_damaged_file_is_compiled_anew(folder):
    use(folder)
    (file,) = folder.glob("*.program")
    for content in (b"", b"no pickle", file.read_bytes()[:-100]):
        file.write_bytes(content)
        assert use(folder) == 1
        assert use(folder) == 0


def test_a_program_of_another_machine_version_or_source_is_not_used(folder, monkeypatch):
    use(folder)
    for name in ("_machine", "_sources"):
        with monkeypatch.context() as patch:
            patch.setattr(saved_programs, name, lambda: "another")
            assert use(folder) == 1
    assert use(folder) == 0


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no owner here")
def test_what_another_user_may_have_written_is_not_loaded(folder, monkeypatch):
    use(folder)
    (file,) = folder.glob("*.program")
    file.chmod(0o666)
    assert use(folder) == 1
    assert use(folder) == 0  # written anew, by the user
    monkeypatch.setattr(os, "getuid", lambda: 12345)
    assert use(folder) == 1


def test_where_no_file_can_be_written_the_program_still_runs(tmp_path):
    file = tmp_path / "file"
    file.write_bytes(b"")
    assert use(file / "programs") == 1


def test_traced_arguments_take_the_function_itself(folder):
    program = SavedProgram(twice, folder)
    slope = jax.grad(lambda x: program(x)["result"].sum())(jnp.arange(3.0))
    assert np.array_equal(slope, [2.0, 2.0, 2.0])
    assert not folder.exists()


def test_a_program_that_fails_when_it_runs_is_thrown_away(folder, monkeypatch):
    program = SavedProgram(twice, folder)
    program(np.arange(3.0))

    def broken(*_):
        raise RuntimeError("function not found")

    kind = next(iter(program._programs))
    monkeypatch.setitem(program._programs, kind, broken)
    assert np.array_equal(program(np.arange(3.0))["result"], [0.0, 2.0, 4.0])
    assert not list(folder.glob("*.program"))
