"""No verb asks for more memory than there is: it refuses with the size, what there is, and the way out."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import newtonjax as nj
from newtonjax.numerics import memory

HUGE = nj.Camera((10**9, 10**9), 5e-6)


def write(root, files: dict[str, str]):
    for name, text in files.items():
        file = root / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)


MEMINFO = {"proc/meminfo": "MemTotal:  8000 kB\nMemFree:  10 kB\nMemAvailable:  5000 kB\n"}


def test_available_memory_is_that_of_the_system(tmp_path):
    write(tmp_path, MEMINFO)
    assert memory.available_memory(tmp_path) == 5000 * 1024


@pytest.mark.parametrize("limited", ["a/b", "a", ""])
def test_available_memory_is_what_the_tightest_group_leaves(tmp_path, limited):
    write(tmp_path, MEMINFO | {"proc/self/cgroup": "0::/a/b\n"})
    for folder in ("a/b", "a", ""):
        limit = "3000000\n" if folder == limited else "max\n"
        usage = {"memory.max": limit, "memory.current": "2000000\n", "memory.stat": "anon 5\ninactive_file 700000\n"}
        write(tmp_path / "sys/fs/cgroup" / folder, usage)
    assert memory.available_memory(tmp_path) == 3_000_000 - 2_000_000 + 700_000


def test_available_memory_in_groups_of_version_1_and_in_a_container(tmp_path):
    write(tmp_path, MEMINFO | {"proc/self/cgroup": "9:cpu:/x\n4:memory:/not/seen/from/here\n0::/\n"})
    v1 = {"memory.limit_in_bytes": "4000000\n", "memory.usage_in_bytes": "3500000\n"}
    write(tmp_path / "sys/fs/cgroup/memory", v1)
    assert memory.available_memory(tmp_path) == 500_000


def test_a_group_over_its_limit_leaves_nothing(tmp_path):
    write(tmp_path, MEMINFO | {"sys/fs/cgroup/memory.max": "10\n", "sys/fs/cgroup/memory.current": "20\n"})
    assert memory.available_memory(tmp_path) == 0


def test_where_no_file_tells_the_pages_of_the_system_do(tmp_path):
    pages = memory.available_memory(tmp_path)
    assert pages is None or pages > 2**20


def test_more_than_there_is_is_refused_with_both_sizes(monkeypatch):
    monkeypatch.setattr(memory, "available_memory", lambda: 3_000_000_000)
    memory.require_memory("this", 2.9e9)
    with pytest.raises(ValueError, match=r"this needs 3.2 GB of memory, and 3 GB are available; try that"):
        memory.require_memory("this", 3.2e9, "try that")
    monkeypatch.setattr(memory, "available_memory", lambda: None)
    memory.require_memory("this", 1e30)


def scene():
    return nj.newton_rings(2.0, 500e-9, 1e-6, view="transmitted", screen=1e-3)


VERBS = {
    "render": lambda: nj.render(scene(), HUGE),
    "Chebyshev": lambda: nj.render(scene(), HUGE, nj.Chebyshev(5)),
    "float32": lambda: nj.render(scene(), HUGE, nj.Chebyshev(5, "float32")),
    "ClosedForm": lambda: nj.render(nj.newton_rings(2.0, screen="gap", view="transmitted"), HUGE, nj.ClosedForm()),
    "Traced": lambda: nj.render(scene(), HUGE, nj.Traced()),
    "Splat": lambda: nj.render(scene(), HUGE, nj.Splat()),
    "splat": lambda: nj.splat(scene(), HUGE),
    "opd": lambda: nj.opd(scene(), HUGE),
    "sweep": lambda: nj.sweep(nj.newton_rings, {"radius": [1.0, 2.0]}, HUGE),
    "sweep, reduced": lambda: nj.sweep(nj.newton_rings, {"radius": [1.0, 2.0]}, HUGE, reduce=jnp.mean),
    "blocks": lambda: nj.blocks(scene(), HUGE, nj.Chebyshev(5)),
    "normal_equations": lambda: nj.normal_equations(
        lambda p: nj.newton_rings(p[0], view="transmitted", screen=1e-3), np.array([2.0]), HUGE
    ),
    "expose": lambda: HUGE.expose(np.broadcast_to(0.5, HUGE.shape), jax.random.key(0)),
}


@pytest.mark.parametrize("verb", VERBS)
def test_an_image_of_a_billion_rows_is_refused_at_once(verb):
    with pytest.raises(ValueError, match=r"of memory, and [\d.]+ [GM]B are available") as refusal:
        VERBS[verb]()
    if verb not in ("blocks", "sweep", "sweep, reduced"):
        assert "newtonjax.blocks" in str(refusal.value)


def test_a_plan_takes_no_memory_for_the_pixels():
    """16 GB, if it listed their coordinates."""
    assert (
        nj.plan(scene(), nj.Camera((10**9, 10**9), 5e-12)).method == nj.plan(scene(), nj.Camera((10, 10), 5e-4)).method
    )
