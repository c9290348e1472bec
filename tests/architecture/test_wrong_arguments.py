"""A search with wrong values: no public function answers them with an error from inside."""

import datetime as dt
import decimal
import inspect
import linecache
import traceback
import warnings
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rings_data import rings

import fitting
import newtonjax as nj
from fitting.parameters import AbstractResult

pytestmark = [
    pytest.mark.usefixtures("untyped"),
    pytest.mark.filterwarnings("ignore::PendingDeprecationWarning"),
]
ROOT = Path(__file__).resolve().parents[2]
SCENE, CAMERA = nj.newton_rings(1.0), nj.Camera((16, 16), 20e-6)
# Nearly five fringes: half as many may be uneven light, and are refused.
PIXEL = 40e-6
IMAGE = rings(shape=(32, 32), pixel_size=PIXEL, centre=(15.0, 16.0))
# A second one: none counts twice.
MIRRORED = IMAGE[::-1]
WRONG = [
    *(None, True, -1, 0, 1.5, np.nan, np.inf, -np.inf, 1e300, -1e300, 1e-300, 10**400, "x", "", b"x", 1j, "a" * 5000),
    *([], [1, 2], (1, 2, 3), ((1,), 2), (None, None), (np.nan, np.nan), ("a", "b"), {}, {"a": 1}, {1}, range(3)),
    *(np.zeros(3), np.zeros((2, 2)), np.array("a"), np.array(None, object), np.float16(1), np.int8(-1)),
    *(np.zeros(2, complex), np.full(2, np.nan), np.ma.masked, jnp.ones(()), jnp.ones(2), object()),
    *(Path("none"), dt.date(2000, 1, 1), decimal.Decimal(1), SCENE, CAMERA, "\0"),
]


def expose(image, key):
    """A photograph of an image: the method of a camera, which has no hash."""
    return CAMERA.expose(image, key)


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
    fitting.form: {"image": IMAGE},
    fitting.fit: {"image": IMAGE, "wavelength": 589.3e-9, "pixel_size": PIXEL, "view": "reflected"},
    fitting.scale: {"image": IMAGE, "division": 1e-4},
    fitting.wedge: {
        "table": {"order": [1, 2, 3, 4, 5], "position_mm": [0.0, 0.14, 0.27, 0.41, 0.54]},
        "wavelength": 589.3e-9,
    },
    nj.cos_turns: {"phase": 0.25},
    expose: {"image": np.ones((16, 16)), "key": jax.random.key(0)},
    fitting.rings: {
        "table": {"order": [1, 2, 3, 4], "diameter_mm": [1.54, 2.17, 2.66, 3.07]},
        "wavelength": 589.3e-9,
    },
}
# Right values take these seconds, so fewer are tried.
SLOW = {
    fitting.fit_together: {"images": [IMAGE, MIRRORED], "wavelength": 589.3e-9, "view": "reflected"},
    fitting.ratio: {"first": IMAGE, "second": MIRRORED, "wavelength": 589.3e-9, "view": "reflected"},
    fitting.fit_stack: {"frames": np.stack([IMAGE, MIRRORED]), "wavelength": 589.3e-9, "view": "reflected"},
    # An aperture of fewer pixels than a form takes, so that no right call looks for one.
    fitting.plate_test: {"images": IMAGE, "pupil": (15.0, 15.0, 14.0), "plate_radius": 0.25, "wavelength": 589.3e-9},
    fitting.information: {"scene": SCENE, "camera": CAMERA},
    fitting.sensitivity: {"scene": SCENE, "camera": CAMERA},
    fitting.derivative_images: {"scene": SCENE, "camera": CAMERA, "names": ("radius",)},
    fitting.measurement: {"scene": SCENE, "camera": CAMERA},
    fitting.spread: {"scene": SCENE, "camera": CAMERA, "sd": {"pixel_size": "0.1%"}, "draws": 16},
    fitting.design: {"scene": SCENE, "camera": CAMERA, "vary": {"field": (1e-3, 8e-3)}, "starts": 1},
    fitting.tradeoff: {"scene": SCENE, "camera": CAMERA},
    nj.splat: {"scene": SCENE, "camera": CAMERA},
    nj.opd: {"scene": SCENE, "camera": CAMERA, "method": nj.Chebyshev(5)},
    nj.sweep: {"bench": nj.newton_rings, "values": {"radius": [1.0, 2.0]}, "camera": CAMERA},
    nj.normal_equations: {
        "bench": lambda numbers: nj.newton_rings(numbers[0]),
        "parameters": np.array([1.0]),
        "camera": CAMERA,
    },
}


def arguments(verbs) -> list:
    """Each function with each of its arguments."""
    return [(verb, name) for verb in verbs for name in inspect.signature(verb).parameters if name != "report"]


# `pytest --hypothesis-profile long` searches through fifty times as many.
EXAMPLES = settings.default.max_examples
KINDS = ["f2", "f4", "f8", "i1", "u1", "u2", "i8", "?", "c16", "O", "U3", "M8[s]", "m8[s]", ">f8", ">u2"]
FACTORS = st.sampled_from([0.1, 0.5, 0.999, 2.0, 10.0, 1e3, 1e-3, -1.0, 0.0, np.nan, np.inf])


@st.composite
def arrays(draw):
    """Arrays of any type and shape, empty ones too; plain, masked, of JAX, matrices, lists, backwards."""
    shape = draw(st.lists(st.sampled_from([0, 1, 2, 3, 16, 32]), max_size=3))
    fill = draw(st.sampled_from([0.0, 1.0, -1.0, np.nan, np.inf, 1e300, 1e-300]))
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        array = np.full(shape, fill).astype(draw(st.sampled_from(KINDS)))
        if array.ndim and draw(st.booleans()):
            array = array[::-1]
        form = draw(st.sampled_from([np.asarray, np.ma.asarray, np.ndarray.tolist, np.asmatrix, jnp.asarray]))
        try:
            return form(array)
        except (TypeError, ValueError):  # no matrix of three axes, no array of texts in JAX
            return array


NUMBERS = st.floats() | st.integers() | st.sampled_from([1e300, 1e-300, 10**400, 45, 589.3, True])
VALUES = st.deferred(
    lambda: (
        st.sampled_from(WRONG)
        | NUMBERS
        | st.text(max_size=5)
        | arrays()
        | st.lists(NUMBERS | arrays() | VALUES, max_size=4)
        | st.dictionaries(st.sampled_from(["radius", "order", "gap", "pixel_size", "view", "x"]), VALUES, max_size=3)
    )
)


@st.composite
def neighbours(draw, value):
    """A right value with one part of it replaced or scaled; or a wrong one."""
    if isinstance(value, dict) and value:
        name = draw(st.sampled_from(sorted(value)))
        return {**value, name: draw(neighbours(value[name]))}
    if type(value) in (list, tuple) and value:
        place = draw(st.integers(0, len(value) - 1))
        return type(value)([*value[:place], draw(neighbours(value[place])), *value[place + 1 :]])
    if isinstance(value, np.ndarray) and value.ndim:
        kind = draw(st.sampled_from(["f2", "f4", "i1", "u1", "u2", "i8", "?", ">f8"]))
        with np.errstate(all="ignore"):
            changes = [value[:1], value[..., None], value * draw(FACTORS), value.astype(kind), value.tolist()]
        return draw(st.sampled_from([*changes, np.ma.masked_less(value, np.median(value))]))
    if isinstance(value, float):
        return draw(FACTORS.map(lambda factor: factor * value) | VALUES)
    return draw(VALUES)


def is_on_purpose(error: Exception) -> bool:
    """Whether an error is raised by a line of this project, as one line of text; the system's own of a file too."""
    text = str(error)
    if "\n" in text or len(text) > 700:
        return isinstance(error, OSError) and "\n" not in text
    place = traceback.extract_tb(error.__traceback__)[-1]
    lines = "".join(linecache.getline(place.filename, place.lineno - k) for k in range(6))
    ours = any(Path(place.filename).is_relative_to(ROOT / package) for package in ("newtonjax", "fitting"))
    return isinstance(error, OSError) or (isinstance(error, ValueError) and ours and "raise" in lines)


def calls(table):
    """A function of a table with right arguments, one of them in its place wrong."""

    def of(call):
        verb, name = call
        right = table[verb].get(name)
        values = VALUES if right is None else neighbours(right) | VALUES
        return st.tuples(st.just(verb), values.map(lambda value: {**table[verb], name: value}))

    return st.sampled_from(arguments(table)).flatmap(of)


def take_or_refuse(verb, given):
    """Call a function. Raises what is no refusal, and AssertionError for an interval that reaches zero."""
    try:
        answer = verb(**given)
        answers = list(answer) if verb is fitting.fit_stack else [answer]
    except Exception as error:
        if not is_on_purpose(error):
            raise
        return
    for answer in answers:
        for name in ("radius", "wavelength", "pixel_size"):
            low, high = getattr(answer, f"{name}_interval", None) or (1.0, 1.0)
            assert 0 < low <= high < np.inf
        if isinstance(answer, AbstractResult):
            assert "nan" not in answer.report().split()
            assert answer.to_dict()


@settings(max_examples=3 * EXAMPLES, suppress_health_check=list(HealthCheck))
@given(calls(GIVEN))
def test_a_wrong_value_is_taken_or_refused_on_purpose_in_one_line(call):
    take_or_refuse(*call)


@settings(max_examples=EXAMPLES // 4, suppress_health_check=list(HealthCheck))
@given(calls(SLOW))
def test_so_it_is_by_studies_and_stacks(call):
    take_or_refuse(*call)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: nj.lamp("a" * 5000), "light 'aaa"),
        (lambda: nj.lamp("sodium", None), "ambient_index is None; allowed: 0.1 to 10"),
        (lambda: nj.coating("a" * 5000), "is no layer; allowed: "),
        (lambda: nj.illuminant("a" * 5000), "allowed: A, E"),
        (lambda: nj.black_body([]), r"temperature is \[\]; allowed: "),
        (lambda: nj.spectral_line(5e-7, shape=np.ma.masked_array([])), "shape is masked_array"),
        (lambda: nj.sampled_spectrum([4e-7, 5e-7], {}), "powers is {}; allowed: a number for each of the 2"),
        (lambda: nj.Extent(0.01, "square", radiances=[[1, 2], [3]]), "radiances is "),
        (lambda: nj.Spectrum([4e-7], [1.0], lorentzian=[{}, np.ones((2, 3))]), "lorentzian is "),
        (lambda: fitting.scale(points=10**400, distance=1e-3), "points is a huge integer"),
    ],
)
def test_light_and_points_are_refused_in_one_line(call, words):
    with pytest.raises(ValueError, match=words) as caught:
        call()
    assert is_on_purpose(caught.value)


def test_a_camera_has_one_size_of_pixels():
    with pytest.raises(ValueError, match=r"pixel_size is array.*; allowed: a positive length in metres, one number"):
        nj.Camera((4, 4), np.array([1e-5, 2e-5]))


@pytest.mark.parametrize("saved", [None, [], {}, {"kind": "Scale"}, {"status": "ok", "message": "", "warnings": []}])
def test_what_is_no_saved_result_is_refused_in_one_line(saved):
    for kind in (fitting.FitResult, fitting.RingsResult, fitting.Information, fitting.Chain):
        with pytest.raises(ValueError, match=f"allowed: the dictionary that {kind.__name__}|no dictionary that"):
            kind.from_dict(saved)


@settings(max_examples=20, suppress_health_check=list(HealthCheck))
@given(
    st.sampled_from(["pixel_size", "wavelength", "gap_index"]),
    st.floats(0, 1e3) | st.sampled_from([1e300, 1e-300, np.inf]),
)
def test_no_interval_of_a_radius_reaches_zero_however_uncertain_what_is_given(name, share):
    value = {"pixel_size": PIXEL, "wavelength": 589.3e-9, "gap_index": 1.0}[name]
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
    result = fitting.fit(IMAGE, wavelength=589.3e-9, pixel_size=PIXEL, view="reflected")
    for call in (
        lambda: fitting.sample(result, steps=8, seed=-1),
        lambda: fitting.spread(SCENE, CAMERA, {"pixel_size": "0.1%"}, draws=32, seed=-1),
    ):
        with pytest.raises(ValueError, match="seed is -1; allowed: 0 to 4294967295"):
            call()


@pytest.mark.parametrize("progress", [np.ones(2), "yes", 3])
def test_progress_is_a_word_or_a_function(progress):
    with pytest.raises(ValueError, match=r"progress is .*; allowed: True, a function of .*, or None"):
        fitting.fit(IMAGE, wavelength=589.3e-9, pixel_size=PIXEL, progress=progress)
