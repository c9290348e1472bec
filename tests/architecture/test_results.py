"""Results are one family: report, short text, file, comparison, copy, notebook, and where each one comes from."""

import copy
import hashlib
import pickle

import numpy as np
import pytest

import fitting
from fitting.parameters import AbstractResult

READINGS = {"order": [1, 2, 3, 4], "diameter_mm": [1.54, 2.17, 2.66, 3.07]}


def picture(shape=(90, 110)) -> np.ndarray:
    y, x = np.mgrid[: shape[0], : shape[1]]
    turns = ((x - 52.0) ** 2 + (y - 44.0) ** 2) * 1.6e-3
    return 0.5 - 0.3 * np.cos(2 * np.pi * turns) + np.random.default_rng(0).normal(0, 0.01, shape)


def grid() -> np.ndarray:
    y, x = np.mgrid[:200, :260].astype(float)
    turns = [(np.cos(t) * x + np.sin(t) * y) / 15.7 for t in (0.17, 0.17 + np.pi / 2)]
    lines = [np.exp(-(((t - np.round(t)) * 12) ** 2)) for t in turns]
    return 0.4 + 0.5 * np.maximum(*lines) + np.random.default_rng(1).normal(0, 0.02, x.shape)


def a_chain() -> fitting.Chain:
    values = np.random.default_rng(2).normal([1.0, 20.0], [0.1, 1.0], (40, 8, 2))
    return fitting.Chain(
        ("radius", "centre_x_px"),
        values,
        values[:, :, 0],
        np.array([2.0, 3.0]),
        100.0,
        0.3,
        np.array([1.0, 1.01]),
        "not-converged",
        "too short",
    )


@pytest.fixture(scope="module")
def results() -> dict[str, AbstractResult]:
    return {
        "rings": fitting.rings(READINGS, wavelength=589.3e-9),
        "rings in pixels": fitting.rings({"order": [1, 2, 3], "radius_px": [100, 141, 173]}, wavelength=589.3e-9),
        "no rings": fitting.rings({"order": [1, 1], "radius_mm": [1.0, 1.1]}, wavelength=589.3e-9),
        "scale": fitting.scale(grid(), division=0.2e-3),
        "no grid": fitting.scale(picture(), division=0.2e-3),
        "fit": fitting.fit(picture(), wavelength=589.3e-9, pixel_size=10e-6, pixel_size_sd=5e-8, view="reflected"),
        "fringe scale": fitting.fit(picture(), wavelength=589.3e-9),
        "no fringes": fitting.fit(np.ones((40, 40))),
        "chain": a_chain(),
    }


NAMES = [
    *("rings", "rings in pixels", "no rings", "scale", "no grid", "fit", "fringe scale", "no fringes", "chain"),
]


@pytest.mark.parametrize("name", NAMES)
def test_a_saved_result_is_loaded_as_it_was(results, name, tmp_path):
    result = results[name]
    result.save(tmp_path / "result.json")
    loaded = type(result).load(tmp_path / "result.json")
    assert loaded == result
    assert loaded.report() == result.report()
    assert loaded.origin == result.origin
    with pytest.raises(FileExistsError):
        result.save(tmp_path / "result.json")
    result.save(tmp_path / "result.json", force=True)


@pytest.mark.parametrize("name", NAMES)
def test_a_result_is_short_where_it_is_shown_and_whole_where_it_is_printed(results, name):
    result = results[name]
    assert str(result) == result.report()
    assert len(repr(result).splitlines()) <= 5
    assert type(result).__name__ in repr(result)
    assert f"<pre>{result.report().splitlines()[0][:12]}" in result._repr_html_()


@pytest.mark.parametrize("name", NAMES)
def test_results_are_compared_by_what_they_say_and_copied(results, name):
    result = results[name]
    assert pickle.loads(pickle.dumps(result)) == result == copy.copy(result)  # noqa: S301  # it was just made
    assert all((result == other) == (result is other) for other in results.values())
    assert result != 3


def test_a_result_says_what_it_comes_from(tmp_path, results):
    (tmp_path / "readings.csv").write_text("order,diameter_mm\n1,1.54\n2,2.17\n3,2.66\n")
    origin = fitting.rings(tmp_path / "readings.csv", wavelength=589.3e-9).origin
    assert origin is not None
    assert origin.file == "readings.csv"
    assert origin.sha256 == hashlib.sha256((tmp_path / "readings.csv").read_bytes()).hexdigest()
    assert origin.given["wavelength"] == 589.3e-9
    assert "pixel_size" not in origin.given
    assert results["fit"].origin.given["pixel_size"] == 10e-6


def test_what_is_not_such_a_result_is_refused_with_the_file(tmp_path, results):
    results["rings"].save(tmp_path / "rings.json")
    with pytest.raises(ValueError, match=r"rings.json does not hold a saved Scale: .*it is a RingsResult"):
        fitting.Scale.load(tmp_path / "rings.json")
    (tmp_path / "text.json").write_text("no JSON")
    with pytest.raises(ValueError, match=r"text.json does not hold a saved FitResult"):
        fitting.FitResult.load(tmp_path / "text.json")
    with pytest.raises(FileNotFoundError, match=r"none.json is not a file"):
        fitting.FitResult.load(tmp_path / "none.json")


def test_a_result_draws_itself_into_axes(results):
    from matplotlib.figure import Figure

    for name in ("rings", "scale", "fit"):
        axes = Figure().subplots()
        assert results[name].figure(ax=axes) is axes.figure
        assert axes.has_data()
        assert results[name].figure().axes
    with pytest.raises(ValueError, match="has no photograph"):
        fitting.FitResult.from_dict(results["fit"].to_dict()).figure()


@pytest.mark.parametrize(
    ("name", "answer", "given"),
    [("rings", "radius", "wavelength"), ("scale", "pixel_size", "division"), ("fit", "radius", "pixel_size")],
)
def test_parameters_say_name_unit_and_whether_they_were_given(results, name, answer, given):
    result = results[name]
    measured, stated = result.parameters[answer], result.parameters[given]
    assert (measured.name, measured.unit, measured.fixed) == (answer, "m", False)
    assert (measured.value, measured.sd) == (getattr(result, answer), getattr(result, f"{answer}_sd"))
    assert (stated.name, stated.unit, stated.fixed) == (given, "m", True)
    assert str(stated).endswith("m (given)")
    assert result.to_dict()["parameters"][answer]["unit"] == "m"


def test_parameters_of_a_file_of_an_earlier_version_get_their_names_and_units(results):
    saved = results["fringe scale"].to_dict()
    for row in saved["parameters"].values():
        del row["name"], row["unit"]
    loaded = fitting.FitResult.from_dict(saved)
    assert loaded.parameters == results["fringe scale"].parameters
    assert loaded.parameters["centre_x_px"].unit == "px"
