"""Claim: reflected rings as the paper shows them, with two beams, and with each of three that may be the third.

Debelov and Dolgov (2021, figure 10) compare reflected rings of two beams, R1 and R2, with those of three; their drawing
(figure 9) is not at hand. The third may be the reflection at the plate's lower face, at the lens's flat face, or the
next order in the gap. Each is shown by `Splat`, which takes beams pair by pair, and by `Chebyshev`, which adds all the
fields, with its contrast near the axis and the share of the light that it brings. The phase of a reflection at an outer
face is that of the glass on its way: 20 nm more of it turn the picture about, so its contrast is given as a range over
half a wave of thickness (the pictures are for 5 mm exactly, which is a whole number of waves).

    python -m experiments.paper.figure10 [--quick]
"""

import numpy as np
from matplotlib.figure import Figure

import newtonjax as nj
from experiments import records

THIRD = {
    "R1, R2": None,
    "and the plate's lower face": "R3",
    "and the lens's flat face": "R0",
    "and the next order in the gap": "R2-R1-R2",
}
PIXEL = 8.5e-6


def scene(third: str | None) -> nj.Scene:
    """R = 2 m, 500 nm, a screen 1 mm over the lens."""
    return nj.newton_rings(2.0, 500e-9, view="reflected", beams=["R1", "R2", *([third] if third else [])], screen=1e-3)


def main() -> None:
    """Render all, and write table and figure."""
    options = records.arguments(__doc__, "two beams, small images, nothing written")
    size = 120 if options.quick else 480
    camera = nj.Camera((size, size), 500 * PIXEL / size)
    images, table = {}, {}
    for name, third in list(THIRD.items())[: 1 if options.quick else None]:
        bench = scene(third)
        exact = np.asarray(nj.render(bench, camera, nj.Chebyshev()))
        # Wide enough for the outermost pairs, which land 12 um apart.
        found = nj.splat(bench, camera, nj.Splat(epsilon=1e-3))
        assert found.pairs.emitted == sum(found.pairs[1:]), "the books do not add up"
        energies = {beam.word: beam.energy for beam in nj.enumerate_beams(bench.media, "reflected")}
        images[name] = {"Splat": found.image, "Chebyshev": exact}
        table[name] = {
            "contrast_over_half_a_wave_of_glass": over_thickness(third, camera),
            "share_of_the_light": energies[bench.beams[-1]] / sum(energies[word] for word in bench.beams),
            "contrast": {method: contrast(image) for method, image in images[name].items()},
            "largest_difference": float(np.abs(found.image - exact).max() / exact.max()),
            "phase_error_turns": found.error,
            **found.pairs._asdict(),
        }
        print(name, table[name])
    # One ray a pixel falls up to half a pixel from its middle, where a fringe is 19 pixels wide in the corners.
    assert options.quick or table["R1, R2"]["largest_difference"] < np.pi / 19, "Splat does not show the rings"
    if not options.quick:
        records.save("figure10", table, draw(images))


def over_thickness(third: str | None, camera: nj.Camera) -> list[float]:
    """Least and largest contrast for lens and plate up to half a wave thicker than 5 mm: the third beam's phase."""
    found = []
    for more in np.arange(8) / 8 * 500e-9 / 2 / 1.5:
        bench = nj.newton_rings(
            2.0,
            500e-9,
            view="reflected",
            beams=scene(third).beams,
            lens_thickness=5e-3 + more,
            plate_thickness=5e-3 + more,
            screen=1e-3,
        )
        found.append(contrast(np.asarray(nj.render(bench, camera, nj.Chebyshev()))))
    return [min(found), max(found)]


def contrast(image: np.ndarray) -> float:
    """(I_max - I_min) / (I_max + I_min) within the first three rings, a quarter of the frame to a side."""
    rows, columns = image.shape
    part = image[3 * rows // 8 : 5 * rows // 8, 3 * columns // 8 : 5 * columns // 8]
    return float(np.ptp(part) / (part.max() + part.min()))


def draw(images: dict) -> Figure:
    """A row a method, a column a set of beams."""
    figure = Figure(figsize=(12.4, 6.4), layout="constrained")
    for axes, (name, pair) in zip(figure.subplots(2, 4).T, images.items(), strict=True):
        for place, (method, image) in zip(axes, pair.items(), strict=True):
            records.show(place, image, f"{method}: {name}", 500 * PIXEL / len(image))
    return figure


if __name__ == "__main__":
    main()
