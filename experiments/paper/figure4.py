"""Claim: in the air wedge, R1 meets R3 and R2 meets R4, numbered by face, in one plane: for oblique light.

Debelov and Dolgov (2021, section 4.1, figures 3 and 4) let four single reflections of two thick plates interfere and
say that, by trial, lens and screen stand so that R1 and R3 fall into one pixel and R2 and R4 into another. Head-on all
four fall together. With light at an angle t to the plates, in the plane of the wedge, the reflections of one plate
leave side by side, s = 2 d tan t' cos t apart (t': inside the glass), and those of the other are turned by twice the
wedge's angle: outer meets outer, and inner meets inner, at the height s / 2 angle. There the lens must focus. With R1
to R4 the reflections at the faces 0 to 3, as light meets them, that is what the paper says.

Measured: where each pair meets; how far the rays of a node land apart on the screen of a lens focused there; the three
images of figure 4 by `Splat` at one scale, and the same three by `Traced`, which adds the fields of all four where
`Splat` takes the mean of their pairs.

    python -m experiments.paper.figure4 [--quick]
"""

import dataclasses
from itertools import combinations

import jax
import jax.numpy as jnp
import numpy as np
from matplotlib.figure import Figure

import newtonjax as nj
from experiments import records
from newtonjax.rays import gather, trace

ANGLE, TILT, THICKNESS, FOCAL, PIXEL = 5e-4, 0.01, 5e-3, 0.05, 10e-6
FACES = {"R1": "R0", "R2": "R1", "R3": "R2", "R4": "R3"}  # the paper's names: ours
SETS = {"R1, R3": ("R1", "R3"), "R2, R4": ("R2", "R4"), "all four": tuple(FACES)}


def bench(names: tuple[str, ...]) -> nj.Scene:
    """The wedge with some of its reflections, and a lens (1:1) that images the plane of their meeting on the screen."""
    wedge = nj.air_wedge(
        ANGLE, 500e-9, 5e-6, screen=1e-3, light_tilt=(0.0, TILT), beams=[FACES[name] for name in names]
    )
    heights = [nj.meeting_height(wedge, FACES[one], FACES[two]) for one, two in (("R1", "R3"), ("R2", "R4"))]
    plane = sum(heights) / 2
    return dataclasses.replace(
        wedge,
        screen=nj.Surface(vertex=(0.0, 0.0, plane + 4 * FOCAL)),
        collecting_lens=nj.CollectingLens(FOCAL, (0.0, 0.0, plane + 2 * FOCAL)),
    )


def landings() -> np.ndarray:
    """Where the four rays of the node on the axis land on the screen [4, 2]."""
    routes, setting = gather(bench(tuple(FACES)))
    return np.asarray(jax.vmap(lambda route: trace(route, setting, jnp.zeros(2))[0].point)(routes))


def main() -> None:
    """Find the meetings, render the images, and write table and figure."""
    options = records.arguments(__doc__, "one pair, small images, nothing written")
    points, wedge = landings(), bench(tuple(FACES))
    inside = np.arcsin(np.sin(TILT) / 1.5)
    table = {
        "plane_by_formula_m": THICKNESS + 2 * THICKNESS * np.tan(inside) * np.cos(TILT) / (2 * ANGLE),
        "meeting_height_m": {
            f"{one} {two}": nj.meeting_height(wedge, FACES[one], FACES[two]) for one, two in combinations(FACES, 2)
        },
        "apart_on_the_screen_px": {
            f"{one} {two}": float(np.hypot(*(points[j] - points[i]))) / PIXEL
            for (i, one), (j, two) in combinations(enumerate(FACES), 2)
        },
    }
    # Parallel rays meet at infinity, which JSON does not know.
    heights = table["meeting_height_m"]
    table["meeting_height_m"] = {pair: z if np.isfinite(z) else "at infinity" for pair, z in heights.items()}
    camera = nj.Camera((60, 100) if options.quick else (240, 400), PIXEL)
    sets = {"R1, R3": SETS["R1, R3"]} if options.quick else SETS
    splatted = {name: nj.splat(bench(names), camera) for name, names in sets.items()}
    traced = {name: np.asarray(nj.render(bench(names), camera, nj.Traced())) for name, names in sets.items()}
    for name, found in splatted.items():
        table[f"splat, {name}"] = {
            **found.pairs._asdict(),
            "contrast": contrast(found.image),
            "phase_error_turns": found.error,
        }
        table[f"traced, {name}"] = {"contrast": contrast(traced[name])}
    for name in sets:
        difference = np.abs(splatted[name].image - traced[name]).max() / traced[name].max()
        table[f"splat, {name}"]["largest_difference_from_traced"] = float(difference)
        # Splat shows the mean over a pixel, and the fringes are 50 pixels wide. Of four beams it shows the mean of
        # pairs, which is not the sum of their fields.
        assert difference < 0.02 or name == "all four", "the paper's algorithm does not show the wedge's fringes"
    apart = table["apart_on_the_screen_px"]
    meet = ("R1 R3", "R2 R4")
    assert max(apart[pair] for pair in meet) < 1 < min(apart[pair] for pair in apart if pair not in meet)
    for key, value in table.items():
        print(key, value)
    if not options.quick:
        records.save("figure4", table, draw({name: f.image for name, f in splatted.items()}, traced))


def contrast(image: np.ndarray) -> float:
    """(I_max - I_min) / (I_max + I_min)."""
    return float(np.ptp(image) / (image.max() + image.min()))


def draw(splatted: dict, traced: dict) -> Figure:
    """Two rows of three images at one scale each: the largest intensity of the row."""
    figure = Figure(figsize=(9.6, 4.4), layout="constrained")
    for row, (method, images) in zip(figure.subplots(2, 3), (("Splat", splatted), ("Traced", traced)), strict=True):
        white = max(image.max() for image in images.values())
        for axes, (name, image) in zip(row, images.items(), strict=True):
            records.show(axes, image, f"{method}, {name}", PIXEL, white)
        row[0].set_ylabel(f"white is {white:.3f}", fontsize=8)
    return figure


if __name__ == "__main__":
    main()
