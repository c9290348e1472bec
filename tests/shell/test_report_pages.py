"""The page `report.html` of each verb that measures something, and of what it refuses."""

import hashlib
import re

import imageio.v3 as iio
import numpy as np
import pytest
from report_sources import STRAIGHT, TABLE, form, grid, noise, wedge
from rings_data import rings

from fitting.shell.cli import main

_SODIUM = ("--wavelength", "sodium")
_LIGHT = (*_SODIUM, "--pixel-size", "5um", "--transfer", "linear")


@pytest.mark.parametrize(
    ("verb", "source", "options", "status", "words"),
    [
        ("fit", noise, _LIGHT, 3, ("refused", "Photograph")),
        ("rings", TABLE, _SODIUM, 0, ("Budget of radius [m]", "radius = ", "Result")),
        ("rings", "order,diameter_mm\n1,1.5", _SODIUM, 3, ("refused", "Readings")),
        ("wedge", STRAIGHT, _SODIUM, 0, ("Budget of wedge angle, relative", "wedge angle = ")),
        (
            "wedge",
            STRAIGHT,
            (*_SODIUM, "--length", "42mm", "--length-sd", "1mm"),
            0,
            ("Budget of thickness, relative", "length"),
        ),
        ("wedge", wedge, _LIGHT, 0, ("Budget of wedge angle, relative", "wedge angle = ", "pixel_size")),
        ("wedge", noise, _LIGHT, 3, ("refused", "Photograph")),
        ("scale", grid, ("--division", "0.1mm"), 0, ("Budget of pixel size [m]", "pixel size = ", "0.0001 m")),
        ("scale", noise, ("--division", "0.1mm"), 3, ("refused", "Photograph")),
        ("form", form, _SODIUM, 0, ("Budget of power, rms [fringe spacings]", "power A = ")),
        ("form", noise, (), 3, ("refused", "Photograph")),
    ],
)
def test_the_page_of_a_verb(verb, source, options, status, words, tmp_path, capsys):
    file = tmp_path / ("table.csv" if isinstance(source, str) else "picture.png")
    if isinstance(source, str):
        file.write_text(source)
    else:
        iio.imwrite(file, source())
    assert main([verb, str(file), *options, "--output-dir", str(tmp_path / "out")]) == status, capsys.readouterr()
    check((tmp_path / "out" / "report.html").read_text(encoding="utf-8"), [file], words)


def test_the_page_of_two_photographs(tmp_path):
    files = [tmp_path / "first.png", tmp_path / "second.png"]
    for seed, file in enumerate(files):
        iio.imwrite(file, np.uint8(np.clip(255 * rings(noise=0.02, seed=seed), 0, 255)))
    assert main(["together", *map(str, files), *_LIGHT, "--output-dir", str(tmp_path / "out")]) == 0
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    check(page, files, ("Budget of ratio", "ratio, second over first", "first.png and 1 more"))


def check(page: str, files, words) -> None:
    for file in files:
        assert hashlib.sha256(file.read_bytes()).hexdigest() in page
    for word in (*words, "How to get it again", "date", "data:image/webp", "light-dark"):
        assert word in page
    text = re.sub(r"base64,[^\"]*", "", page)
    assert not re.search(r"\bnan\b|https?://|src=\"(?!data:)", text)
    assert len(page) < 300_000
