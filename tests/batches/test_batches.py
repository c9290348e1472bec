"""Rows, sources, limits and tables of a batch."""

import json
import os
import time

import numpy as np
import pytest

from fitting.batches import FAILED, Batch, Job, Ledger, described, digest_of, follow, photographs, rows_of
from fitting.batches.chart import control


def a_job(path, page=None, **settings) -> Job:
    """A job of a file."""
    return Job(str(path), page, digest_of(path), settings, settings)


def test_a_key_tells_content_settings_path_and_page_apart(tmp_path):
    first, second = tmp_path / "a.png", tmp_path / "b.png"
    first.write_bytes(b"1")
    second.write_bytes(b"1")
    jobs = [a_job(first), a_job(second), a_job(first, 2), a_job(first, wavelength=5e-7), a_job(first, wavelength=6e-7)]
    first.write_bytes(b"2")
    jobs += [a_job(first)]
    assert len({job.key for job in jobs}) == len(jobs)
    assert a_job(first).key == a_job(first, 1).key
    assert a_job(first, b=1, a=2).key == a_job(first, a=2, b=1).key


def test_settings_are_described_by_what_they_hold(tmp_path):
    (tmp_path / "mask.png").write_bytes(b"1")
    mask = described(tmp_path / "mask.png")
    (tmp_path / "mask.png").write_bytes(b"2")
    assert described(tmp_path / "mask.png") != mask
    assert described(np.zeros(3)) != described(np.ones(3))
    assert described({"parts": {"contact": True}, "fixed": (1.0, np.float64(2.0))}) == {
        "parts": {"contact": True},
        "fixed": [1.0, 2.0],
    }
    with pytest.raises(ValueError, match="a object is no setting"):
        described(object())


def test_a_line_that_was_not_completed_is_cut_off_and_a_second_batch_refused(tmp_path):
    path = tmp_path / "r.jsonl"
    with Ledger(path) as ledger:
        ledger.append({"key": "a", "status": "ok", "value": np.float64(np.nan)})
        ledger.append({"key": "a", "status": "ok"})
        with pytest.raises(ValueError, match="another batch is writing"):
            Ledger(path)
    complete = path.read_bytes()
    assert json.loads(complete) == {"key": "a", "status": "ok", "value": None}
    path.write_bytes(complete + b'{"key": "b", "sta' + b"x" * 100_000)
    with Ledger(path) as ledger:
        assert "a" in ledger
        assert "b" not in ledger
    assert path.read_bytes() == complete
    path.write_bytes(b"no JSON\n")
    with pytest.raises(ValueError, match=r"r\.jsonl, line 1, is no row of a batch"):
        Ledger(path)


def test_files_folders_and_patterns_give_each_photograph_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a/1.png", "a/b/2.TIF", "a/b/note.txt", "a/.3.png", "a/out/chart.png", "c.dat"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(b"1")
    expected = [tmp_path / name for name in ("a/1.png", "a/b/2.TIF", "c.dat")]
    assert photographs(["a", "a/*.png", "c.dat"], without=tmp_path / "a/out") == expected
    assert photographs(["**/*.TIF"]) == [tmp_path / "a/b/2.TIF"]
    with pytest.raises(FileNotFoundError, match=r"none\*\.png matches no photograph"):
        photographs(["none*.png"])


def test_a_photograph_that_is_still_written_is_left_for_later(tmp_path):
    path = tmp_path / "a.png"
    path.write_bytes(b"1")
    arriving = follow(tmp_path, still=0.0)
    assert next(arriving) is None
    path.write_bytes(b"12")
    assert next(arriving) is None
    assert next(arriving) == path
    assert [next(arriving) for _ in range(3)] == [None] * 3
    os.utime(path, (time.time() + 5, time.time() + 5))
    assert [next(arriving) for _ in range(4)] == [None, path, None, None]


def test_limits_follow_the_moving_range_and_leave_a_drift_alone():
    # Alternating by 2 d: the moving range is 2 d throughout, so the limits are at 3 x 2 d / 0.9539 from the median.
    values = [1.0, 1.2] * 5
    limits = control(values, [0.0] * 10)
    assert limits.centre == pytest.approx(1.1)
    assert limits.high - limits.centre == pytest.approx(3 * 0.2 / 0.9539)
    assert not any(limits.outliers)
    values[4] = 3.0
    assert [place for place, outside in enumerate(control(values, [0.0] * 10).outliers) if outside] == [4]
    # The same value with a standard deviation of its own that explains it.
    assert not any(control(values, [0.0] * 4 + [1.0] + [0.0] * 5).outliers)
    assert control([1.0] * 4, [0.0] * 4) is None


def test_the_table_has_a_column_for_each_quantity_and_the_report_names_what_needs_a_look(tmp_path):
    path, rng = tmp_path / "r.jsonl", np.random.default_rng(1)
    with Ledger(path) as ledger:
        for number in range(20):
            value = 1.0 + 1e-3 * rng.normal() + 0.1 * (number == 7)
            measured = {"quantity": "radius", "unit": "m", "value": value, "sd": 1e-2, "sd_noise": 1e-4}
            about = {"status": "ok", "taken": f"2026-01-01T10:00:{number:02}", **measured}
            ledger.append({"key": str(number), "path": f"/p/{number}.png", "page": 1, **about})
        ledger.append({"key": "f", "path": "/p/f.png", "page": 1, "status": FAILED, "message": "no image"})
        scale = {"status": "no-scale", "quantity": "fringe_scale", "unit": "per_px2", "value": 1e-4, "sd": 1e-8}
        ledger.append({"key": "s", "path": "/p/s.tif", "page": 2, **scale})
    batch = Batch(path, rows_of(path, ["f", "s", *map(str, range(20))]))
    assert batch.counts == {"failed": 1, "no-scale": 1, "ok": 20}
    assert [row.name for row in batch.outliers] == ["7.png"]
    header, failure, *lines = batch.table().splitlines()
    assert header == (
        "path,page,taken,status,reason,fringe_scale_per_px2,fringe_scale_sd_per_px2,radius_m,radius_sd_m,"
        "outlier,seconds,message"
    )
    assert failure == "/p/f.png,1,,failed,,,,,,,0.0,no image"
    assert lines[0].startswith("/p/s.tif,2,,no-scale,,0.0001,1e-08,,,,")
    assert [line.split(",")[9] for line in lines].count("yes") == 1
    assert "f.png: no image" in batch.report()
    assert "7.png: 1.1" in batch.report()
    drawn = batch.figure().axes[0]
    assert len(drawn.get_lines()[0].get_xdata()) == 20
    assert drawn.get_ylabel() == "radius [m]"
    assert drawn.get_xlabel() == "time"
    with pytest.raises(ValueError, match="no photograph of this batch gave a value"):
        Batch(path, rows_of(path, ["f"])).figure()


def test_photographs_copied_at_one_time_have_places_in_their_order(tmp_path):
    path = tmp_path / "r.jsonl"
    with Ledger(path) as ledger:
        for number in range(6):
            scale = {"quantity": "fringe_scale", "unit": "per_px2", "value": 1e-4 + 1e-8 * number, "sd": 1e-8}
            about = {"path": f"/p/{number}.png", "page": 1, "status": "no-scale", "taken": "2026-01-01T10:00:00.5"}
            ledger.append({"key": str(number), **about, **scale})
    batch = Batch(path, rows_of(path, map(str, range(6))))
    drawn = batch.figure().axes[0]
    assert list(drawn.get_lines()[0].get_xdata()) == [1, 2, 3, 4, 5, 6]
    assert drawn.get_ylabel() == "fringe scale [per px²]"
    assert drawn.get_xlabel().startswith("photograph")
    assert "fringe scale: median 0.000100025 per px²" in batch.report()
