"""The form of a surface from frames stepped in phase: steps and light unknown, the frame that contradicts named."""

import json

import numpy as np
import pytest
from scipy.optimize import least_squares
from skimage.restoration import unwrap_phase

import fitting
from fitting.irregularity.frames import frames_of_surface
from fitting.irregularity.joint_frames import refit_frames
from fitting.irregularity.phase_steps import starts
from fitting.irregularity.stepped import best_fit, chosen_frames, with_own
from fitting.irregularity.zernike import polar_values
from fitting.shell.cli import main

SIZE, TERMS = 128, 15
STEPS = np.array([0.0, 0.21, 0.55, 0.78])
FORM = np.array([0.0, 0.4, -0.2, 0.05, -0.03, 0.15, 0.01, 0.0, 0.02, -0.01, 0.008, 0.0, 0.005, 0.0, 0.01])
PUPIL = ((SIZE - 1) / 2, (SIZE - 1) / 2, 61.0)


def frames(steps=STEPS, changes=None, noise=0.02, seed=0):
    """Frames of uneven, speckled light, each with a form of its own where `changes` say so."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[:SIZE, :SIZE].astype(float)
    u, v = (u - PUPIL[0]) / PUPIL[2], (v - PUPIL[1]) / PUPIL[2]
    inside = np.hypot(u, v) <= 1
    light = (1 - 0.5 * (u - 0.2) ** 2 + 0.3 * v) * (0.6 + 0.4 * rng.random((SIZE, SIZE)))
    shapes = np.stack([polar_values(term, u, v) for term in range(1, TERMS + 1)])
    changes = np.zeros((len(steps), TERMS)) if changes is None else changes
    images = []
    for k, step in enumerate(steps):
        turns = np.tensordot(FORM + changes[k], shapes, 1) + step
        wave = (1 + 0.03 * k) * light * (1 + 0.8 * np.cos(2 * np.pi * turns))
        images.append(np.where(inside, wave + noise * rng.normal(size=wave.shape), 0.0))
    return images


@pytest.fixture(scope="module")
def result():
    return fitting.form(
        frames(), pupil=PUPIL, pupil_sd=0.0, terms=TERMS, wavelength=632.8e-9, sign=6, transfer="linear"
    )


def test_form_and_steps_are_found_though_neither_light_nor_steps_are_known(result):
    assert result.status == "ok"
    pulls = (np.array(result.coefficients) - FORM)[3:] / np.array(result.sds)[3:]
    # The largest of twelve normal errors exceeds 4 once in 1300.
    assert np.abs(pulls).max() < 4
    assert np.array(result.sds)[3:].max() < 1.5e-3
    difference = np.array(result.steps) - STEPS
    assert np.abs(difference - np.round(difference)).max() < 2e-3
    assert not [code for code in result.warning_codes if code.startswith("FRAME")]


def test_it_can_be_saved_drawn_and_told(result):
    again = fitting.Form.from_dict(json.loads(json.dumps(result.to_dict())))
    assert again == result
    assert again.steps == result.steps
    assert "steps        0.000" in result.report()
    result.figure()


def test_a_frame_of_another_form_is_named():
    changes = np.zeros((5, TERMS))
    changes[2, 5] = 0.05
    steps = np.array([0.0, 0.21, 0.43, 0.6, 0.78])
    result = fitting.form(frames(steps, changes), pupil=PUPIL, terms=TERMS, transfer="linear")
    assert "FRAME_CONTRADICTS" in result.warning_codes
    assert int(np.argmax(result.contradictions)) == 2


def test_frames_of_one_phase_and_frames_of_nothing_are_refused():
    alike = fitting.form(frames(np.zeros(4)), pupil=PUPIL, transfer="linear")
    assert alike.status == "refused"
    rng = np.random.default_rng(0)
    noise = fitting.form([rng.random((SIZE, SIZE)) for _ in range(4)], pupil=PUPIL, transfer="linear")
    assert (noise.status, noise.reason) == ("refused", "FRAMES_NOT_STEPPED")


@pytest.mark.parametrize(
    ("images", "message"),
    [
        (frames()[:2], "2 frames are given; a phase takes 3 and more"),
        ([*frames()[:3], np.ones((20, 20))], "give frames of one shape"),
    ],
)
def test_what_is_no_set_of_frames_is_refused_in_one_line(images, message):
    with pytest.raises(ValueError, match=message):
        fitting.form(images, pupil=PUPIL, transfer="linear")


def test_five_frames_agree_with_phase_stepping_and_the_fourth_is_named(shared, capsys):
    """Phases by least squares at the steps, unwrapped by scikit-image, Zernikes from their definition."""
    files = [shared / "trials" / f"stepped_{k}.jpg" for k in range(1, 6)]
    assert main(["form", *map(str, files), "--terms", "15", "--json", "-"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert int(np.argmax(answer["contradictions"])) == 3
    assert "FRAME_CONTRADICTS" in answer["warning_codes"]
    disc = frames_of_surface(files, None, None, None)
    angle = 2 * np.pi * np.array(answer["steps"])
    design = np.column_stack([np.ones(5), np.cos(angle), -np.sin(angle)])
    # The laser's power differs from frame to frame.
    light = disc.light / disc.light.mean(axis=1)[:, None]
    _, cosine, sine = np.linalg.lstsq(design, light, rcond=None)[0]
    inside = disc.cells >= 0
    wrapped = np.zeros(inside.shape)
    wrapped[inside] = np.arctan2(sine, cosine)
    turns = np.asarray(unwrap_phase(np.ma.array(wrapped, mask=~inside)))[inside] / (2 * np.pi)
    values = np.column_stack([polar_values(term, disc.u, disc.v) for term in range(1, 16)])
    by_steps = np.linalg.lstsq(values, turns, rcond=None)[0]
    sds = np.array([answer["parameters"][f"z{term}"]["sd"] for term in range(4, 16)])
    assert np.abs((np.array(answer["coefficients_fringe"]) - by_steps)[3:] / sds).max() < 1


def form_alone(light, even, visibility, values):
    """Zernike terms of one frame in a known light, up to the sign, by SciPy from many tilts and no form."""
    weight = 1 / (even + 0.05 * even.mean())

    def misses(numbers):
        return weight * (light - even * numbers[0] * (1 + visibility * np.cos(2 * np.pi * values @ numbers[1:])))

    def slopes(numbers):
        angle = 2 * np.pi * values @ numbers[1:]
        by_turns = 2 * np.pi * weight * even * numbers[0] * visibility * np.sin(angle)
        by_gain = -weight * even * (1 + visibility * np.cos(angle))
        return np.column_stack([by_gain, by_turns[:, None] * values])

    grid = np.stack(np.meshgrid([1.0], np.arange(4) / 4, [0.0, 0.35, 0.7], np.linspace(-0.7, 0.7, 5)), axis=-1)
    first = np.pad(grid.reshape(-1, 4), ((0, 0), (0, values.shape[1] - 3)))
    nearest = sorted(first, key=lambda numbers: float(np.square(misses(numbers)).sum()))[:8]
    fits = [least_squares(misses, numbers, slopes, method="lm", max_nfev=60) for numbers in nearest]
    return min(fits, key=lambda fit: fit.cost).x[1:]


def test_each_of_five_frames_alone_has_the_form_of_all_and_the_fourth_is_farthest(shared):
    """In the light that the other four say, no start given: 0.009 to 0.017 turns rms from all, the fourth 0.035."""
    frames = frames_of_surface([shared / "trials" / f"stepped_{k}.jpg" for k in range(1, 6)], None, None, None)
    together = best_fit(frames, starts(frames, TERMS))
    values = np.column_stack([polar_values(term, frames.u, frames.v) for term in range(1, TERMS + 1)])[::7]
    distances = []
    for frame in range(5):
        rest = np.delete(np.arange(5), frame)
        others = refit_frames(chosen_frames(frames, rest), with_own(together, rest), TERMS)
        form = form_alone(frames.light[frame, ::7], others.even[::7], others.visibility, values)
        form *= np.sign(form[1:3] @ together.own[frame, 1:])
        distances.append(float(np.linalg.norm(form[3:] - together.form)))
    assert max(np.delete(distances, 3)) < 0.025 < distances[3] < 0.045
