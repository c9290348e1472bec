"""Whatever dies on the way: every photograph has one row at the end, and no process stays."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import batch_work
import pytest

# Long enough for the busiest machine; none of these tests is a measurement of time.
PATIENCE = 120.0
pytestmark = pytest.mark.skipif(os.name != "posix", reason="kills processes by POSIX signals")


@pytest.fixture
def folder(tmp_path):
    """A dozen files for the work."""
    files = tmp_path / "photos"
    files.mkdir()
    for number in range(12):
        (files / f"{number:02}.png").write_text(f"value {number}")
    return files


def rows(results: Path) -> list[dict]:
    """The complete lines of a file of results."""
    text = results.read_text() if results.exists() else ""
    return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]


def names(results: Path) -> Counter:
    """How many rows each file has, and each page of it."""
    return Counter((Path(row["path"]).name, row["page"]) for row in rows(results))


def wait_for(condition) -> None:
    """Until it holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def is_running(process: int) -> bool:
    """Whether a process is there and no zombie."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def test_killed_workers_and_coordinators_lose_nothing_and_repeat_nothing(folder, tmp_path):
    results = tmp_path / "results.jsonl"
    command = [sys.executable, batch_work.__file__, str(results), str(folder), "2"]
    process = subprocess.Popen(command, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
    wait_for(lambda: len(rows(results)) >= 2)
    os.kill(rows(results)[-1]["worker"], signal.SIGKILL)
    wait_for(lambda: len(rows(results)) >= 5 or process.poll() is not None)
    process.kill()
    assert process.wait() == -signal.SIGKILL
    with results.open("ab") as file:
        file.write(b'{"key": "cut o')  # what a kill in the middle of a line leaves
    before = rows(results)
    workers = [int(path.name) for path in (folder / ".workers").iterdir()]
    wait_for(lambda: not any(map(is_running, workers)))
    assert 5 <= len(before) < 12
    tally = batch_work.measured(results, folder)
    assert rows(results)[: len(before)] == before
    assert names(results) == Counter({(f"{number:02}.png", 1): 1 for number in range(12)})
    assert (tally.resumed, tally.measured, tally.total) == (len(before), 12 - len(before), 12)


def test_a_photograph_that_kills_its_workers_is_a_row_and_takes_no_other_with_it(folder, tmp_path):
    (folder / "03.png").write_text("die")
    (folder / "05.png").write_text("die once")
    (folder / "07.png").write_text("raise")
    tally = batch_work.measured(tmp_path / "r.jsonl", folder)
    assert names(tmp_path / "r.jsonl") == Counter({(f"{number:02}.png", 1): 1 for number in range(12)})
    failures = {Path(row["path"]).name: row["reason"] for row in rows(tmp_path / "r.jsonl") if row["status"] != "ok"}
    assert failures == {"03.png": "WORKER_DIED", "07.png": "ValueError"}
    assert tally.statuses == {"ok": 10, "failed": 2}
    (folder / "03.png").write_text("value")
    # What has changed is another photograph; what has failed is measured again where that is asked for.
    assert batch_work.measured(tmp_path / "r.jsonl", folder).measured == 1
    assert batch_work.measured(tmp_path / "r.jsonl", folder, retry=True).measured == 1


def test_every_page_has_a_row_also_where_the_batch_goes_on_after_the_first(folder, tmp_path):
    (folder / "04.png").write_text("pages 3")
    tally = batch_work.measured(tmp_path / "r.jsonl", folder)
    pages = Counter({("04.png", page): 1 for page in (2, 3)})
    assert names(tmp_path / "r.jsonl") == pages + Counter({(f"{number:02}.png", 1): 1 for number in range(12)})
    assert tally.total == tally.measured == 14
    lines = [line for line in (tmp_path / "r.jsonl").read_text().splitlines(True) if json.loads(line)["page"] == 1]
    (tmp_path / "first.jsonl").write_text("".join(lines))
    tally = batch_work.measured(tmp_path / "first.jsonl", folder)
    assert (tally.total, tally.resumed, tally.measured) == (14, 12, 2)
    assert names(tmp_path / "first.jsonl") == names(tmp_path / "r.jsonl")


def test_workers_that_cannot_start_end_the_batch(folder, tmp_path):
    with pytest.raises(RuntimeError, match="end before they are ready"):
        batch_work.measured(tmp_path / "r.jsonl", folder, prepare=batch_work.refuse_to_start)
    assert rows(tmp_path / "r.jsonl") == []


def test_photographs_are_measured_as_they_arrive(folder, tmp_path):
    results = tmp_path / "results.jsonl"
    command = [sys.executable, batch_work.__file__, str(results), str(folder), "follow"]
    process = subprocess.Popen(command, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
    try:
        wait_for(lambda: len(rows(results)) == 12)
        (folder / "late.png").write_text("value")
        (folder / ".hidden.png").write_text("value")
        wait_for(lambda: len(rows(results)) == 13)
    finally:
        process.kill()
        process.wait()
    assert names(results)["late.png", 1] == 1
