"""The virtual bench behind the page: pictures of its sliders, and the numbers beside them."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from fitting.shell.page import bench_tasks


def draw(**values) -> np.ndarray:
    picture = bench_tasks.draw(Path(), print, values)
    return np.asarray(Image.open(io.BytesIO(picture)))


def test_the_first_picture_is_dark_in_the_middle_and_grey():
    image = draw()
    assert image.shape == (512, 512)
    assert image[256, 256] < 10
    assert image.max() > 240


def test_transmitted_rings_are_bright_in_the_middle():
    assert draw(view="transmitted")[256, 256] > 240


def test_light_of_several_lines_is_in_colour():
    image = draw(light="mercury")
    assert image.shape == (512, 512, 3)
    assert np.ptp(image.astype(int), axis=2).max() > 50


@pytest.mark.parametrize("view", ["reflected", "transmitted"])
def test_radii_of_dark_rings_are_those_of_the_exact_sphere(view):
    rings = bench_tasks.describe(Path(), print, {"radius": 2.0, "pixel_size": 20.0, "view": view})["rings"]
    height = [(ring["order"] + 0.5 * (view == "transmitted")) * 589.3e-9 / 2 for ring in rings]
    exact = [np.sqrt(2 * 2.0 * h - h * h) for h in height]
    assert len(rings) == 12
    # Between pixels of 20 µm the square is interpolated by straight lines; the first dark spot is half a pixel wide.
    assert [ring["radius_m"] for ring in rings[1:]] == pytest.approx(exact[1:], rel=1e-4)


def test_fringes_finer_than_two_pixels_are_said_and_nothing_is_foretold_of_them():
    # Fringes 2 r / (R λ) per metre reach half a turn a pixel of 16 µm at r = 3.68 mm of a radius of 0.2 m.
    about = bench_tasks.describe(Path(), print, {"radius": 0.2})
    y, x = np.indices((512, 512)) - 255.5
    # The path is 2 t = r²/R: along an axis it grows by 2 x s²/(R λ) a pixel.
    share = np.mean(np.maximum(np.abs(x), np.abs(y)) * 2 * 16e-6**2 / (0.2 * 589.3e-9) > 0.5)
    assert about["warning"].startswith(f"In {share:.0%} of the picture fringes are finer than two pixels")
    assert about["bounds"] == ""
    plain = bench_tasks.describe(Path(), print, {})
    assert plain["warning"] == ""
    assert "radius" in plain["bounds"]


def difference(image: np.ndarray, other: np.ndarray) -> float:
    """Of two lines of pixels, in the mean, in codes."""
    return float(np.abs(image.astype(float) - other.astype(float)).mean())


def test_a_second_radius_makes_the_rings_of_that_radius_across_the_first():
    toroid, sphere, flatter = draw(across=1.5), draw(), draw(radius=1.5)
    # Coding as JPEG moves a pixel by a few codes; other rings differ by a hundred.
    assert difference(toroid[256], sphere[256]) < 10 < difference(toroid[256], flatter[256])
    assert difference(toroid[:, 256], flatter[:, 256]) < 10 < difference(toroid[:, 256], sphere[:, 256])


def test_curvatures_of_lens_and_plate_add():
    curved, steep = draw(plate=1.0, pixel_size=8.0), draw(radius=0.5, pixel_size=8.0)
    assert difference(curved[256], steep[256]) < 10 < difference(curved[256], draw(pixel_size=8.0)[256])


def test_every_way_to_the_picture_is_compared():
    table = bench_tasks.compare(Path(), print, {})
    assert "ClosedForm" in table
    assert "the reference" in table


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"radius": 1e9}, "allowed: 0.2 to 5 m"),
        ({"radius": "1"}, "allowed: 0.2 to 5 m"),
        ({"radius": float("nan")}, "allowed: 0.2 to 5 m"),
        ({"screen": 1.0}, "no slider"),
        ({"view": "sideways"}, "allowed views"),
        ({"light": "/etc/lamp.csv"}, "lights: sodium"),
        ({"across": 1.5, "conic": 1.0}, "set one of these two sliders back"),
    ],
)
def test_what_no_slider_gives_is_refused(values, words):
    with pytest.raises(ValueError, match=words):
        draw(**values)
