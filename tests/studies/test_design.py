"""Designs: the forecast is the whole image's, its slopes are right, limits hold and are named, and no grid beats it."""

import csv
import json

import numpy as np
import pytest
from compilations import compilations
from shell import refusal

import fitting
import newtonjax as nj
from fitting.shell.cli import main
from fitting.studies.design_job import DesignTask
from fitting.studies.prospects import LIMITS, Limits, deviations, forecast, prospects

SCENE = nj.newton_rings(2.0, 550e-9, 0.3e-6, "reflected", screen="gap")
CAMERA = nj.Camera((200, 240), 20e-6)
VARY = {"wavelength": (400e-9, 700e-9), "field": (1e-3, 20e-3), "pixel_size": (5e-6, 80e-6), "exposure": (1e3, 1e6)}
KNOWN = {"wavelength": 1e-12, "gap_index": "0.0001%"}
LIMIT = Limits(2.5, 0.9, 0.5, np.inf)


@pytest.fixture(scope="module")
def job():
    return DesignTask(SCENE, CAMERA, VARY, {}, "radius", None, KNOWN, None)


def attained(job: DesignTask, design) -> tuple[float, float]:
    """Relative deviation from the whole image, with what is known and by noise alone."""
    told = fitting.information(*job.bench_of(design, 2.0), free=(*job.free, *job.given))
    known = [
        value * sd if share else sd
        for value, sd, share in zip(told.values[6:], job.deviations, job.relative, strict=True)
    ]
    noise, total = deviations(told.matrix, 6, np.array(known))
    return float(total) / 2.0, float(noise) / 2.0


@pytest.fixture(scope="module")
def found():
    with compilations() as compiled:
        made = fitting.design(SCENE, CAMERA, VARY, sd=KNOWN, starts=2)
    assert compiled.count == 0
    return made


def test_the_forecast_is_that_of_the_whole_image(job):
    for design in (job.before, job.before * np.array([1.1, 0.8, 0.9, 2.0])):
        fast, _ = prospects(job.layout(9, 64), job.bench(LIMIT), design, job.over)
        total, noise = attained(job, design)
        assert float(np.exp(fast.total[0])) == pytest.approx(total, rel=0.02)
        assert float(np.exp(fast.noise[0])) == pytest.approx(noise, rel=0.02)


def test_a_centre_is_told_in_pixels_of_the_camera(job):
    for design in (job.before, job.before * np.array([1.0, 0.6, 1.0, 1.0])):
        aside = DesignTask(SCENE, CAMERA, VARY, {}, "centre_x", None, {}, None)
        fast = forecast(aside.layout(9, 96), aside.bench(LIMIT), design, aside.over)
        told = fitting.information(*aside.bench_of(design, aside.over[0]), free=aside.free)
        assert float(np.exp(fast.noise[0])) * aside.over[0] == pytest.approx(told.sd("centre_x"), rel=0.03)


def test_slopes_are_those_of_differences_at_the_design_too(job, found):
    """There limits and bounds are active."""
    layout, bench = job.layout(9, 64), job.bench(LIMIT)
    for design in (job.before, np.array(list(found.values.values()))):
        _, slope = prospects(layout, bench, design, job.over)
        for k in range(len(design)):
            step = 1e-6 * design[k] * np.eye(len(design))[k]
            (ahead, _), (back, _) = (prospects(layout, bench, design + s * step, job.over) for s in (1, -1))
            for name in ("total", "noise", "used"):
                by_step = (np.asarray(getattr(ahead, name)) - np.asarray(getattr(back, name))) / (2e-6 * design[k])
                exact = np.asarray(getattr(slope, name))[..., k]
                scale = np.abs(np.asarray(getattr(ahead, name))).max() / design[k]
                np.testing.assert_allclose(by_step, exact, rtol=1e-4, atol=1e-6 * scale)


def test_no_grid_finds_a_better_one(job, found):
    axes = [np.geomspace(low, high, 6) for low, high in VARY.values()]
    best = np.inf
    layout, bench = job.layout(9, 64), job.bench(LIMIT)
    designs = np.stack([axis.ravel() for axis in np.meshgrid(*axes)], axis=1)[::5]
    _, field, pixel_size, _ = designs.T
    within_sensor = field / pixel_size <= min(CAMERA.shape)
    assert 100 < within_sensor.sum() < 200
    for design in designs[within_sensor]:
        value = forecast(layout, bench, design, job.over)
        if np.all(np.asarray(value.used) <= 1):
            best = min(best, float(np.exp(value.total[0])))
    assert np.isfinite(best)
    assert found.relative_sd < 1.001 * best
    assert found.relative_sd < found.before_sd


def test_it_keeps_the_limits_and_says_what_binds(found):
    assert all(used <= 1.001 for used in found.used.values())
    assert found.bindings
    for one in found.bindings:
        assert one.gain > 0
        if one.side == "limit":
            assert found.used[one.name] == pytest.approx(1.0, abs=0.02)
        else:
            assert found.values[one.name] == pytest.approx(VARY[one.name][one.side == "high"], rel=1e-2)
    assert "active constraint:" in str(found)
    rows, columns = found.camera.shape
    assert rows <= 200
    assert rows * float(found.camera.pixel_size) == pytest.approx(found.values["field"], rel=0.01)
    assert columns == pytest.approx(1.2 * rows, abs=1)
    told = fitting.information(found.scene, found.camera)
    assert told.sd("radius") / 2.0 == pytest.approx(found.noise_sd, rel=0.01)


def test_a_range_of_radii_and_a_list_of_wavelengths():
    vary = {"field": (1e-3, 4e-3), "exposure": (1e3, 1e6)}
    worst = fitting.design(SCENE, CAMERA, vary, over=(1.0, 2.0, 4.0), choose={"wavelength": (450e-9, 650e-9)}, starts=1)
    assert worst.values["wavelength"] in (450e-9, 650e-9)
    assert worst.over == (1.0, 2.0, 4.0)
    chosen = fitting.design(SCENE, CAMERA, {}, choose={"wavelength": (450e-9, 650e-9)}, starts=1)
    assert chosen.values == {"wavelength": 450e-9}
    mean = fitting.design(
        SCENE, CAMERA, vary, over=(1.0, 2.0, 4.0), robust="mean", choose={"wavelength": (450e-9, 650e-9)}, starts=1
    )
    assert mean.relative_sd <= worst.relative_sd * 1.001


@pytest.mark.parametrize(
    ("vary", "more", "message"),
    [
        ({}, {}, "nothing varies; allowed: field, radius"),
        ({"colour": (1, 2)}, {}, "'colour' is not a number of this scene"),
        ({"field": (2e-3, 1e-3)}, {}, "field varies from 0.002 to 0.001"),
        ({"field": (0.0, 1e-3)}, {}, "allowed: above zero"),
        ({"field": (1e-3, 2e-3)}, {"choose": {"wavelength": (-450e-9,)}}, "allowed: above zero"),
        ({"field": (1e-3, 2e-3)}, {"choose": {"wavelength": (np.nan,)}}, "allowed: finite numbers"),
        ({"stray": (0.1, 1.0)}, {}, "'stray' is not a number of this scene"),
        ({"field": (1e-3, 2e-3)}, {"fill_fraction": 5.0}, "fill_fraction is 5.0; allowed: at most 1"),
        ({"field": (1e-3, 2e-3)}, {"rings": (60, 3)}, "allowed: fewer at least than at most"),
        ({"field": (1e-3, 2e-3)}, {"sd": {"plate_tilt_x": "5%"}}, "plate_tilt_x is 0"),
        ({"radius": (1.0, 2.0)}, {}, "radius is given twice"),
        ({"field": (1e-3, 2e-3)}, {"sd": {"exposure": 1.0}}, "exposure is free"),
        ({"field": (1e-3, 2e-3)}, {"sd": {"wavelength": "1 nm"}}, "allowed: a standard deviation in its unit"),
        ({"field": (1e-3, 2e-3)}, {"robust": "best"}, "allowed: 'worst' or 'mean'"),
        ({"field": (1e-3, 2e-3)}, {"over": (0.0,)}, "allowed: values of the radius"),
        (
            {"field": (1e-3, 1.1e-3)},
            {"rings": (100, 200), "starts": 1},
            "no design within the bounds meets the limits: rings_least",
        ),
    ],
)
def test_it_refuses_with_a_line(vary, more, message):
    with pytest.raises(ValueError, match=message):
        fitting.design(SCENE, CAMERA, vary, **more)


def test_the_verb_prints_and_writes_a_bench(tmp_path, capsys):
    path, folder = tmp_path / "scene.toml", tmp_path / "out"
    nj.save_scene(path, SCENE, CAMERA)
    vary = ("--vary", "field=1mm:4mm", "exposure=1e3:1e6")
    assert main(["design", str(path), *vary, "--starts", "1", "--output-dir", str(folder)]) == 0
    assert "relative sd" in capsys.readouterr().out
    answer = json.loads((folder / "design.json").read_text())
    with (folder / "design.csv").open(newline="") as file:
        assert [row["name"] for row in csv.DictReader(file)] == ["field", "exposure", "radius_relative_sd"]
    assert set(answer["used"]) == set(LIMITS)
    scene, camera = nj.load_scene(folder / "design.toml")
    assert camera.shape == tuple(answer["shape"])
    assert float(scene.wavelength) == 550e-9
    assert (folder / "design.png").read_bytes().startswith(b"\x89PNG")
    assert "is there already" in refusal(capsys, "design", path, *vary, "--output-dir", folder)
    assert "give LOW:HIGH" in refusal(capsys, "design", path, "--vary", "field=1mm")
    assert "has no unit" in refusal(capsys, "design", path, "--vary", "field=1:2")
    assert "nothing varies" in refusal(capsys, "design", path)
    assert "give LEAST:MOST" in refusal(capsys, "design", path, *vary, "--rings", "many")


def test_a_design_of_nothing_free_is_refused_at_once():
    with pytest.raises(ValueError, match="free is empty; allowed: one name or more"):
        fitting.design(SCENE, CAMERA, {"field": (1e-3, 2e-3)}, free=[])
