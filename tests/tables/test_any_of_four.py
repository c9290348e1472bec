"""Rings measure any of four: radius, wavelength, pixel size, index of what fills the gap."""

import numpy as np
import pytest
from ring_tables import WAVELENGTH

import fitting
from fitting.shell.cli import main

INDEX, RADIUS, PIXEL, ANGLE = 1.333, 0.9, 4e-6, 0.3
SDS = {"radius": 2e-3, "wavelength": 0.5e-9, "pixel_size": 1e-8, "gap_index": 2e-3, "view_angle": 5e-3}


def rows(unit: float, noise: float = 0.0, seed: int = 0, index: float = INDEX, count: int = 20):
    """Orders and radii of an exact sphere, in units of so many metres."""
    order = np.arange(1.0, count + 1)
    height = order * WAVELENGTH / (2 * np.sqrt(index**2 - np.sin(ANGLE) ** 2))
    radii = np.sqrt(2 * RADIUS * height - height**2) + noise * np.random.default_rng(seed).normal(size=count)
    return {"order": order, ("radius_px" if unit != 1e-3 else "radius_mm"): radii / unit}


def measured(name: str, noise: float = 0.0, seed: int = 0, **changed):
    """A table with all but one quantity given."""
    in_pixels = name != "gap_index"
    given = {"radius": RADIUS, "wavelength": WAVELENGTH, "pixel_size": PIXEL, "gap_index": INDEX} | changed
    given = {key: value for key, value in given.items() if key != name}
    if not in_pixels:
        del given["pixel_size"]
    given |= {f"{key}_sd": SDS[key] for key in given if noise}
    if noise:
        given["view_angle_sd"] = SDS["view_angle"]
    return fitting.rings(rows(PIXEL if in_pixels else 1e-3, noise, seed), view_angle=ANGLE, **given)


@pytest.mark.parametrize(
    ("name", "truth"),
    [("radius", RADIUS), ("wavelength", WAVELENGTH), ("pixel_size", PIXEL), ("gap_index", INDEX)],
)
def test_each_of_four_comes_out_of_the_other_three(name, truth):
    result = measured(name)
    assert (result.status, result.measured) == ("ok", name)
    assert getattr(result, name) == pytest.approx(truth, rel=1e-7)
    assert result.parameters[name].value == getattr(result, name)
    assert f"{name.replace('_', ' ')} = " in result.report()


@pytest.mark.parametrize("name", ["radius", "wavelength", "pixel_size", "gap_index"])
def test_budget_rows_are_derivatives(name):
    result = measured(name, noise=1e-9)
    budget = dict(result.budget)
    for source, sd in SDS.items():
        if source == name or source not in budget:
            continue
        if source == "view_angle":
            continue
        true = {"radius": RADIUS, "wavelength": WAVELENGTH, "pixel_size": PIXEL, "gap_index": INDEX}[source]
        high, low = (getattr(measured(name, **{source: true + step * sd}), name) for step in (0.01, -0.01))
        assert budget[source] == pytest.approx(abs(high - low) / 0.02, rel=2e-3)


@pytest.mark.parametrize("name", ["pixel_size", "gap_index"])
def test_intervals_cover_as_often_as_they_say(name):
    truth = {"pixel_size": PIXEL, "gap_index": INDEX}[name]
    inside = 0
    for seed in range(200):
        table = rows(PIXEL if name == "pixel_size" else 1e-3, 3e-6, seed)
        given = {"gap_index": INDEX} if name == "pixel_size" else {}
        result = fitting.rings(table, wavelength=WAVELENGTH, radius=RADIUS, view_angle=ANGLE, **given)
        low, high = getattr(result, f"{name}_interval")
        inside += low < truth < high
    # 95 % of 200, three standard deviations of a binomial to either side.
    assert 181 <= inside <= 199


def test_a_result_is_saved_with_its_units(tmp_path):
    result = measured("gap_index", noise=1e-6)
    result.save(tmp_path / "rings.json")
    assert fitting.RingsResult.load(tmp_path / "rings.json") == result
    saved = result.to_dict()
    assert saved["gap_index"] == result.gap_index
    assert {"source", "sd"} == set(saved["budget"][0])
    assert measured("pixel_size", noise=1e-6).to_dict()["pixel_size_m"] == pytest.approx(PIXEL, rel=1e-2)


def test_the_shell_measures_the_index_of_a_liquid(tmp_path, capsys):
    path = tmp_path / "water.csv"
    table = rows(1e-3)
    lines = [f"{m:g},{r:.5f}" for m, r in zip(table["order"], table["radius_mm"], strict=True)]
    path.write_text("\n".join(["order,radius_mm", *lines]))
    command = ["rings", str(path), "--wavelength", "589.3nm", "--radius", "900mm", "--view-angle", "0.3rad"]
    assert main(command) == 0
    assert "gap index = 1.333" in capsys.readouterr().out
    assert main([*command, "--gap-index", "1.33"]) == 2
    assert "nothing is left to measure" in capsys.readouterr().err
