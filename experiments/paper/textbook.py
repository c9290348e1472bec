"""Claim: a bare screen biases the textbook formula as two slopes say, and the bench as the model has no bias.

Rings 1 to 6 of a lens of 2 m (589.3 nm, 5 mm of glass) are read off noise-free images at screens 1 to 100 mm away in
both views, and off the microscope's image of the gap: the radius by r_L = 2 r_m² / ((2m - 1) λ) transmitted and
r_m² / (m λ) reflected, and by the fit of the whole image with `scene`. The explanation: the two rays leave the gap at a
distance r from the axis with slopes k_1 r and k_2 r, k_2 - k_1 = 2 / R; a way L = 5 mm / n + screen further on their
paraxial wavefronts k_i x² / 2 have become k_i x² / 2 (1 + k_i L), whose difference is that of a lens of radius
R (1 + k_1 L) (1 + k_2 L). Transmitted R k = -(n - 1) and 3 - n, reflected R k = -2n and -2 (n - 1).

    python -m experiments.paper.textbook [--quick]
"""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

import fitting
import newtonjax as nj
from experiments import records

RADIUS, WAVELENGTH, INDEX, GLASS = 2.0, 589.3e-9, 1.5, 5e-3
PIXEL, SIZE = 5e-6, 1101
SLOPES = {"reflected": (-2 * INDEX, -2 * (INDEX - 1)), "transmitted": (-(INDEX - 1), 3 - INDEX)}


def by_slopes(view: str, screen: float) -> float:
    """Relative bias of the textbook formula by the slopes of the two rays."""
    one, two = (1 + k / RADIUS * (GLASS / INDEX + screen) for k in SLOPES[view])
    return one * two - 1


def read_rings(view: str, screen: float | str, count: int = 6) -> np.ndarray:
    """Radii of the first dark rings [m], from the minima of a row of the image."""
    camera = nj.Camera((1, SIZE), PIXEL, centre_px=(0.0, 0.0))
    scene = nj.newton_rings(RADIUS, WAVELENGTH, view=view, screen=screen)
    row = np.asarray(nj.render(scene, camera, nj.Chebyshev()))[0]
    # The first ring outside of the centre: in reflected light the centre itself is dark.
    at = np.flatnonzero((row[1:-1] < row[:-2]) & (row[1:-1] <= row[2:]))[:count] + 1
    before, here, after = row[at - 1], row[at], row[at + 1]
    return (at + (before - after) / 2 / (before - 2 * here + after)) * PIXEL


def bias(view: str, screen: float | str) -> dict:
    """One line of the table."""
    radii = read_rings(view, screen)
    order = np.arange(1, len(radii) + 1)
    scale = 2 / ((2 * order - 1) * WAVELENGTH) if view == "transmitted" else 1 / (order * WAVELENGTH)
    each = radii**2 * scale / RADIUS - 1
    line = {
        "view": view,
        "screen_m": screen,
        "formula_ring_1": float(each[0]),
        "formula_ring_6": float(each[-1]),
        "formula_mean": float(each.mean()),
        "by_slopes": None if screen == "gap" else by_slopes(view, screen),
    }
    scene = nj.newton_rings(RADIUS, WAVELENGTH, view=view, screen=screen)
    image = np.asarray(nj.render(scene, nj.Camera((400, 400), 12e-6), nj.Chebyshev()))
    # Another lens, the same screen: the microscope's plane would move with the lens it looks through.
    start = replace(nj.newton_rings(0.85 * RADIUS, WAVELENGTH, view=view, screen=1e-3), screen=scene.screen)
    line["bench"] = fitting.fit(image, scene=start, pixel_size=12e-6).radius / RADIUS - 1
    return line


def main() -> None:
    """Measure every screen in both views and write table and figure."""
    options = records.arguments(__doc__, "two screens in one view, nothing written")
    screens = (1e-3, 1e-2) if options.quick else (1e-3, 3e-3, 1e-2, 3e-2, 1e-1, "gap")
    table = [bias(view, screen) for view in (["transmitted"] if options.quick else SLOPES) for screen in screens]
    for line in table:
        print(line, flush=True)
        assert abs(line["bench"]) < 1e-6, "the bench as the model is biased"
        if line["screen_m"] != "gap":
            assert abs(line["formula_ring_6"] / line["by_slopes"] - 1) < 0.01, "two slopes do not explain the bias"
    if not options.quick:
        records.save("textbook", table, draw(table))


def draw(table: list[dict]) -> Figure:
    """Bias over the distance of the screen."""
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    along = np.geomspace(1e-3, 1e-1, 60)
    for view, colour in (("reflected", "tab:red"), ("transmitted", "tab:blue")):
        lines = [line for line in table if line["view"] == view and line["screen_m"] != "gap"]
        measured = [100 * abs(line["formula_mean"]) for line in lines]
        sign = "-" if view == "reflected" else "+"
        axes.loglog([line["screen_m"] for line in lines], measured, "o", color=colour, label=f"{view} ({sign}), read")
        axes.loglog(along, [100 * abs(by_slopes(view, z)) for z in along], color=colour, label=f"{view}, two slopes")
    axes.set(xlabel="distance of the screen [m]", ylabel="bias of the textbook formula [%]")
    axes.legend()
    return figure


if __name__ == "__main__":
    main()
