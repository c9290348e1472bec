"""Claim: conic constant, fourth-order term and second radius scatter as the Cramér–Rao bound says, from spheres on.

Rings of a lens of 0.1 m, reflected, traced, the screen at 1 mm, 128 x 128 pixels, white noise of 2 % of the incident
irradiance (a sixth of the fringes' swing). Measured with the bench as the model (`fitting.measurement`): radius, gap,
centre, exposure and stray light free with the numbers of the shape, the search starting from a sphere (a
toroid's from a radius 0.2 % off and an axis turned by 0.02). For each number: scatter over the bound of
`fitting.information`, mean error over it, and how many of the seeds converged.

    python -m experiments.truth.surfaces [--seeds 200] [--quick]
"""

import argparse

import jax
import numpy as np

import fitting
import newtonjax as nj
from experiments import records

NOISE, NODES = 0.02, nj.Chebyshev(9)
CAMERA = nj.Camera((128, 128), pixel_size=24e-6)
FREE = ("radius", "gap", "centre_x", "centre_y", "exposure", "stray")
# By number of the shape, what is true and where the search starts.
CASES = {
    "conic": ({"conic": -1.0}, {"conic": 0.0}),
    "asphere": ({"asphere": (2e3,)}, {"asphere": (0.0,)}),
    "toroid": ({"radius_across": 0.105, "axis": 0.3}, {"radius_across": 0.1052, "axis": 0.32}),
}
NUMBERS = {"conic": ("conic",), "asphere": ("asphere",), "toroid": ("radius_across", "astigmatism_axis")}


def bench(words: dict) -> nj.Scene:
    return nj.newton_rings(0.1, 550e-9, gap=0.3e-6, screen=1e-3, **words)


def case(name: str, seeds: int) -> list[dict]:
    """Rows of a shape: one for each number."""
    truth, start = (bench(words) for words in CASES[name])
    free = (*FREE, *NUMBERS[name])
    image = np.asarray(nj.render(truth, CAMERA, NODES))
    bounds = fitting.information(truth, CAMERA, free=free, noise=NOISE)
    # Compiled: known numbers would be fitted in NumPy, which takes seconds where there are many images.
    measure = jax.jit(fitting.measurement(start, CAMERA, free=free, noise=NOISE, method=NODES))
    answers = []
    for seed in range(seeds):
        noise = NOISE * np.random.default_rng([7, seed]).normal(size=image.shape)
        answer = measure(image + noise)
        if answer.converged:
            answers.append({number: float(value) for number, value in answer.numbers.items()})
    exact = measure(image).numbers
    rows = []
    for number in ("radius", *NUMBERS[name]):
        errors = (np.array([one[number] for one in answers]) - float(exact[number])) / bounds.sd(number)
        scatter = float(np.sqrt(np.mean(errors**2)))
        rows.append(
            {
                "case": name,
                "number": number,
                "bound": bounds.sd(number),
                "without_noise": float(exact[number]),
                "seeds": seeds,
                "converged": len(answers),
                "scatter_over_bound": scatter,
                "mean_over_bound": float(errors.mean()),
                "covered_95": float(np.mean(abs(errors) < 1.96)),
            }
        )
        print(rows[-1], flush=True)
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--quick", action="store_true", help="two seeds a case, nothing written")
    options = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    table = [row for name in CASES for row in case(name, 2 if options.quick else options.seeds)]
    assert all(row["converged"] == row["seeds"] for row in table), "a seed did not converge"
    if not options.quick:
        records.save("surfaces", table)


if __name__ == "__main__":
    main()
