"""The page `report.html` of each verb that measures something, and of what it refuses."""

import hashlib
import re

import imageio.v3 as iio
import numpy as np
import pytest
from rings_data import rings

from fitting.shell.cli import main

_SODIUM = ("--wavelength", "sodium")
_LIGHT = (*_SODIUM, "--pixel-size", "5um", "--transfer", "linear")
_COLUMN, _ROW = np.arange(320.0), np.arange(320.0)[:, None]


def _grey(image) -> np.ndarray:
    noise = np.random.default_rng(1).normal(0, 0.01, image.shape)
    return np.uint8(np.clip(255 * (image + noise), 0, 255))


def _wedge() -> np.ndarray:
    return _grey(0.5 + 0.4 * np.cos(2 * np.pi * (_COLUMN / 22.0 + _ROW / 60.0)))


def _grid() -> np.ndarray:
    lines = [np.abs((place + 8) % 20 - 10) < 2 for place in (_COLUMN + 0 * _ROW, _ROW + 0 * _COLUMN)]
    return _grey(0.8 - 0.6 * (lines[0] | lines[1]))


def _form() -> np.ndarray:
    x, y = (_COLUMN - 160) / 140, (_ROW - 160) / 140
    fringes = 0.5 + 0.4 * np.cos(2 * np.pi * (8 * x + 0.6 * (x * x + y * y)))
    return _grey(np.where(np.hypot(x, y) < 1, fringes, 0.02))


def _noise() -> np.ndarray:
    return _grey(np.random.default_rng(0).uniform(0.2, 0.8, (320, 320)))


_TABLE = "order,diameter_mm\n" + "\n".join(f"{m},{2e3 * (m * 589.3e-9) ** 0.5:.4f}" for m in range(3, 14))
_STRAIGHT = "order,position_mm\n" + "\n".join(f"{m},{0.5 * m + 0.003 * (-1) ** m:.4f}" for m in range(12))


@pytest.mark.parametrize(
    ("verb", "source", "options", "status", "words"),
    [
        ("fit", _noise, _LIGHT, 3, ("refused", "Photograph")),
        ("rings", _TABLE, _SODIUM, 0, ("Budget of radius [m]", "radius = ", "Result")),
        ("rings", "order,diameter_mm\n1,1.5", _SODIUM, 3, ("refused", "Readings")),
        ("wedge", _STRAIGHT, _SODIUM, 0, ("Budget of wedge angle, relative", "wedge angle = ")),
        (
            "wedge",
            _STRAIGHT,
            (*_SODIUM, "--length", "42mm", "--length-sd", "1mm"),
            0,
            ("Budget of thickness, relative", "length"),
        ),
        ("wedge", _wedge, _LIGHT, 0, ("Budget of wedge angle, relative", "wedge angle = ", "pixel_size")),
        ("wedge", _noise, _LIGHT, 3, ("refused", "Photograph")),
        ("scale", _grid, ("--division", "0.1mm"), 0, ("Budget of pixel size [m]", "pixel size = ", "0.0001 m")),
        ("scale", _noise, ("--division", "0.1mm"), 3, ("refused", "Photograph")),
        ("form", _form, _SODIUM, 0, ("Budget of power, rms [fringe spacings]", "power A = ")),
        ("form", _noise, (), 3, ("refused", "Photograph")),
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
