"""Claim: reading the paper's rings its way gives its numbers; what is left of the 2 m is a bare screen's bias.

Debelov and Dolgov (2021, figure 7) read rings 1 and 6 off the screenshot of a lens of 2 m (500 nm, 5 um pixels) at
pixels 142 and 470, take off half a pixel, and get 2002.2 and 2003.9 mm from r_L = 2 r_m² / ((2m - 1) λ). They lay the
error to the pixel. They do not say how thick the glass is and how far the screen: with our 5 mm and 1 mm the rings fall
on their pixels (so they do for any bare screen some 4 to 12 mm of air from the gap, but not in the gap's own image).
That bench is rendered and read: whole pixels as in the paper, the same formula on positions between pixels, a straight
line through six rings, and the whole image, by the gap formula and by the bench.

    python -m experiments.paper.figure7 [--quick]
"""

import numpy as np
from matplotlib.figure import Figure

import fitting
import newtonjax as nj
from experiments import records

RADIUS, WAVELENGTH, PIXEL, SIZE = 2.0, 500e-9, 5e-6, 1001
AWAY = 5e-3 / 1.5 + 1e-3  # from the gap to the screen, in air
PAPER = {1: (142, 2.0022), 6: (470, 2.0039)}


def textbook(order, radius_m):
    """The lens radius from one dark ring in transmitted light (Landsberg; the paper's section 4.2) [m]."""
    return 2 * radius_m**2 / ((2 * order - 1) * WAVELENGTH)


def dark_rings(row: np.ndarray, count: int) -> np.ndarray:
    """Distances of the first dark rings from the row's first pixel, by a parabola through three pixels."""
    at = np.flatnonzero((row[1:-1] < row[:-2]) & (row[1:-1] <= row[2:]))[:count] + 1
    before, here, after = row[at - 1], row[at], row[at + 1]
    return at + (before - after) / 2 / (before - 2 * here + after)


def main() -> None:
    """Read the rings, fit the image, and write table and figure."""
    options = records.arguments(__doc__, "a smaller image to fit, nothing written")
    scene = nj.newton_rings(RADIUS, WAVELENGTH, view="transmitted", screen=1e-3)
    camera = nj.Camera((SIZE, SIZE), PIXEL)
    image = np.asarray(nj.render(scene, camera, nj.Chebyshev(17)))
    between = dark_rings(image[SIZE // 2, SIZE // 2 :], 6)
    table = {"paper": {}, "ours": {}}
    for order, (pixel, radius) in PAPER.items():
        table["paper"][f"ring {order}"] = {
            "pixel": pixel, "radius_m": radius, "recomputed_m": textbook(order, (pixel - 0.5) * PIXEL),
        }  # fmt: skip
        # The paper counts the pixel in whose middle the apex lies as half a one: its pixels are ours and a half.
        table["ours"][f"ring {order}"] = {
            "pixel, counted as the paper does": float(between[order - 1] + 0.5),
            "whole pixel": int(np.floor(between[order - 1] + 0.5)),
            "radius_whole_pixel_m": textbook(order, (np.floor(between[order - 1] + 0.5) - 0.5) * PIXEL),
            "radius_between_pixels_m": textbook(order, between[order - 1] * PIXEL),
        }
    line = fitting.rings(
        {"order": list(range(1, 7)), "radius_px": list(between)},
        wavelength=WAVELENGTH, pixel_size=PIXEL, view="transmitted",
    )  # fmt: skip
    part = image[: 301 if options.quick else SIZE, : 401 if options.quick else SIZE]
    formula = fitting.fit(part, wavelength=WAVELENGTH, pixel_size=PIXEL, view="transmitted")
    bench = fitting.fit(part, scene=nj.newton_rings(1.7, WAVELENGTH, view="transmitted", screen=1e-3), pixel_size=PIXEL)
    table["ours"] |= {
        "line through six rings_m": line.radius,
        "whole image, gap formula_m": formula.radius,
        "whole image, bench_m": bench.radius,
        "bias of the gap formula by two slopes": (1 - 0.25 * AWAY) * (1 + 0.75 * AWAY) - 1,
    }
    for key, value in (*table["paper"].items(), *table["ours"].items()):
        print(key, value)
    for order, (pixel, radius) in PAPER.items():
        ours = table["ours"][f"ring {order}"]
        assert ours["whole pixel"] == pixel, "the rings do not fall on the paper's pixels"
        assert abs(ours["radius_whole_pixel_m"] - radius) < 5e-5
    assert abs(bench.radius / RADIUS - 1) < 1e-6, "the bench is biased"
    if not options.quick:
        records.save("figure7", table, draw(image, between))


def draw(image: np.ndarray, between: np.ndarray) -> Figure:
    """The image, with the rings read off it, and the row they were read from."""
    figure = Figure(figsize=(9.6, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.3))
    records.show(left, image, "transmitted, R = 2 m, 500 nm, 5 um pixels", PIXEL)
    row = image[SIZE // 2, SIZE // 2 :]
    right.plot(row, lw=0.9)
    for order, place in enumerate(between, 1):
        right.axvline(place, color="tab:red", lw=0.6)
        right.annotate(f"{order}\n{place:.2f}", (place, row.max()), fontsize=7, ha="center", va="bottom")
    right.set(xlabel="pixels from the centre", ylabel="intensity over the incident", ylim=(None, row.max() + 0.02))
    return figure


if __name__ == "__main__":
    main()
