"""Results of studies belong to the family of results; a bench without a radius has defaults too."""

import copy
import pickle

import numpy as np
import pytest

import fitting
import newtonjax as nj
from fitting.parameters import AbstractResult

SCENE, CAMERA = nj.newton_rings(2.0, 550e-9, gap=50e-9), nj.Camera((24, 28), 80e-6, exposure=8000.0)
WEDGE, WEDGE_CAMERA = nj.air_wedge(2e-4, 550e-9), nj.Camera((24, 28), 200e-6, exposure=8000.0)
VARY = {"exposure": (1e3, 2e4)}
NAMES = ["information", "undetermined", "sensitivity", "spread", "design", "tradeoff"]


@pytest.fixture(scope="module")
def results() -> dict[str, AbstractResult]:
    return {
        "information": fitting.information(SCENE, CAMERA, sd={"gap": "1%"}),
        "undetermined": fitting.information(SCENE, CAMERA, free=("radius", "pixel_size")),
        "sensitivity": fitting.sensitivity(SCENE, CAMERA, relative_accuracy=1e-6),
        "spread": fitting.spread(SCENE, CAMERA, {"wavelength": "0.1%"}, draws=32),
        "design": fitting.design(SCENE, CAMERA, VARY, starts=1),
        "tradeoff": fitting.tradeoff(SCENE, CAMERA),
    }


@pytest.mark.parametrize("name", NAMES)
def test_a_saved_study_is_loaded_as_it_was(results, name, tmp_path):
    result = results[name]
    result.save(tmp_path / "result.json")
    loaded = type(result).load(tmp_path / "result.json")
    assert loaded == result
    assert loaded.report() == result.report()
    assert loaded.origin == result.origin is not None


@pytest.mark.parametrize("name", NAMES)
def test_a_study_is_short_where_it_is_shown_compared_and_copied(results, name):
    result = results[name]
    assert str(result) == result.report()
    assert len(repr(result).splitlines()) <= 5
    assert type(result).__name__ in repr(result)
    assert pickle.loads(pickle.dumps(result)) == result == copy.copy(result)  # noqa: S301  # it was just made
    assert all((result == other) == (result is other) for other in results.values())


@pytest.mark.parametrize("name", NAMES)
def test_a_study_draws_itself_into_axes(results, name):
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    assert results[name].figure(ax=axes) is axes.figure
    assert axes.has_data() or name == "undetermined"
    assert "data:image/png" in results[name]._repr_html_()


def test_a_study_says_what_it_was_asked(results):
    assert results["information"].origin.given == {"sd": {"gap": "1%"}}
    assert results["design"].origin.given["vary"] == {"exposure": [1e3, 2e4]}
    assert results["design"].origin.sha256 == results["spread"].origin.sha256


def test_a_status_says_what_is_not_determined(results):
    assert results["information"].status == "ok"
    assert results["undetermined"].status == "undetermined"
    assert "only pixel_size^2 / radius is measured" in results["undetermined"].message
    assert "noise alone exceeds the requested accuracy" in results["sensitivity"].warnings[0]


def test_the_angle_of_a_wedge_is_what_its_image_measures():
    """Its bound is that of the fringe period: σ_α/α = σ_f/f for f = 2 α/λ fringes a metre, in closed form."""
    noise = 0.01
    bounds = fitting.information(WEDGE, WEDGE_CAMERA, noise=noise)
    assert bounds.names == ("wedge_angle", "gap", "exposure", "contrast")
    assert bounds.values[0] == pytest.approx(2e-4, rel=1e-12)
    image = np.asarray(nj.render(WEDGE, WEDGE_CAMERA))
    amplitude = (image.max() - image.min()) / 2
    x = (np.arange(28) - 13.5) * 200e-6
    # Phase 2 π (2/λ) α x: in its linear term sin² averages to a half.
    exact = noise / (amplitude * 4 * np.pi / 550e-9 * np.sqrt(24 * (x**2).sum() / 2))
    assert bounds.sd("wedge_angle") == pytest.approx(exact, rel=0.1)


def test_a_wedge_has_defaults_for_every_study():
    found = fitting.sensitivity(WEDGE, WEDGE_CAMERA)
    assert found.target == "wedge_angle"
    wavelength = next(row for row in found.neglected if row.name == "wavelength")
    # α = f λ/2: it grows as the wavelength does.
    assert wavelength.slope == pytest.approx(2e-4 / 550e-9, rel=0.05)
    best = fitting.design(WEDGE, WEDGE_CAMERA, VARY, starts=1)
    assert best.target == "wedge_angle"
    scatter = fitting.spread(WEDGE, WEDGE_CAMERA, {"wavelength": "0.1%"}, draws=32)
    assert scatter.sd == pytest.approx(1e-3 * 2e-4, rel=0.3)
    assert fitting.information(nj.newton_rings(np.inf, gap=1e-6), WEDGE_CAMERA).names[0] == "gap"
