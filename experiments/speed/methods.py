"""Claim: on one picture, every way to it: what it costs and how far it is from the exact landing points.

Reflected rings (R = 2 m, 500 nm, 5 um pixels, 480 x 480) on a bare screen 1 mm over the lens, which is the paper's
picture, and on the microscope's image of the gap, which the closed form takes as well. Ways: `Traced` (the reference),
`Chebyshev`, `ClosedForm`, `Splat` with one and with 16 rays a pixel, and Gaussian beamlets (Harvey, Irvin and Pfisterer
2015, with whose picture the paper compares its own). Costs are medians over copies of the image taken in the same run,
compilation apart; errors are over the peak. `Splat` shows means over pixels, and is compared with those as well.

    python -m experiments.speed.methods [--quick]
"""

import time
from collections.abc import Callable

import jax
import numpy as np
from matplotlib.figure import Figure

import newtonjax as nj
from experiments import records
from experiments.speed.beamlets import beamlet_image

RADIUS, WAVELENGTH, PIXEL = 2.0, 500e-9, 5e-6


def ways(scene: nj.Scene, camera: nj.Camera, closed: bool, spacing: float) -> dict[str, tuple[Callable, int | None]]:
    """Name: what makes the image, and how many rays it traces to the end (None: a search at every point)."""
    pixels = camera.shape[0] * camera.shape[1]
    found: dict[str, tuple[Callable, int | None]] = {
        "Traced": (lambda: nj.render(scene, camera, nj.Traced()), None),
        "Chebyshev(9)": (lambda: nj.render(scene, camera, nj.Chebyshev(9)), None),
    }
    if closed:
        found["ClosedForm"] = (lambda: nj.render(scene, camera, nj.ClosedForm()), 0)
    for finer in (1, 4):
        method = nj.Splat(step=PIXEL / finer, epsilon=1e-3)
        found[f"Splat, {finer} x {finer} rays a pixel"] = (
            lambda method=method: nj.splat(scene, camera, method).image, 2 * finer**2 * pixels,
        )  # fmt: skip
    found["beamlets"] = beamlet_image(scene, camera, spacing)
    return found


def measure(screen: float | str, size: int, repeats: int, spacing: float) -> tuple[list[dict], dict]:
    """A line a method, and the images."""
    scene = nj.newton_rings(RADIUS, WAVELENGTH, view="reflected", screen=screen)
    camera = nj.Camera((size, size), PIXEL)
    fine = np.asarray(nj.render(scene, nj.Camera((4 * size, 4 * size), PIXEL / 4), nj.Chebyshev(17)))
    mean = fine.reshape(size, 4, size, 4).mean(axis=(1, 3))
    table, images = [], {}
    for name, (make, rays) in ways(scene, camera, screen == "gap", spacing).items():
        started = time.perf_counter()
        images[name] = np.asarray(jax.block_until_ready(make()))
        compiled = time.perf_counter() - started
        over, exact = [], images["Traced"]
        for _ in range(repeats):
            started = time.perf_counter()
            jax.block_until_ready(make())
            taken = time.perf_counter() - started
            over.append(taken / copy_time(exact))
        wrong = np.abs(images[name] - exact) / exact.max()
        table.append(
            {
                "screen": screen, "method": name, "rays": rays, "copies": float(np.median(over)),
                "first_call_s": compiled, "largest_error": float(wrong.max()),
                "rms_error": float(np.sqrt(np.mean(wrong**2))),
                "largest_error_from_pixel_means": float(np.abs(images[name] - mean).max() / exact.max()),
            }
        )  # fmt: skip
        print(table[-1], flush=True)
    return table, images


def copy_time(image: np.ndarray) -> float:
    """Seconds that a copy of the image takes, the median of 21."""
    times = []
    for _ in range(21):
        started = time.perf_counter()
        image.copy()
        times.append(time.perf_counter() - started)
    return float(np.median(times))


def draw(table: list[dict], images: dict) -> Figure:
    """The images side by side, and error over cost."""
    figure = Figure(figsize=(13, 6.2), layout="constrained")
    top, bottom = figure.subfigures(2, 1)
    shown = [name for name in images if name != "Splat, 4 x 4 rays a pixel"]
    for axes, name in zip(top.subplots(1, len(shown)), shown, strict=True):
        records.show(axes, images[name], name, PIXEL)
    for axes, screen in zip(bottom.subplots(1, 2), (1e-3, "gap"), strict=True):
        for line in (line for line in table if line["screen"] == screen):
            place = line["copies"], max(line["largest_error"], 1e-12)
            axes.loglog(*place, "o")
            axes.annotate(line["method"], place, fontsize=8, xytext=(4, 4), textcoords="offset points")
        axes.set(xlabel="cost [copies of the image]", ylabel="largest error over the peak", title=f"screen: {screen}")
        axes.margins(0.3)
    return figure


def main() -> None:
    """Measure both pictures and write table and figure."""
    options = records.arguments(__doc__, "a small picture, once, nothing written")
    size, repeats, spacing = (64, 1, 40e-6) if options.quick else (480, 5, 40e-6)
    table, images = measure(1e-3, size, repeats, spacing)
    table += measure("gap", size, repeats, spacing)[0]
    errors = {(line["screen"], line["method"]): line["largest_error"] for line in table}
    assert errors[1e-3, "Chebyshev(9)"] < 1e-8, "the nodes are not exact"
    assert errors[1e-3, "beamlets"] < 1e-3, "rays aimed at a point and a sum of beamlets differ"
    if not options.quick:
        records.save("methods", table, draw(table, images))


if __name__ == "__main__":
    main()
