"""Reports in a browser: nothing serious by axe, no wider than a phone, two pages of A4, and small."""

import re
import tomllib
from importlib.resources import files

import numpy as np
import pytest
from browsing import SIZES, check_access
from report_sources import TABLE, form, grid, noise, picture_file, wedge

from experiments.truth.plate_pictures import LOOK, plate_picture, random_part
from fitting.shell.cli import main

# A report with pictures is to be small enough for a mail [bytes].
LARGEST = 300_000
SODIUM = ("--wavelength", "sodium")
VERBS = ("fit", "rings", "scale", "wedge", "form", "testplate", "refusal")


def command_of(kind: str, folder) -> list[str]:
    """A command that leaves a report of this kind in "out"."""
    if kind == "fit":
        about = tomllib.loads((files("fitting") / "data" / "sample.toml").read_text())["given"]
        known = ["--wavelength", f"{about['wavelength']}m", "--pixel-size", f"{about['pixel_size']}m"]
        return ["fit", str(files("fitting") / "data" / "sample.png"), *known, "--view", "reflected"]
    if kind == "rings":
        (folder / "table.csv").write_text(TABLE)
        return ["rings", str(folder / "table.csv"), *SODIUM]
    if kind == "testplate":
        rng = np.random.default_rng(3)
        picture = plate_picture(random_part(1.0, 0.1, rng, 0.5), rng, LOOK._replace(size=160))
        file = picture_file(folder / "plate.png", np.uint8(np.clip(110 * picture.image, 0, 255)))
        circle = ",".join(f"{number:g}" for number in picture.pupil)
        known = ["--plate-radius", "250mm", "--wavelength", "546.1nm", "--diameter", "50mm", "--transfer", "linear"]
        return ["testplate", str(file), *known, "--pupil", circle, "--rings-move", "outwards"]
    verb, source, options = {
        "scale": ("scale", grid, ("--division", "0.1mm")),
        "wedge": ("wedge", wedge, (*SODIUM, "--pixel-size", "5um", "--transfer", "linear")),
        "form": ("form", form, SODIUM),
        "refusal": ("fit", noise, (*SODIUM, "--pixel-size", "5um", "--transfer", "linear")),
    }[kind]
    return [verb, str(picture_file(folder / "picture.png", source())), *options]


@pytest.mark.parametrize("kind", VERBS)
def test_a_report_is_open_to_everybody_small_and_two_pages_of_a4(kind, browser, tmp_path, capsys):
    status = main([*command_of(kind, tmp_path), "--output-dir", str(tmp_path / "out")])
    assert status == (3 if kind == "refusal" else 0), capsys.readouterr().err
    report = tmp_path / "out" / "report.html"
    assert report.stat().st_size <= LARGEST
    for scheme in ("light", "dark"):
        for size in SIZES.values():
            window = browser.new_page(viewport=size, color_scheme=scheme)
            window.goto(report.as_uri())
            check_access(window)
            window.close()
    window = browser.new_page()
    window.goto(report.as_uri())
    printed = window.pdf(format="A4")
    window.close()
    assert len(re.findall(rb"/Type\s*/Page\b", printed)) <= 2
