"""A stack of frames: rows against the truth and against a fit alone, frames that are lost, where frames come from."""

import imageio.v3 as iio
import numpy as np
import pytest
import tifffile
from rings_data import added_path

import fitting
from fitting.photo import frames_of, reading

WAVELENGTH, PIXEL, SIZE, NOISE = 589.3e-9, 10e-6, 128, 4.0
GIVEN = {"wavelength": WAVELENGTH, "pixel_size": PIXEL, "view": "reflected", "transfer": "linear"}
HALF = WAVELENGTH / 2
ROWS, COLUMNS = np.mgrid[:SIZE, :SIZE].astype(float)


def rings(radius=0.08, gap=0.0, centre=(66.0, 60.0), noise=NOISE, seed=0, dust=False):
    """One frame in eight bits: reflected fringes of a sphere under a microscope; nothing of this project in it."""
    random = np.random.default_rng(seed)
    r2 = ((COLUMNS - centre[0]) ** 2 + (ROWS - centre[1]) ** 2) * PIXEL**2
    thickness = gap + r2 / radius / (1 + np.sqrt(1 - r2 / radius**2))
    path = 2 * thickness + added_path(r2 / radius**2, thickness, gap, "reflected")
    light = 110 - 70 * np.cos(2 * np.pi * path / WAVELENGTH) + random.normal(0, noise, r2.shape)
    if dust:
        light[np.random.default_rng(9).random(r2.shape) < 0.02] = 20
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


def drift(count, **changes):
    """Truth of each frame: radius, gap and centre on their way."""
    way = np.linspace(0, 1, count)
    return [
        {
            "radius": 0.08 * (1 + 0.02 * t),
            "gap": 1.1e-7 + 1.5e-6 * t,
            "centre": (66.0 - 4 * t, 60.0 + 3 * t),
            "seed": k,
            **changes,
        }
        for k, t in enumerate(way)
    ]


@pytest.fixture(scope="module")
def drifting():
    """Truths and rows of forty frames whose radius, gap and centre all change."""
    truths = drift(40)
    return truths, list(fitting.fit_stack(np.stack([rings(**truth) for truth in truths]), **GIVEN))


def test_each_row_of_a_drifting_stack_scatters_about_the_truth_as_it_says(drifting):
    truths, rows = drifting
    assert [row.index for row in rows] == list(range(40))
    assert {row.status for row in rows} == {"ok"}
    assert [row.searched for row in rows] == [True, *[False] * 39]
    # What is assumed of glass and gap goes for all frames alike, and scatters nothing. Whole waves that a frame does
    # not tell make the radius larger by 4 1/4 of their length.
    budget = dict(fitting.fit(rings(**truths[0]), **GIVEN).budget)
    alike = np.hypot(budget.get("glass looked through", 0.0), budget["whole waves of the gap"])
    away = {"radius": [], "gap": [], "x": [], "y": []}
    for truth, row in zip(truths, rows, strict=True):
        assert abs(row.radius - truth["radius"]) < 4 * row.radius_sd
        scattered, waves = np.sqrt(row.radius_sd**2 - alike**2), np.floor(truth["gap"] / HALF + 0.25) * HALF
        away["radius"].append((row.radius - truth["radius"] - 4.25 * waves) / scattered)
        away["gap"].append((row.gap - truth["gap"]) / row.gap_sd)
        for k, axis in enumerate("xy"):
            away[axis].append((row.centre_px[k] - truth["centre"][k]) / row.centre_sd_px[k])
    for name, values in away.items():
        # Of forty normal deviates the scatter is 1 within 0.11, and one beyond 4 comes once in four hundred stacks.
        assert 0.65 < np.std(values) < 1.4, name
        assert np.abs(values).max() < 4, name
        assert abs(np.mean(values)) < 0.6, name


def test_the_gap_is_followed_over_many_half_wavelengths_both_ways():
    steps = [0, 1, 2, 3, 4, 5, 6, 7, 8, 7, 6, 5]
    # An eighth of a wavelength a frame: a quarter turn, at which the fringes' place alone does not tell the way.
    frames = np.stack([rings(gap=k * WAVELENGTH / 8, seed=k) for k in steps])
    gaps = [row.gap for row in fitting.fit_stack(frames, **GIVEN)]
    assert gaps == pytest.approx([k * WAVELENGTH / 8 for k in steps], abs=2e-9)


@pytest.mark.parametrize("dust", [False, True])
def test_a_row_is_what_a_fit_alone_gives(dust):
    frames = [rings(**truth) for truth in drift(12, dust=dust)]
    for number, row in enumerate(fitting.fit_stack(iter(frames), **GIVEN)):
        if number % 4 == 3:
            alone = fitting.fit(frames[number], **GIVEN)
            apart = (row.gap - alone.gap + HALF / 2) % HALF - HALF / 2
            assert abs(row.radius - alone.radius) < 0.1 * alone.radius_sd
            assert abs(apart) < 0.1 * alone.parameters["gap"].sd
            assert row.centre_px == pytest.approx(alone.centre_px, abs=1e-3)
            assert row.explained_variance == pytest.approx(alone.explained_variance, abs=1e-3)
            assert row.radius_sd == pytest.approx(alone.radius_sd, rel=0.25)


def test_what_is_given_with_a_deviation_is_in_the_row_as_in_a_fit():
    given = {**GIVEN, "pixel_size_sd": 2e-8, "wavelength_sd": 1e-10}
    frames = [rings(**truth) for truth in drift(3)]
    row = list(fitting.fit_stack(frames, **given))[-1]
    alone = fitting.fit(frames[-1], **given)
    assert row.radius_sd == pytest.approx(alone.radius_sd, rel=0.01)
    assert row.radius_sd_image < row.radius_sd / 5
    assert row.parameters["radius"].sd == row.radius_sd


def test_another_quantity_than_the_radius_is_measured_and_without_a_scale_the_fringes_are():
    frames = [rings(**truth) for truth in drift(3)]
    given = {"wavelength": WAVELENGTH, "view": "reflected", "transfer": "linear"}
    size = next(fitting.fit_stack(frames, radius=0.08, **given))
    assert size.measured == "pixel_size"
    assert abs(size.parameters["pixel_size"].value - PIXEL) < 4 * size.parameters["pixel_size"].sd
    rows = list(fitting.fit_stack(frames, **given))
    assert [row.status for row in rows] == ["no-scale"] * 3
    for row, truth in zip(rows, drift(3), strict=True):
        scale = PIXEL**2 / (truth["radius"] * WAVELENGTH)
        # What a microscope adds goes with the slope of the sphere, and so with a scale: up to 2e-4 of these fringes.
        assert row.fringe_scale_per_px2 == pytest.approx(scale, abs=4 * row.fringe_scale_sd + 2e-4 * scale)
        assert row.radius is None


def test_frames_that_hold_no_rings_are_rows_with_a_reason_and_the_stack_goes_on():
    bad = {
        3: (np.zeros((SIZE, SIZE), np.uint8), "uniform"),
        4: (np.full((SIZE, SIZE), 255, np.uint8), "saturated"),
        5: (rings()[:-2], "shape"),
        6: (np.random.default_rng(0).normal(20, 2, (SIZE, SIZE)).astype(np.uint8), "dark or blank"),
        7: (rings().astype(np.uint16), "uint16"),
        8: (np.array([["x"]]), "shape"),
        9: (np.random.default_rng(0).integers(40, 180, (SIZE, SIZE)).astype(np.uint8), "search"),
        13: ("nowhere.png", "nowhere.png is not a file"),
    }
    # Slow enough that the rings after seven lost frames are still near those before.
    truths = drift(150)[:16]
    frames = [bad[k][0] if k in bad else rings(**truth) for k, truth in enumerate(truths)]
    rows = list(fitting.fit_stack(frames, **GIVEN))
    assert len(rows) == 16
    for row, truth in zip(rows, truths, strict=True):
        if row.index in bad:
            assert row.status in ("refused", "not-converged")
            assert bad[row.index][1] in row.message
            assert row.radius is None
        else:
            assert (row.status, row.message) == ("ok", "")
            assert abs(row.radius - truth["radius"]) < 4.5 * row.radius_sd
            assert abs(row.gap - truth["gap"]) < 4.5 * row.gap_sd


def test_frames_that_are_no_numbers_are_rows_with_a_reason():
    frames = [rings(**truth).astype(float) for truth in drift(4)]
    frames[1][:] = np.nan
    frames[2][: SIZE // 4] = np.nan
    rows = list(fitting.fit_stack(frames, **GIVEN))
    assert [row.status for row in rows] == ["ok", "refused", "ok", "ok"]
    assert "no numbers" in rows[1].message


def test_rings_that_jumped_are_searched_anew_and_followed_from_there():
    places = [{"centre": (66.0, 60.0)}] * 3 + [{"centre": (90.0, 30.0), "radius": 0.06}] * 3
    rows = list(fitting.fit_stack([rings(seed=k, **place) for k, place in enumerate(places)], **GIVEN))
    assert [row.searched for row in rows] == [True, False, False, True, False, False]
    assert "searched anew" in rows[3].message
    for row, place in zip(rows, places, strict=True):
        assert row.status == "ok"
        assert row.centre_px == pytest.approx(place["centre"], abs=0.1)


def test_a_stack_may_begin_with_frames_that_hold_nothing():
    nothing = np.zeros((SIZE, SIZE), np.uint8)
    rows = list(fitting.fit_stack([nothing, nothing, rings(), rings(seed=1)], **GIVEN))
    assert [row.status for row in rows] == ["refused", "refused", "ok", "ok"]


# Where frames come from


def test_a_file_of_pages_or_frames_gives_what_its_array_gives(tmp_path):
    frames = np.stack([rings(**truth) for truth in drift(4)])
    tifffile.imwrite(tmp_path / "stack.tif", frames, photometric="minisblack")
    iio.imwrite(tmp_path / "stack.gif", frames)
    paths = [tmp_path / f"{k}.png" for k in range(4)]
    for path, frame in zip(paths, frames, strict=True):
        iio.imwrite(path, frame)
    wanted = [row.radius for row in fitting.fit_stack(frames, **GIVEN)]
    for source in (tmp_path / "stack.tif", str(tmp_path / "stack.gif"), paths, (frame for frame in frames)):
        assert [row.radius for row in fitting.fit_stack(source, **GIVEN)] == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("name", ["stack.tif", "stack.gif"])
def test_a_fit_of_a_file_with_several_pictures_says_that_it_took_the_first(tmp_path, name):
    frames = np.stack([rings(**truth) for truth in drift(3)])
    for pictures, several in ((frames, True), (frames[0], False)):
        if name.endswith("tif"):
            tifffile.imwrite(tmp_path / name, pictures, photometric="minisblack")
        else:
            iio.imwrite(tmp_path / name, pictures)
        assert any("fit_stack" in text for text in reading.read(tmp_path / name).warnings) == several


def test_colour_frames_are_read_by_one_channel():
    grey = np.stack([rings(**truth) for truth in drift(3)])
    dim = np.full_like(grey, 9)
    colours = np.stack([grey, dim, dim], axis=-1)
    rows = list(fitting.fit_stack(colours, **GIVEN))
    assert [row.radius for row in rows] == [row.radius for row in fitting.fit_stack(grey, **GIVEN)]


def test_a_page_that_is_damaged_is_a_row_and_the_next_is_read(tmp_path):
    path = tmp_path / "stack.tif"
    frames = np.stack([rings(seed=k) for k in range(3)])
    tifffile.imwrite(path, frames, photometric="minisblack", compression="deflate")
    with tifffile.TiffFile(path) as file:
        offset = file.pages[1].dataoffsets[0]
    data = bytearray(path.read_bytes())
    data[offset : offset + 40] = b"\xff" * 40
    path.write_bytes(data)
    one, two, three = frames_of(path)
    assert np.array_equal(one, frames[0])
    assert isinstance(two, ValueError)
    assert "cannot be read" in str(two)
    assert np.array_equal(three, frames[2])


def test_a_file_that_is_no_picture_is_refused_at_once_in_one_line(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("no picture")
    with pytest.raises(ValueError, match=r"notes\.txt cannot be read as frames \(.*\); allowed: an array") as refusal:
        fitting.fit_stack(path, **GIVEN)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("frames", "given", "message"),
    [
        (np.zeros((20, 20)), {}, "of one image use fit"),
        (np.zeros((20, 20, 3)), {}, "of one image use fit"),
        (3.0, {}, "allowed: an array"),
        ([], {"wavelength": -1.0}, "wavelength is -1"),
        ([], {"view": "sideways"}, "sideways"),
        ([], {"parts": {"ghost": True}}, "ghost"),
        ([], {"radius": 1.0}, "nothing is left to measure"),
        ([], {"fixed": {"radius": 1.0}}, "fixed is"),
        ([], {"priors": {"radius": (1.0, 0.1)}}, "'radius' has no prior"),
        ([], {"axis_px_sd": 3.0}, "without axis_px"),
        ([], {"view_angle": 0.1, "parts": {"oblique_view": False}}, "view_angle is that of oblique_view"),
        ([], {"view_angle": 0.1, "priors": {"stretch": (0.0, 0.1)}}, "both say how the rings are stretched"),
    ],
)
def test_arguments_that_cannot_be_used_are_refused_before_any_frame(frames, given, message):
    with pytest.raises(ValueError, match=message):
        fitting.fit_stack(frames, **{**GIVEN, **given})


def test_a_path_that_is_no_file_is_refused():
    with pytest.raises(FileNotFoundError, match=r"nowhere\.tif is not a file"):
        fitting.fit_stack("nowhere.tif", **GIVEN)


def test_a_row_becomes_a_plain_dictionary():
    row = next(fitting.fit_stack([rings()], **GIVEN)).to_dict()
    assert (row["index"], row["status"], row["searched"]) == (0, "ok", True)
    assert row["parameters"]["radius"]["value"] == row["radius"]


def test_a_real_file_of_phase_steps_is_measured_frame_by_frame(shared):
    """Four pages made with a radius of 0.3 m and a gap that grows by an eighth of a wavelength."""
    given = {"wavelength": WAVELENGTH, "pixel_size": 12e-6, "view": "reflected"}
    rows = list(fitting.fit_stack(shared / "trials" / "stepped_stack.tif", **given))
    assert [row.status for row in rows] == ["ok"] * 4
    assert [row.radius for row in rows] == pytest.approx([0.3] * 4, rel=2e-3)
    assert np.diff([row.gap for row in rows]) == pytest.approx([WAVELENGTH / 8] * 3, abs=5e-9)


def test_without_a_scale_a_distorted_view_has_the_scale_of_the_mean_of_the_field_as_in_a_fit():
    given = {"wavelength": WAVELENGTH, "view": "reflected", "transfer": "linear", "parts": {"distortion": True}}
    frames = [rings(seed=k) for k in range(3)]
    row = list(fitting.fit_stack(frames, **given))[-1]
    alone = fitting.fit(frames[-1], **given)
    assert abs(row.fringe_scale_per_px2 - alone.fringe_scale_per_px2) < 0.1 * alone.fringe_scale_sd
    assert row.fringe_scale_sd == pytest.approx(alone.fringe_scale_sd, rel=0.25)


@pytest.mark.parametrize(
    ("known", "told"),
    [
        ({"priors": {"distortion": (0.0, 1e-3)}}, "distortion"),
        ({"priors": {"distortion": (0.0, 1e-3)}, "axis_px": (70.0, 60.0)}, "axis_x"),
        ({"view_angle": 0.0}, "stretch"),
        ({"view_angle": 0.2, "view_angle_sd": 0.02}, "stretch"),
    ],
)
def test_what_is_known_of_parts_axis_and_view_is_in_a_row_as_in_a_fit(known, told):
    frames = [rings(seed=k) for k in range(3)]
    row = list(fitting.fit_stack(frames, **GIVEN, **known))[-1]
    alone = fitting.fit(frames[-1], **GIVEN, **known)
    assert alone.priors[told]["source"] == "user"
    assert abs(row.radius - alone.radius) < 0.3 * alone.radius_sd
    assert row.radius_sd == pytest.approx(alone.radius_sd, rel=0.3)
    for name in {"radius_along", "radius_across"} & set(alone.parameters):
        assert row.parameters[name].value == pytest.approx(alone.parameters[name].value, abs=row.parameters[name].sd)
    assert ("radius_along" in row.parameters) == ("view_angle" in known)
