"""Rows of a form's budget that count only where the picture shows their cause."""

import numpy as np
import pytest

import fitting
from experiments.truth.form_pictures import Fault, picture, random_form


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
