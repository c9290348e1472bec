"""Claim: with the bench as the model, a fit has none of the bias that a screen gives to the gap formula.

Bare screens 1, 10 and 100 mm away, both views, R = 2 m, 589.3 nm, 512 x 512 pixels of 10 um, images scaled to [0, 1]
with noise of standard deviation 0.05. The images are traced at every pixel (`Traced`), the fit's scene has a radius
15 % off. For each bench: the gap formula's bias, and of the fits with `scene` the share within two standard deviations
of the truth, the mean error and the scatter, both over the reported standard deviation.

    python -m experiments.accuracy.benches [--seeds 500] [--quick]
"""

import argparse
import json

import jax
import numpy as np

import fitting
import newtonjax as nj
from experiments import records

RADIUS, WAVELENGTH, PIXEL = 2.0, 589.3e-9, 10e-6


def bench(view: str, screen: float, seeds: int) -> dict:
    """One line of the table."""
    camera = nj.Camera((512, 512), PIXEL, centre_px=(262.0, 250.0))
    image = np.asarray(nj.render(nj.newton_rings(RADIUS, WAVELENGTH, 0.0, view, screen=screen), camera, nj.Traced()))
    image = (image - image.min()) / np.ptp(image)
    scene = nj.newton_rings(0.85 * RADIUS, WAVELENGTH, 0.0, view, screen=screen)
    formula = fitting.fit(image, wavelength=WAVELENGTH, pixel_size=PIXEL, view=view)
    clean = fitting.fit(image, scene=scene, pixel_size=PIXEL)
    pulls, sds = [], []
    for seed in range(seeds):
        noisy = image + 0.05 * np.random.default_rng([len(view), round(1e3 * screen), seed]).normal(size=image.shape)
        result = fitting.fit(noisy, scene=scene, pixel_size=PIXEL)
        pulls.append((result.radius - RADIUS) / result.radius_sd)
        sds.append(result.radius_sd / RADIUS)
    return {
        "view": view,
        "screen_m": screen,
        "formula_bias": formula.radius / RADIUS - 1,
        "scene_bias_without_noise": clean.radius / RADIUS - 1,
        "seeds": seeds,
        "within_2_sd": float(np.mean(np.abs(pulls) < 2)),
        "mean_pull": float(np.mean(pulls)),
        "sd_pull": float(np.std(pulls, ddof=1)),
        "relative_sd": float(np.median(sds)),
    }


def main() -> None:
    """Fit every bench and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=500)
    parser.add_argument("--quick", action="store_true", help="three seeds, one bench, nothing written")
    options = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    screens = (1e-2,) if options.quick else (1e-3, 1e-2, 1e-1)
    views = ("reflected",) if options.quick else ("reflected", "transmitted")
    table = []
    for view in views:
        for screen in screens:
            table.append(bench(view, screen, 3 if options.quick else options.seeds))
            print(json.dumps(table[-1]), flush=True)
    assert all(abs(line["scene_bias_without_noise"]) < 1e-6 for line in table), "the traced model is biased"
    if not options.quick:
        records.save("benches", table)


if __name__ == "__main__":
    main()
