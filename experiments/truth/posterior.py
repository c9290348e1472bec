"""Claim: draws on fringe moments cost a hundredth of draws on all pixels, agree between samplers, and are calibrated.

Three parts. Speed: effective draws a second of `fitting.sample`, and of emcee (its own stretch move, as many walkers)
on the Gaussian likelihood of every pixel in NumPy at 1024 x 1024 with the same free numbers, in one run. Agreement:
mean and deviation of the radius from emcee, NUTS and the Laplace covariance for many rings and for few. Calibration
(Talts et al. 2018): 200 images of truths drawn from the prior, the rank of the true radius and pixel size among 99
thinned draws, chi-squared over ten bins.

    python -m experiments.truth.posterior [--quick]
"""

import json
import time

import emcee
import numpy as np
from scipy import stats

from experiments import records

WAVELENGTH, NOISE = 589.3e-9, 0.1


def image_of(radius, pixel_size, size, centre, gap, seed, noise=NOISE):
    """Reflected rings of the exact sphere with noise."""
    y, x = np.mgrid[:size, :size].astype(float)
    r2 = ((x - centre[0]) ** 2 + (y - centre[1]) ** 2) * pixel_size**2
    thickness = gap + r2 / radius / (1 + np.sqrt(1 - r2 / radius**2))
    clean = 0.5 - 0.5 * np.cos(4 * np.pi * thickness / WAVELENGTH)
    return clean + noise * np.random.default_rng(seed).normal(size=clean.shape)


def fitted(radius=1.0, pixel_size=10e-6, size=128, seed=0, given=None):
    import fitting

    centre = (size * 0.48, size * 0.53)
    image = image_of(radius, pixel_size, size, centre, 50e-9, seed)
    given = pixel_size if given is None else given
    return image, fitting.fit(image, wavelength=WAVELENGTH, pixel_size=given, pixel_size_sd=0.002 * given)


def speed(size: int, steps: int) -> dict:
    """Effective draws a second on the moments over those on all pixels."""
    import fitting

    image, result = fitted(pixel_size=10e-6 * 128 / size * 3, size=size)
    fitting.sample(result, steps=50)  # compiles
    began = time.perf_counter()
    chain = fitting.sample(result, steps=20 * steps)
    ours = chain.effective / (time.perf_counter() - began) * 0.75  # burn-in takes a quarter of the time
    y, x = np.mgrid[:size, :size].astype(float)
    sd = np.sqrt(np.diag(result.covariance))
    start = np.array([result.radius, *result.centre_px, result.gap, result.parameters["pixel_size"].value, 0.5, -0.5])
    spread = np.array([*sd, 0.002 * start[4], 1e-4, 1e-4])

    def log_density(numbers):
        radius, x0, y0, gap, pixel, background, contrast = numbers
        r2 = ((x - x0) ** 2 + (y - y0) ** 2) * pixel**2
        phase = 4 * np.pi * (gap + r2 / radius / (1 + np.sqrt(1 - r2 / radius**2))) / WAVELENGTH
        left = image - background - contrast * np.cos(phase)
        return -0.5 * np.vdot(left, left) / NOISE**2 - 0.5 * ((pixel / start[4] - 1) / 0.002) ** 2

    sampler = emcee.EnsembleSampler(32, 7, log_density)
    points = start + spread * np.random.default_rng(0).normal(size=(32, 7)) * 0.5
    began = time.perf_counter()
    sampler.run_mcmc(points, steps)
    seconds = time.perf_counter() - began
    # Too short a chain underestimates its autocorrelation time, which flatters the baseline.
    slowest = float(np.max(emcee.autocorr.integrated_time(sampler.get_chain(), quiet=True, tol=0)))
    theirs = 32 * steps / slowest / seconds
    return {
        "size": size,
        "effective_per_second": ours,
        "all_pixels_effective_per_second": theirs,
        "ratio": ours / theirs,
        "autocorrelation_time": float(np.max(chain.autocorrelation_time)),
        "all_pixels_autocorrelation_time": slowest,
        "all_pixels_ms_a_density": seconds / (32 * steps) * 1e3,
    }


def agreement(steps: int) -> list[dict]:
    """Radius by the three ways, for many rings and for few."""
    import fitting

    rows = []
    for rings, pixel_size in (("many", 30e-6), ("few", 9.5e-6)):
        _, result = fitted(pixel_size=pixel_size)
        row = {"rings": rings, "laplace": [result.radius, result.radius_sd]}
        for sampler in ("emcee", "nuts"):
            chain = fitting.sample(result, steps=steps, sampler=sampler, walkers=None)
            drawn = chain.of("radius")
            row[sampler] = [float(drawn.mean()), float(drawn.std()), chain.effective, chain.message]
            row[f"{sampler}_quantiles"] = np.quantile(drawn, [0.025, 0.16, 0.5, 0.84, 0.975]).tolist()
        rows.append(row)
    return rows


def calibration(count: int, steps: int) -> dict:
    """Ranks of the truth, of radius and pixel size, and the probability of so uneven a histogram."""
    import fitting

    ranks = {"radius": [], "pixel_size": []}
    for seed in range(count):
        rng = np.random.default_rng([seed, 5])
        # The radius's prior is flat over far more than a posterior; the pixel size's is what the fit is told.
        truth = {"radius": rng.uniform(0.9, 1.1), "pixel_size": 30e-6 * (1 + 0.002 * rng.normal())}
        _, result = fitted(**truth, size=96, seed=seed, given=30e-6)
        chain = fitting.sample(result, steps=steps, seed=seed)
        for name, found in ranks.items():
            drawn = chain.of(name)
            thinned = drawn[np.linspace(0, len(drawn) - 1, 99).astype(int)]
            found.append(int((thinned < truth[name]).sum()))
    table = {}
    for name, found in ranks.items():
        counts = np.histogram(found, bins=10, range=(0, 100))[0]
        table[name] = {"counts": counts.tolist(), "p": float(stats.chisquare(counts).pvalue)}
    return table


def main() -> None:
    """Run all parts and write their numbers."""
    options = records.arguments(__doc__, "a small image, three draws, nothing written")
    quick = options.quick
    found = {"speed": speed(128 if quick else 1024, 10 if quick else 150)}
    print(json.dumps(found["speed"]))
    if not quick:
        found["agreement"] = agreement(6000)
        print(json.dumps(found["agreement"]))
    found["calibration"] = calibration(3 if quick else 200, 200 if quick else 1500)
    print(json.dumps(found["calibration"]))
    if not quick:
        records.save("posterior", found)
        assert found["speed"]["ratio"] > 100, "draws on moments are not a hundred times cheaper"
        assert min(part["p"] for part in found["calibration"].values()) > 0.01, "the ranks are uneven"


if __name__ == "__main__":
    main()
