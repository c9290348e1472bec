"""Claim: white light in three channels costs at most four plain images, blurred six, the gradient of either fifteen.

A sum over its lines takes 60 times as long. Two lines from a disc of 0.57 degrees, blurred, over the areas of pixels,
cost at most three on the method of their plan.
All orders between coated faces cost at most two: of finesse 100, and of 20 harmonics (1e-6 of the fringes).

Rings of a lens of 154.5 mm in light of 5500 K, 380 to 780 nm, in the CIE's three channels, 1024 x 1024 in float64: a
call of `render`, planning included, beside one of the same bench in a single line, one on the plan's method, a
lamp of two lines, and the gradient of a sum over the pixels in the radius; medians of CPU time over all threads, in
turns in one process. And a sum over the 81 wavelengths in NumPy, a cosine and three multiplications in place each. The
error is that of the tables, of the closed form against that sum, over its peak. Rows "planned" have the method
from the plan of the scene, which is made once; the others choose it in each call. Of a blurred picture the table
depends on the radius, too.

    python -m experiments.speed.white_light [--quick]
"""

import json
from dataclasses import replace
from functools import partial
from time import process_time

import jax
import jax.numpy as jnp
import numpy as np

import newtonjax as nj
from experiments import records

RADIUS = 0.1545
LIMITS = {
    "white": 4.0,
    "white, blurred": 6.0,
    "gradient": 15.0,
    "gradient, blurred": 15.0,
    "two lines": 3.0,
    "two lines, disc, area, blur": 3.5,
    "two lines, disc, area, blur, planned": 3.0,
    "finesse 100": 2.0,
    "20 harmonics": 2.0,
}


def sum_over_lines(light: nj.Light, camera: nj.Camera) -> np.ndarray:
    """The picture of the bench, line by line; two beams through the flat face of glass of index 1.5."""
    (x, y), spectrum = camera.axes(), light.spectrum
    gap = RADIUS - np.sqrt(RADIUS**2 - x**2 - y[:, None] ** 2)
    powers = camera.response.powers(spectrum.wavelengths, spectrum.shares)
    image, wave, part = np.zeros((3, *camera.shape)), np.empty(camera.shape), np.empty(camera.shape)
    for at, channels in zip(spectrum.wavelengths, powers.T, strict=True):
        np.multiply(gap, 4 * np.pi / at, out=wave)
        np.cos(wave, out=wave)
        for channel, power in enumerate(channels):
            np.multiply(wave, power, out=part)
            image[channel] += part
    background, swing = 0.04 * (1 + 0.96**2), -2 * 0.04 * 0.96
    return 0.96**2 * (background * powers.sum(axis=1) + swing * np.moveaxis(image, 0, -1))


def costs(size: int, rounds: int) -> dict[str, float]:
    """CPU times over that of a plain image; `times` a sum over the lines; `error`."""
    grey = nj.Camera((size, size), 3.1e-6 * 1024 / size)
    colour = nj.Camera(grey.shape, grey.pixel_size, response=nj.cie_1931())
    samples = nj.black_body(5500.0)
    light = nj.Spectrum(samples.wavelengths, samples.weights)  # sharp lines, as the sum has them
    white, plain = nj.newton_rings(RADIUS, light=light), nj.newton_rings(RADIUS)
    pair, method = nj.newton_rings(RADIUS, light="sodium"), nj.plan(white, colour).method
    weights = jnp.asarray(np.random.default_rng(0).uniform(size=colour.image_shape))

    blurred = replace(colour, blur=1.0)

    def total(radius, camera):
        return (nj.render(nj.newton_rings(radius, light=light), camera, nj.ClosedForm()) * weights).sum()

    gradients = [jax.jit(jax.grad(partial(total, camera=camera))) for camera in (colour, blurred)]
    disc, means = nj.newton_rings(RADIUS, light="sodium", angular_radius=0.01), replace(grey, aperture=1.0, blur=1.0)
    of_disc, of_blur = nj.plan(disc, means).method, nj.plan(white, blurred).method
    runs = {
        "plain": lambda: nj.render(plain, grey),
        "white": lambda: nj.render(white, colour),
        "white, planned": lambda: nj.render(white, colour, method),
        "two lines": lambda: nj.render(pair, grey),
        "gradient": lambda: gradients[0](RADIUS),
        "gradient, blurred": lambda: gradients[1](RADIUS),
        "white, blurred": lambda: nj.render(white, blurred),
        "white, blurred, planned": lambda: nj.render(white, blurred, of_blur),
        "two lines, disc, area, blur": lambda: nj.render(disc, means),
        "two lines, disc, area, blur, planned": lambda: nj.render(disc, means, of_disc),
        "two lines, disc, planned": lambda: nj.render(disc, grey, of_disc),
    }
    for name, mirror in (("finesse 100", "mirror:96.9%"), ("20 harmonics", "mirror:50%")):
        etalon = nj.newton_rings(RADIUS, lens_coating=mirror, plate_coating=mirror)
        runs[name] = partial(nj.render, etalon, grey, nj.ClosedForm())
    cpu, _ = records.cpu_and_wall(runs, rounds)
    begin = process_time()
    expected = sum_over_lines(white.light, colour)
    seconds = process_time() - begin
    in_closed_form = nj.render(white, colour, nj.ClosedForm(table_error=method.table_error))
    error = np.abs(np.asarray(in_closed_form) - expected).max() / expected.max()
    ratios = {name: seconds_of / cpu["plain"] for name, seconds_of in cpu.items()}
    return ratios | {
        "times": seconds / cpu["white"],
        "times, planned": seconds / cpu["white, planned"],
        "plain_ms": 1e3 * cpu["plain"],
        "error": float(error),
    }


def main(quick: bool) -> None:
    row = costs(*((256, 3) if quick else (1024, 15)))
    print(json.dumps({name: float(f"{value:.3g}") for name, value in row.items()}, indent=1))
    assert row["error"] < 3e-5
    if quick:
        return
    records.save("white_light", row)
    assert all(row[name] <= limit for name, limit in LIMITS.items()), row


if __name__ == "__main__":
    main(records.arguments(__doc__, "256 x 256 pixels, no limits, nothing written").quick)
