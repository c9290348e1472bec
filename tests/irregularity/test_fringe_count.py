"""Pictures of too few fringes are told from others before any form is looked for."""

import numpy as np
import pytest

import fitting
from fitting.irregularity.disc import Pupil
from fitting.irregularity.fringe_count import LEAST_COUNT, fringe_count

SIZE, RADIUS = 220, 90.0
PUPIL = Pupil(108.0, 111.0, RADIUS)


def picture(form: tuple[float, float, float], falloff: float = 0.0, noise: float = 0.03) -> np.ndarray:
    """Fringes of the form a u + b u² + c v² [turns] in light that falls to exp(-falloff) at the rim, dark beyond."""
    v, u = ((at - middle) / RADIUS for at, middle in zip(np.mgrid[:SIZE, :SIZE], (PUPIL.y, PUPIL.x), strict=True))
    light = np.exp(-falloff * (u**2 + v**2))
    phase = form[0] * u + form[1] * u**2 + form[2] * v**2
    image = np.where(u**2 + v**2 <= 1, light * (1 + 0.7 * np.cos(2 * np.pi * phase)), 0.02)
    return image + np.random.default_rng(3).normal(0, noise, image.shape)


def count(image: np.ndarray) -> float | None:
    return fringe_count(image, np.ones(image.shape, bool), PUPIL)


def test_a_stepped_picture_of_three_fringes_is_refused_because_they_are_few():
    image = picture((1.4, 0.25, 0.25))
    result = fitting.form(image, pupil=tuple(PUPIL), pupil_sd=0.5)
    assert (result.status, result.fringes) == ("refused", None)
    assert "fringes, some of them perhaps uneven light: at least 6 are required" in result.message


def test_a_tilt_has_its_number_of_fringes():
    # Central differences see sin x / x of it, x = 2 pi 10 / 180: 2 % less.
    assert count(picture((5.0, 0.0, 0.0), noise=0.0)) == pytest.approx(10, rel=0.05)


@pytest.mark.parametrize("falloff", [0.0, 1.0, 2.3])
@pytest.mark.parametrize(
    "form",
    [(4.0, 0.0, 0.0), (0.0, 4.0, 4.0), (0.0, 4.0, -4.0), (0.0, 8.0, 0.0)],
    ids=["tilt", "bowl", "saddle", "cylinder"],
)
def test_eight_fringes_are_not_few_however_uneven_their_light(form, falloff):
    assert count(picture(form, falloff)) > 1.2 * LEAST_COUNT


def test_fringes_too_fine_for_the_reduced_picture_are_not_judged():
    y, x = np.mgrid[:900, :900]
    image = 1 + 0.7 * np.cos(2 * np.pi * x / 8.5) + 1e-3 * y
    assert fringe_count(image, np.ones(image.shape, bool), Pupil(450.0, 450.0, 440.0)) is None


def test_stepped_frames_of_a_trial_hold_too_few_fringes(shared):
    result = fitting.form(shared / "trials" / "stepped_1.jpg")
    assert result.status == "refused"
    assert "at least 6 are required" in result.message
