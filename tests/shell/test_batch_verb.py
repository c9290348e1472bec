"""The verb `batch` and `fitting.batch`: photographs, pages and manifests to rows, a table, a chart, an exit status."""

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from rings_data import rings
from shell import refusal
from skimage.io import imsave

import fitting
from fitting.shell import manifest, photograph_work, quantities
from fitting.shell.cli import main
from fitting.shell.fit_arguments import FitOptions

GIVEN = ("--wavelength", "589.3nm", "--pixel-size", "30um", "--view", "reflected")
PATIENCE = 120.0


def codes(radius: float, seed: int) -> np.ndarray:
    """A photograph of 16 bits."""
    image = rings(radius=radius, shape=(64, 80), pixel_size=30e-6, centre=(38.0 + seed, 31.0))
    noise = np.random.default_rng(seed).normal(0, 0.01, image.shape)
    return np.clip(np.round(30000 * (image + noise)), 0, 65535).astype(np.uint16)


def without_progress(errors: str) -> list[str]:
    """The lines on stderr but for those that a slow machine shows each half minute."""
    return [line for line in errors.splitlines() if not re.match(r"newtonjax: \d+ of \d+ photographs", line)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Six photographs, two pages of another one, a file that is no image, and a picture without rings."""
    photos = tmp_path_factory.mktemp("batch")
    for number in range(6):
        imsave(photos / f"{number}.png", codes(1.0 + 0.001 * number, number), check_contrast=False)
    imsave(photos / "pages.tif", np.stack([codes(1.1, 7), codes(1.2, 8)]), check_contrast=False)
    (photos / "text.png").write_text("this is text")
    imsave(photos / "even.png", np.full((64, 80), 20000, np.uint16), check_contrast=False)
    return photos


def test_a_folder_becomes_rows_a_table_and_a_chart_and_is_not_measured_again(folder, tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["batch", str(folder), *GIVEN, "--workers", "2", "--output-dir", str(out)]
    assert main(arguments) == 5
    printed = capsys.readouterr()
    assert "10 photographs: 1 failed, 1 refused, 8 ok" in printed.out
    assert without_progress(printed.err) == [
        "newtonjax: of 10 photographs 1 failed, 1 refused; summary.csv has the reasons"
    ]
    rows = [json.loads(line) for line in (out / "results.jsonl").read_text().splitlines()]
    by_name = {(Path(row["path"]).name, row["page"]): row for row in rows}
    assert len(rows) == len(by_name) == 10
    assert by_name["text.png", 1]["reason"] == "ValueError"
    assert by_name["even.png", 1]["reason"] == "UNIFORM"
    size = quantities.length("30um")  # not 30e-6 to the last digit
    alone = fitting.fit(folder / "pages.tif", page=2, wavelength=589.3e-9, pixel_size=size, view="reflected")
    assert fitting.FitResult.from_dict(by_name["pages.tif", 2]["result"]) == alone
    assert by_name["pages.tif", 2]["value"] == alone.radius
    table = list(csv.DictReader((out / "summary.csv").read_text().splitlines()))
    assert [Path(line["path"]).name for line in table].count("pages.tif") == 2
    assert (out / "chart.png").read_bytes().startswith(b"\x89PNG")
    written = (out / "results.jsonl").read_bytes()
    assert main(arguments) == 5
    assert (out / "results.jsonl").read_bytes() == written


def test_photographs_of_a_manifest_and_of_python_have_settings_of_their_own(folder, tmp_path):
    lines = ["photo,pixel-size,radius,page", f"{folder}/0.png,,,", f"{folder}/1.png,60um,,", f"{folder}/2.png,,1m,"]
    (folder / "list.csv").write_text("\n".join([*lines, "pages.tif,,,2", "absent.png,,,"]))
    out = tmp_path / "out"
    arguments = ["batch", str(folder / "list.csv"), *GIVEN, "--workers", "1", "--output-dir", str(out)]
    assert main([argument for argument in arguments if argument not in ("--wavelength", "589.3nm")]) == 5
    rows = [json.loads(line) for line in (out / "results.jsonl").read_text().splitlines()]
    by_name = {Path(row["path"]).name: row for row in rows}
    assert {name: (row["status"], row.get("quantity")) for name, row in by_name.items()} == {
        "0.png": ("no-scale", "fringe_scale"),
        "1.png": ("no-scale", "fringe_scale"),
        "2.png": ("ok", "wavelength"),
        "pages.tif": ("no-scale", "fringe_scale"),
        "absent.png": ("failed", None),
    }
    assert by_name["2.png"]["value"] == pytest.approx(589.3e-9 * 1.002, rel=2e-3)
    assert by_name["pages.tif"]["page"] == 2
    photos = [folder / "0.png", {"photo": folder / "1.png", "pixel_size": 60e-6}]
    batch = fitting.batch(photos, tmp_path / "r.jsonl", workers=1, wavelength=589.3e-9, pixel_size=30e-6)
    assert [row.status for row in batch.rows] == ["ok", "ok"]
    assert batch.rows[1].value == pytest.approx(4 * 1.001, rel=2e-3)
    assert str(batch) == batch.report()


def test_a_photograph_was_taken_when_its_camera_says_else_when_its_file_was_written(tmp_path):
    for name in ("camera.jpg", "plain.jpg"):
        exif = Image.Exif()
        if name == "camera.jpg":
            exif.get_ifd(0x8769)[0x9003] = "2026:03:04 05:06:07"
        Image.new("L", (8, 8)).save(tmp_path / name, exif=exif)
    moment = datetime(2025, 1, 2, 3, 4, 5)
    os.utime(tmp_path / "plain.jpg", (moment.timestamp(), moment.timestamp()))
    assert photograph_work.taken(tmp_path / "camera.jpg") == "2026-03-04T05:06:07"
    assert photograph_work.taken(tmp_path / "plain.jpg") == "2025-01-02T03:04:05.000"
    assert photograph_work.taken(tmp_path / "absent.jpg") == ""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("photo,path\n", "has a column 'path'; allowed in a manifest: photo, wavelength"),
        (
            "order,diameter_mm\n1,2\n",
            "its first line, 'order, diameter_mm', has no column 'photo'; a table of readings is for `newtonjax rings`",
        ),
        ("photo,pixel_size\na.png,12\n", "line 2: pixel_size is '12' has no unit"),
        ("photo,view\na.png,sideways\n", "line 2: view is 'sideways'; give reflected or transmitted"),
        ("photo,contact\na.png,perhaps\n", "line 2: contact is 'perhaps'; give yes or no"),
        ("photo,page\na.png,0\n", "line 2: page is '0'"),
        ("photo,view\n,\n", "line 2: a line has a photo"),
    ],
)
def test_a_manifest_that_cannot_be_read_is_refused_with_its_line(tmp_path, text, words):
    (tmp_path / "m.csv").write_text(text)
    with pytest.raises(ValueError, match=r"m\.csv") as refused:
        list(manifest.rows_of_manifest(tmp_path / "m.csv", FitOptions()))
    assert words in str(refused.value)


def test_cells_of_a_manifest_replace_options_and_paths_are_relative_to_it(tmp_path):
    text = "photo,pixel_size,scale_from,response,contact,view\na.png,,s.json,c.csv,yes,\n/b.png,2um,,,,transmitted\n"
    (tmp_path / "m.csv").write_text(text)
    options = FitOptions(pixel_size=5e-6, view="reflected", parts={"film": False})
    first, second = manifest.rows_of_manifest(tmp_path / "m.csv", options)
    files = {"scale_from": tmp_path / "s.json", "response": tmp_path / "c.csv"}
    changed = options._replace(pixel_size=None, parts={"film": False, "contact": True}, **files)
    assert first == (tmp_path / "a.png", changed)
    assert second == (Path("/b.png"), options._replace(pixel_size=2e-6, view="transmitted"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "no photographs are named"),
        (("none*.png",), "matches no photograph"),
        (("none.csv",), "none.csv is not a file; give the path of a manifest"),
        (("--follow", "none"), "none is not a folder"),
        ((__file__, "--workers", "0"), "--workers"),
        ((__file__, "--wavelength", "500nm", "--pixel-size", "5um", "--radius", "1m"), "radius"),
        ((__file__, "--scale-from", "none.json"), "none.json is not a file"),
        ((__file__, "--output-dir", __file__), "is a file; name a folder"),
    ],
)
def test_a_batch_that_cannot_work_is_refused_in_one_line(capsys, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert words in refusal(capsys, "batch", *arguments)
    assert not list(tmp_path.rglob("*"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([5],), "a photograph is 5"),
        ((5,), "paths is 5"),
        (([{"photos": "a"}],), "or a mapping with one as 'photo'"),
    ],
)
def test_wrong_photographs_are_refused(tmp_path, untyped, arguments, words):
    with pytest.raises(ValueError, match=words):
        fitting.batch(*arguments, tmp_path / "r.jsonl")


def test_wrong_settings_are_refused_before_the_first_photograph(folder, tmp_path):
    for settings, words in [
        ({"colour": 1}, "colour is no setting"),
        ({"wavelength": -1.0}, "wavelength"),
        ({"workers": 0}, "allowed: 1 to 1024"),
    ]:
        with pytest.raises(ValueError, match=words):
            fitting.batch(folder, tmp_path / "r.jsonl", **settings)


def test_a_folder_is_followed_until_ctrl_c_with_table_and_rows_complete(folder, tmp_path):
    out, photos = tmp_path / "out", tmp_path / "photos"
    photos.mkdir()
    command = ["batch", "--follow", str(photos), *GIVEN, "--workers", "1", "--output-dir", str(out)]
    program = "import sys; from fitting.shell.cli import main\nif __name__ == '__main__': sys.exit(main())"
    process = subprocess.Popen(
        [sys.executable, "-c", program, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    imsave(photos / "0.png", codes(1.0, 1), check_contrast=False)
    end = time.monotonic() + PATIENCE
    while not (out / "chart.png").exists() and time.monotonic() < end and process.poll() is None:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    (line,) = without_progress(errors)
    assert f"{out / 'results.jsonl'} (the same command goes on with it)" in line
    assert "0.png,1," in (out / "summary.csv").read_text()


def test_a_cluster_gives_the_same_rows(folder, tmp_path):
    distributed = pytest.importorskip("distributed", reason="the extra cluster is not installed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as cluster:
        settings = {"wavelength": 589.3e-9, "pixel_size": 30e-6, "view": "reflected"}
        files = [folder / f"{number}.png" for number in range(4)]
        there = fitting.batch(files, tmp_path / "c.jsonl", scheduler=cluster.scheduler_address, **settings)
    own = fitting.batch(files, tmp_path / "l.jsonl", workers=1, **settings)
    assert [(row.path, row.value, row.sd) for row in there.rows] == [(row.path, row.value, row.sd) for row in own.rows]


def test_a_cluster_that_is_not_there_is_named(folder, tmp_path, capsys):
    pytest.importorskip("distributed", reason="the extra cluster is not installed")
    out = str(tmp_path / "out")
    command = ["batch", folder / "0.png", "--scheduler", "tcp://127.0.0.1:9", "--output-dir", out]
    assert "no Dask scheduler answers at tcp://127.0.0.1:9" in refusal(capsys, *command)
