"""Claim: of gaps from rings in two or three wavelengths at least 99 % have the right order where one is told.

Pictures of one lens in each of the wavelengths (`WAVELENGTHS`: lines of mercury, two lasers), the gap anywhere in half
of the synthetic wavelength: 6 to 25 rings of green in 200 to 300 pixels, noise of 0.5 to 5 %, blur, a vignette and a
contrast of its own in each, half of them under a distorting camera, three in ten as JPEG of quality 90. The wavelengths
that are given are off by their standard deviations. Two lasers at once are one colour picture: red and green channel.

    python -m experiments.truth.gap_orders [--cases 60] [--quick]
"""

import argparse
import json
import sys

import numpy as np
from scipy import ndimage

import fitting
from experiments import records
from experiments.truth.ring_field import compressed
from fitting.photograph.shared_gap import window_of

# By name: wavelengths, and the standard deviation with which each is known [m].
WAVELENGTHS = {
    "mercury 546.1 and 578.0 nm": ((546.074e-9, 578.01e-9), 0.02e-9),
    "mercury 435.8 and 546.1 nm": ((435.833e-9, 546.074e-9), 0.02e-9),
    "mercury 435.8, 546.1 and 578.0 nm": ((435.833e-9, 546.074e-9, 578.01e-9), 0.02e-9),
    "mercury 577.0 and 579.1 nm": ((576.960e-9, 579.066e-9), 0.2e-12),
    "lasers of 532 and 633 nm, one picture": ((532.0e-9, 632.8e-9), 0.05e-9),
}
GREEN, PIXEL_SIZE = 546e-9, 1e-5


class Lens:
    """A lens before a camera, drawn at random; `rings` at half a diagonal in green, `gap` at the centre [m]."""

    def __init__(self, rng: np.random.Generator, wavelengths: tuple[float, ...]):
        self.rng = rng
        self.gap = float(rng.uniform(0, window_of(wavelengths)[1]))
        rows, columns = (int(side) for side in rng.integers(200, 300, 2))
        y, x = np.mgrid[:rows, :columns].astype(float)
        half = np.hypot(rows - 1, columns - 1) / 2
        self.u, self.v = (x - (columns - 1) / 2) / half, (y - (rows - 1) / 2) / half
        self.rings, self.centre = self.drawn(6, 25), rng.uniform(-0.3, 0.3, 2)
        self.distortion = float(rng.normal(0, 0.01) * (rng.uniform() < 0.5))
        self.noise, self.is_jpeg = self.drawn(0.005, 0.05), bool(rng.uniform() < 0.3)

    def drawn(self, low: float, high: float) -> float:
        """A number whose logarithm is evenly distributed."""
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def light(self, wavelength: float) -> np.ndarray:
        """The picture in one wavelength."""
        warp, rng = 1 + self.distortion * (self.u**2 + self.v**2), self.rng
        squares = (self.u * warp - self.centre[0]) ** 2 + (self.v * warp - self.centre[1]) ** 2
        turns = (self.rings * squares * GREEN + 2 * self.gap) / wavelength
        light = ndimage.gaussian_filter(1 - rng.uniform(0.3, 0.9) * np.cos(2 * np.pi * turns), rng.uniform(0.5, 1.5))
        light *= 0.4 * (1 - rng.uniform(0, 0.3) * (self.u**2 + self.v**2))
        return light + 0.4 * self.noise * rng.normal(size=light.shape)


def case(kind: str, seed: int) -> dict:
    """One lens: whether an order is told, whether it is right, and the gap's error [m]."""
    wavelengths, sd = WAVELENGTHS[kind]
    rng = np.random.default_rng([seed, 41])
    lens = Lens(rng, wavelengths)
    images = [lens.light(wavelength) for wavelength in wavelengths]
    stated = [wavelength + float(rng.normal(0, sd)) for wavelength in wavelengths]
    options = {"wavelength": stated, "wavelength_sd": sd, "view": "reflected", "shared": ("gap", "distortion")}
    if "one picture" in kind:
        green, red = images
        image = np.stack([red, green, np.zeros_like(red)], axis=-1)
        images, options = [image] * 2, options | {"channel": ["green", "red"]}
    if lens.is_jpeg:
        images = [compressed(image, 90) for image in images]
    result = fitting.fit_together(images, **options)
    line = {"kind": kind, "seed": seed, "gap": lens.gap, "status": "refused"}
    if result.gap is None:
        return line | {"message": str(result.message)}
    line |= {"status": result.gap.status, "message": str(result.gap.message)}
    line["probability"] = result.gap.orders[0].probability if result.gap.orders else None
    if result.gap.value is None:
        return line
    error = result.gap.value - lens.gap
    return line | {"error": error, "sd": result.gap.sd, "is_right": bool(abs(error) < 0.25 * min(wavelengths))}


def summary(lines: list[dict]) -> dict:
    """Of some cases: how many were told, how many of these rightly, and how the gap is covered."""
    answered = [line for line in lines if line["status"] == "ok"]
    z = np.array([line["error"] / line["sd"] for line in answered if line["is_right"]])
    return {
        "cases": len(lines),
        "told": len(answered),
        "right": sum(line["is_right"] for line in answered),
        "covered": float(np.mean(np.abs(z) < 1.96)) if len(z) else None,
        "median_sd": float(np.median([line["sd"] for line in answered])) if answered else None,
    }


def main() -> None:
    """Run all kinds and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=60, help="of every kind")
    parser.add_argument("--quick", action="store_true", help="one case of every kind, nothing written")
    options = parser.parse_args()
    count, lines = 1 if options.quick else options.cases, []
    for kind in WAVELENGTHS:
        lines += [case(kind, seed) for seed in range(count)]
        print(kind, json.dumps(summary([line for line in lines if line["kind"] == kind])), flush=True)
    table = {kind: summary([line for line in lines if line["kind"] == kind]) for kind in WAVELENGTHS}
    table["all"] = summary(lines)
    if not options.quick:
        records.save("gap_orders", {"table": table, "lines": lines})
    if table["all"]["right"] < 0.99 * table["all"]["told"]:
        sys.exit(1)


if __name__ == "__main__":
    main()
