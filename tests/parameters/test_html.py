"""The page of a fit: answer, budget, model, pictures, and what it takes to get it again."""

import hashlib
import re
from functools import partial

import imageio.v3 as iio
import numpy as np
from rings_data import rings

import fitting
from fitting.shell.cli import main


def test_the_page_holds_the_answer_its_budget_and_its_history(tmp_path, capsys):
    photo = tmp_path / "rings & plate.png"
    iio.imwrite(photo, np.uint8(np.clip(255 * rings(noise=0.02), 0, 255)))
    given = ["--wavelength", "sodium", "--pixel-size", "5um", "--pixel-size-sd", "10nm", "--transfer", "linear"]
    assert main(["fit", str(photo), *given, "--output-dir", str(tmp_path / "out")]) == 0
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    report = (tmp_path / "out" / "report.txt").read_text(encoding="utf-8")
    assert hashlib.sha256(photo.read_bytes()).hexdigest() in page
    assert "rings &amp; plate.png" in page
    assert "rings & plate" not in page
    assert "[[Words]]\n    fringe scale: s²" in report
    assert "[[Words]]" not in page
    assert re.search(r"radius = [0-9.]+ ± [0-9.e-]+ m", page)[0] in report
    for words in (
        "Budget of radius",
        "pixel_size",
        "oblique_view",
        "by how much rings, or pixels, are longer along x",
        "largest: pixel_size",
        "newtonjax",
        "data:image/webp",
    ):
        assert words in page
    assert "nan" not in re.sub(r"base64,[^\"]*", "", page)
    assert len(page) < 300_000
    assert '<html lang="en">' in page
    assert page.count("<img ") == page.count('<img alt="') == 1
    capsys.readouterr()


def test_mcmc_leaves_chain_corner_and_trace(tmp_path, capsys, monkeypatch):
    """A chain of a fifth of the usual length: it is too short for an interval, and leaves the same files."""
    monkeypatch.setattr(fitting, "sample", partial(fitting.sample, steps=400))
    photo, out = tmp_path / "rings.png", tmp_path / "out"
    iio.imwrite(photo, np.uint8(np.clip(255 * rings(noise=0.02), 0, 255)))
    given = [
        "--wavelength",
        "sodium",
        "--pixel-size",
        "5um",
        "--pixel-size-sd",
        "10nm",
        "--view",
        "reflected",
        "--mcmc",
    ]
    assert main(["fit", str(photo), *given, "--output-dir", str(out)]) == 0
    names = {path.name for path in out.iterdir()}
    pictures = {"corner.png", "result.png", "trace.png"}
    tables = {"bright_rings.csv", "dark_rings.csv"}
    assert names == {"chain.h5", "report.html", "report.txt", "result.json", *pictures, *tables}
    assert "[[Posterior]]" in capsys.readouterr().out
    assert '"posterior"' in (out / "result.json").read_text(encoding="utf-8")
