"""The verb `rings` of the shell: what it prints, writes and refuses."""

import csv
import json

import pytest
from ring_tables import RINGS, table, written

from fitting.shell import lamps
from fitting.shell.cli import main


def test_the_verb_prints_writes_and_exits(tmp_path, capsys):
    rows, file = table(noise=0.01), tmp_path / "rings.csv"
    with file.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["ring", "D"])
        writer.writerows(zip(rows["order"], rows["diameter_mm"], strict=True))
    named = ["--column", "order=ring", "--column", "diameter_mm=D"]
    command = ["rings", str(file), "--wavelength", "589.3nm", *named]
    assert main([*command, "--json", "-"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["radius_m"] == pytest.approx(1.0, abs=4 * answer["radius_sd_m"])
    assert {"order", "radius_m", "residual_m", "flag"} == set(answer["rings"][0])
    assert main([*command, "--output-dir", str(tmp_path / "out")]) == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "result.png",
        "report.html",
        "report.txt",
        "result.json",
    }
    assert main([*command, "--output-dir", str(tmp_path / "out")]) == 2
    assert "--force" in capsys.readouterr().err
    assert main([*command, "--column", "radius"]) == 2
    assert main(["rings", str(tmp_path / "none.csv"), "--wavelength", "589.3nm"]) == 2
    assert "is not a file" in capsys.readouterr().err


def test_the_lamp_brings_its_standard_deviation(tmp_path):
    path = written(tmp_path, "order,diameter_mm\n" + RINGS)
    budgets = []
    for name, options in (("lamp", []), ("zero", ["--wavelength-sd", "0nm"]), ("wide", ["--wavelength-sd", "0.6nm"])):
        answer = tmp_path / f"{name}.json"
        assert main(["rings", str(path), "--wavelength", "sodium", *options, "--json", str(answer)]) == 0
        result = json.loads(answer.read_text())
        budgets.append({row["source"]: row["sd_m"] / result["radius_m"] for row in result["budget"]})
    assert budgets[0]["wavelength"] == pytest.approx(lamps.wavelength("sodium").sd / 589.3e-9, rel=1e-3)
    assert "wavelength" not in budgets[1]
    assert budgets[2]["wavelength"] == pytest.approx(0.6 / 589.3, rel=1e-3)


def test_refusals_of_the_command_name_the_reason(tmp_path, capsys):
    path = tmp_path / "wedge.csv"
    path.write_text("order,diameter (mm)\n" + "".join(f"{m},{0.5 + 0.1 * m}\n" for m in range(1, 20)))
    assert main(["rings", str(path), "--wavelength", "sodium"]) == 3
    assert "equidistant fringes" in capsys.readouterr().err
    path.write_text("order,diameter (mm)\n1,2.54\n5,3.53\n")
    assert main(["rings", str(path), "--radius", "672.41mm", "--radius-sd", "2mm"]) == 0
    assert "wavelength = 558.561 nm" in capsys.readouterr().out
    assert main(["rings", str(path)]) == 2
    assert "give wavelength to measure the radius" in capsys.readouterr().err
