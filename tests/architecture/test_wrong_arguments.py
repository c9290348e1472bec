"""A search with wrong values: no public function answers them with an error from inside."""

import datetime as dt
import decimal
import inspect
import linecache
import traceback
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rings_data import rings

import fitting
import newtonjax as nj

pytestmark = [
    pytest.mark.usefixtures("untyped"),
    pytest.mark.filterwarnings("ignore::PendingDeprecationWarning"),
]
ROOT = Path(__file__).resolve().parents[2]
SCENE, CAMERA = nj.newton_rings(1.0), nj.Camera((16, 16), 20e-6)
IMAGE = rings(shape=(32, 32), pixel_size=30e-6, centre=(15.0, 16.0))
WRONG = [
    *(None, True, -1, 0, 1.5, np.nan, np.inf, -np.inf, 1e300, -1e300, 1e-300, 10**400, "x", "", b"x", 1j, "a" * 5000),
    *([], [1, 2], (1, 2, 3), ((1,), 2), (None, None), (np.nan, np.nan), ("a", "b"), {}, {"a": 1}, {1}, range(3)),
    *(np.zeros(3), np.zeros((2, 2)), np.array("a"), np.array(None, object), np.float16(1), np.int8(-1)),
    *(np.zeros(2, complex), np.full(2, np.nan), np.ma.masked, jnp.ones(()), jnp.ones(2), object()),
    *(Path("none"), dt.date(2000, 1, 1), decimal.Decimal(1), SCENE, CAMERA, "\0"),
]
GIVEN = {
    nj.newton_rings: {},
    nj.air_wedge: {},
    nj.Camera: {"shape": (16, 16), "pixel_size": 1e-5},
    nj.Light: {"wavelength": 5e-7, "polarization": 0.1},
    nj.Surface: {},
    nj.Shield: {"radius": 1e-3},
    nj.CollectingLens: {"focal_length": 0.1, "vertex": (0.0, 0.0, 1.0)},
    nj.Scene: {name: getattr(SCENE, name) for name in ("surfaces", "media", "light", "screen", "beams")},
    nj.choose_beams: {"scene": SCENE, "names": ("R1", "R2")},
    nj.enumerate_beams: {"media": SCENE.media, "view": "reflected", "reflections": 1},
    nj.meeting_height: {"scene": SCENE, "first": "R1", "second": "R2"},
    nj.load_scene: {"path": ROOT / "docs" / "scene.toml"},
    nj.Chebyshev: {},
    nj.Traced: {},
    nj.Splat: {},
    nj.plan: {"scene": SCENE, "camera": CAMERA},
    nj.render: {"scene": SCENE, "camera": CAMERA, "method": nj.ClosedForm()},
    nj.explain: {"scene": SCENE, "camera": CAMERA},
    fitting.read: {"image": IMAGE},
    fitting.fit: {"image": IMAGE, "wavelength": 589.3e-9, "pixel_size": 30e-6, "view": "reflected"},
    fitting.scale: {"image": IMAGE, "division": 1e-4},
    fitting.rings: {
        "table": {"order": [1, 2, 3, 4], "diameter_mm": [1.54, 2.17, 2.66, 3.07]},
        "wavelength": 589.3e-9,
    },
}
CALLS = [(verb, name) for verb in GIVEN for name in inspect.signature(verb).parameters if name not in ("report",)]


def is_on_purpose(error: Exception) -> bool:
    """Whether an error is raised by a line of this project, as one line of text; the system's own of a file too."""
    text = str(error)
    if "\n" in text or len(text) > 700:
        return isinstance(error, OSError) and "\n" not in text
    place = traceback.extract_tb(error.__traceback__)[-1]
    lines = "".join(linecache.getline(place.filename, place.lineno - k) for k in range(6))
    ours = any(Path(place.filename).is_relative_to(ROOT / package) for package in ("newtonjax", "fitting"))
    return isinstance(error, OSError) or (isinstance(error, ValueError) and ours and "raise" in lines)


@settings(max_examples=300, suppress_health_check=list(HealthCheck))
@given(st.sampled_from(CALLS), st.sampled_from(WRONG))
def test_a_wrong_value_is_taken_or_refused_on_purpose_in_one_line(call, value):
    verb, name = call
    try:
        verb(**{**GIVEN[verb], name: value})
    except Exception as error:
        if not is_on_purpose(error):
            raise


@settings(max_examples=20, suppress_health_check=list(HealthCheck))
@given(
    st.sampled_from(["pixel_size", "wavelength", "gap_index"]),
    st.floats(0, 1e3) | st.sampled_from([1e300, 1e-300, np.inf]),
)
def test_no_interval_of_a_radius_reaches_zero_however_uncertain_what_is_given(name, share):
    value = {"pixel_size": 30e-6, "wavelength": 589.3e-9, "gap_index": 1.0}[name]
    known = {**GIVEN[fitting.fit], "gap_index": 1.0, name: value, f"{name}_sd": share * value}
    if not share <= 0.25:
        with pytest.raises(ValueError, match=r"allowed: (up to a quarter of it|zero or a positive number)"):
            fitting.fit(**known)
        return
    result = fitting.fit(**known)
    assert result.status == "ok"
    low, high = result.radius_interval
    assert 0 < low < result.radius < high


def test_no_study_takes_more_memory_than_there_is():
    with pytest.raises(ValueError, match=r"1000000000 x 1000000000 pixels needs .* are available; allowed: a smaller"):
        fitting.information(SCENE, nj.Camera((10**9, 10**9), 1e-12))


def test_random_numbers_take_a_seed_that_is_one():
    result = fitting.fit(IMAGE, wavelength=589.3e-9, pixel_size=30e-6, view="reflected")
    for call in (
        lambda: fitting.sample(result, steps=8, seed=-1),
        lambda: fitting.spread(SCENE, CAMERA, {"pixel_size": "0.1%"}, draws=32, seed=-1),
    ):
        with pytest.raises(ValueError, match="seed is -1; allowed: 0 to 4294967295"):
            call()


@pytest.mark.parametrize("progress", [np.ones(2), "yes", 3])
def test_progress_is_a_word_or_a_function(progress):
    with pytest.raises(ValueError, match=r"progress is .*; allowed: True, a function of .*, or None"):
        fitting.fit(IMAGE, wavelength=589.3e-9, pixel_size=30e-6, progress=progress)
