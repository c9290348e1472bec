"""Processes that are forked after the library was used: a fit runs, and what would hang says so."""

import subprocess
import sys

import pytest

PROGRAM = """
import multiprocessing, sys, warnings
import numpy as np
sys.path.insert(0, "tests")
import fitting
import newtonjax as nj
from rings_data import rings

warnings.filterwarnings("ignore", "os.fork")
SCENE, CAMERA = nj.newton_rings(0.3), nj.Camera((16, 16), 20e-6)

def fit(scene):
    given = {"pixel_size": 5e-6, "view": "reflected"} | ({"scene": SCENE} if scene else {"wavelength": 589.3e-9})
    return fitting.fit(rings(0.3, noise=0.02), **given).radius

def answer(verb):
    calls = {
        "fit": lambda: fit(False),
        "fit with a scene": lambda: fit(True),
        "render": lambda: nj.render(SCENE, CAMERA, nj.ClosedForm()),
        "expose": lambda: CAMERA.expose(np.ones((16, 16)), KEY),
    }
    try:
        return float(np.sum(calls[verb]()))
    except RuntimeError as error:
        return str(error)

if __name__ == "__main__":
    import jax
    KEY = jax.random.key(0)
    first, *verbs = sys.argv[1:]
    if first == "eager":
        np.asarray(nj.render(SCENE, CAMERA, nj.ClosedForm()))
    elif first == "equations":
        jax.config.update("jax_enable_x64", True)
        bench = lambda numbers: nj.newton_rings(numbers[0])
        equations = lambda numbers: nj.normal_equations(bench, numbers, CAMERA, method=nj.Chebyshev(3)).gradient
        jax.jit(equations)(np.array([0.3])).block_until_ready()
    else:
        jax.jit(lambda radius: nj.render(nj.newton_rings(radius), CAMERA, nj.ClosedForm()))(0.3).block_until_ready()
    with multiprocessing.get_context("fork").Pool(1) as pool:
        for verb in verbs:
            print(pool.apply_async(answer, [verb]).get(timeout=60))
"""


pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no fork")


def answers(*arguments):
    """What the program prints: a line for each verb that a forked process was asked for after a first call here."""
    command = [sys.executable, "-c", PROGRAM, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_in_a_forked_process_a_fit_runs_and_what_would_hang_says_so():
    radius, *refusals = answers("eager", "fit", "fit with a scene", "render", "expose")
    assert abs(float(radius) / 0.3 - 1) < 0.01
    assert len(refusals) == 3
    assert all('multiprocessing.get_context("spawn")' in text for text in refusals)


@pytest.mark.parametrize("first", ["traced", "equations"])
def test_a_program_of_the_users_own_counts_as_a_first_call(first):
    (refusal,) = answers(first, "render")
    assert 'multiprocessing.get_context("spawn")' in refusal
