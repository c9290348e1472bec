"""Claim: on rendered rings the fit always locks, is unbiased, attains the Cramér–Rao bound, and says so.

Reflected rings seen in the gap, scaled to [0, 1], Gaussian noise of standard deviation 0.05, 512 x 512 pixels,
589.3 nm, the centre 13.3 and -8.7 px off. For each radius: how many of the seeds lock, scatter of the radius over the
bound, mean bias over the bound, and reported standard deviation over the bound. The bound is that of the model that is
fitted (six unknowns where the image calls for no more), by central differences of the exact model over all pixels.

    python -m experiments.truth.scatter [--seeds 1000] [--processes 2] [--quick]
"""

import argparse
import json
import sys

import numpy as np

from experiments import records
from experiments.truth.microscope_view import added_path

WAVELENGTH, SIZE, NOISE, CENTRE = 589.3e-9, 512, 0.05, (13.3, -8.7)
CASES = {0.1: 5e-6, 0.3: 5e-6, 1.0: 5e-6, 3.0: 10e-6}


def model(radius, pixel_size, x0, y0, gap, background=0.5, contrast=0.5):
    """Reflected fringes of a sphere in the gap, as a microscope sees them."""
    y, x = np.mgrid[:SIZE, :SIZE] - (SIZE - 1) / 2
    r2 = ((x - x0) ** 2 + (y - y0) ** 2) * pixel_size**2
    thickness = gap + r2 / radius / (1 + np.sqrt(1 - r2 / radius**2))
    path = 2 * thickness + added_path(radius, r2, gap)
    return background - contrast * np.cos(2 * np.pi * path / WAVELENGTH)


def bound(radius: float, pixel_size: float) -> float:
    """Cramér–Rao bound of the radius's relative standard deviation, six unknowns."""
    truth = np.array([radius, *CENTRE, 0.0, 0.5, 0.5])
    steps = np.array([radius * 1e-6, 1e-3, 1e-3, 1e-11, 1e-3, 1e-3])

    def image(values):
        r, x0, y0, gap, b, a = values
        return model(r, pixel_size, x0, y0, gap, b, a).ravel()

    columns = []
    for k, step in enumerate(steps):
        move = np.zeros(6)
        move[k] = step
        columns.append((image(truth + move) - image(truth - move)) / (2 * step))
    jacobian = np.stack(columns, axis=1)
    scale = np.linalg.norm(jacobian, axis=0)
    covariance = np.linalg.inv((jacobian / scale).T @ (jacobian / scale))
    return float(NOISE * np.sqrt(covariance[0, 0]) / scale[0] / radius)


def run(job):
    """Fit one noisy image; (radius, seed, relative error, relative sd, unknowns, milliseconds)."""
    import jax

    jax.config.update("jax_enable_x64", True)
    import fitting

    radius, seed = job
    pixel_size = CASES[radius]
    image = model(radius, pixel_size, *CENTRE, 0.0)
    image = image + NOISE * np.random.default_rng([int(radius * 10), seed]).normal(size=image.shape)
    result = fitting.fit(image, wavelength=WAVELENGTH, pixel_size=pixel_size)
    if result.radius is None:
        return radius, seed, None, None, result.message, result.seconds
    return (
        radius,
        seed,
        result.radius / radius - 1,
        result.radius_sd_noise / radius,
        result.model["illumination"],
        result.seconds,
    )


def main() -> None:
    """Run every seed of every case and write table and figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=1000)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--quick", action="store_true", help="two seeds a case in one process, nothing written")
    options = parser.parse_args()
    seeds, processes = (2, 1) if options.quick else (options.seeds, options.processes)
    jobs = [(radius, seed) for radius in CASES for seed in range(seeds)]
    rows = []
    for row in records.each(run, jobs, processes, chunk=5):
        rows.append(row)
        if len(rows) % 200 == 0:
            print(f"{len(rows)} of {len(jobs)} fits", file=sys.stderr, flush=True)
    table = [summary(radius, [row for row in rows if row[0] == radius]) for radius in CASES]
    for line in table:
        print(json.dumps(line))
    if not options.quick:
        records.save("scatter", table)
        draw(rows)
    assert all(line["locked"] == line["seeds"] for line in table), "a seed did not lock"


def summary(radius: float, rows: list) -> dict:
    """One line of the table."""
    crb = bound(radius, CASES[radius])
    locked = [row for row in rows if row[2] is not None and abs(row[2]) < 100 * crb]
    errors, sds = np.array([row[2] for row in locked]), np.array([row[3] for row in locked])
    return {
        "radius_m": radius,
        "seeds": len(rows),
        "locked": len(locked),
        "bound": crb,
        "scatter_over_bound": float(errors.std(ddof=1) / crb),
        "bias_over_bound": float(errors.mean() / crb),
        "reported_over_bound": float(np.median(sds) / crb),
        "reported_worst": [float(sds.min() / crb), float(sds.max() / crb)],
        "covered_95": float(np.mean(np.abs(errors) < 1.96 * sds)),
        "six_unknowns": int(sum("degree 0 background, degree 0" in row[4] for row in locked)),
        "median_seconds": float(np.median([row[5] for row in rows])),
    }


def draw(rows: list) -> None:
    """Histograms of error over bound, beside the normal distribution."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 2.8), layout="constrained")
    at = np.linspace(-4, 4, 200)
    for axes, radius in zip(figure.subplots(1, len(CASES), sharey=True), CASES, strict=True):
        crb = bound(radius, CASES[radius])
        errors = [row[2] / crb for row in rows if row[0] == radius and row[2] is not None]
        axes.hist(errors, bins=40, range=(-4, 4), density=True, color="0.7")
        axes.plot(at, np.exp(-(at**2) / 2) / np.sqrt(2 * np.pi), color="tab:red", lw=1)
        axes.set(title=f"R = {radius:g} m", xlabel="error / Cramér–Rao sd")
    figure.savefig(records.RESULTS / "scatter.png", dpi=100)


if __name__ == "__main__":
    main()
