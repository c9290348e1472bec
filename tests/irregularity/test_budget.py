"""Rows of a form's budget that count only where the picture shows their cause."""

import numpy as np
import pytest

import fitting
from experiments.truth.form_pictures import Fault, picture, random_form
from fitting.irregularity.budget import distortion_row
from fitting.irregularity.projection import nodes
from fitting.irregularity.zernike import terms_at


@pytest.fixture(scope="module", params=[1010, 1014])
def forms(request):
    """Of a saddle in light whose visibility varies, without and with a blur of 2 px."""
    return [saddle(request.param, fault) for fault in (Fault(), Fault(blur=2.0))]


def saddle(seed, fault):
    rng = np.random.default_rng([seed, 15, 0])
    scene = picture(random_form("saddle", 15, rng), 512, 0.05, rng, fault)
    return fitting.form(scene.image, pupil=scene.pupil)


def test_a_blur_is_a_row_and_a_visibility_that_varies_is_none(forms):
    sharp, blurred = ({name: row["irregularity"] for name, row in form.budget.items()} for form in forms)
    assert sharp["blur"] < 0.1 * sharp["noise"]
    assert blurred["blur"] > 0.3 * blurred["noise"]


def test_noise_alone_makes_no_row_of_the_edge(forms):
    assert forms[0].budget["edge"]["irregularity"] == 0


@pytest.mark.parametrize("kappa", [0.05, -0.05])
def test_the_row_of_a_distortion_leads_from_the_form_that_is_seen_to_the_true_one(kappa):
    """Terms of degree 2 seen through it are polynomials of degree 6, so that 28 terms hold them exactly."""
    true = np.array([0.2, 3.0, -1.0, 6.0, 0.5, -0.3])
    u, v, _ = nodes()
    scale = 1 + kappa * (u**2 + v**2 - 1)
    seen = np.linalg.lstsq(terms_at(u, v, 28), terms_at(u * scale, v * scale, 6) @ true, rcond=None)[0]
    odd, even = distortion_row(seen, abs(kappa)).changes
    # The second row is that of a normal distortion, whose fourth moment is 3.
    answer = seen + np.sign(kappa) * odd + even / np.sqrt(3)
    np.testing.assert_allclose(answer, np.pad(true, (0, 22)), atol=1e-12)
    assert np.abs(even).max() > 0.01
