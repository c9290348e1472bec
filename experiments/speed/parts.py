"""Claim: a part that a scene does not have costs nothing, and but for beams a part costs little where it is.

A focused microscope on upright, linearly polarized rings, two beams (the closed form), and the same bench with each
part put in: operations by the compiler's own count and time, of the method that `plan` chooses (1024 x 1024 pixels,
within 1e-3 of the peak), and of rays at every pixel (128 x 128), over those of the bench without it. Tilts and
distances are numbers: rays cost the same with and without them, and what goes with them is the closed form.

    python -m experiments.speed.parts [--quick]
"""

from functools import partial

import jax

import newtonjax as nj
from experiments import records

RINGS = partial(nj.newton_rings, 2.0, 550e-9, 0.3e-6, "reflected", screen=1e-3, polarization=0.0)
BARE = {"screen": "gap"}
THIRD = {"beams": ["R1", "R2", "R3"]}
# What is put in, and into what.
PARTS = {
    "unpolarized light": (BARE, {"polarization": None}),
    "tilted lens": (BARE, {"lens_tilt": (1e-3, 0.0)}),
    "screen at 10 mm": (BARE, {"screen": 10e-3}),
    "third beam": (BARE, THIRD),
    "unpolarized light, screen at 10 mm": ({"screen": 10e-3}, {"polarization": None}),
    "third beam, screen at 10 mm": ({"screen": 10e-3}, THIRD),
    "shield, screen at 10 mm": ({"screen": 10e-3}, {"shield": 4e-3}),
    "collecting lens, screen at 1 m": ({"screen": 1.0}, {"collecting_lens": 0.1}),
}


def image_of(scene, camera, method):
    """The compiled image, and its operations."""
    compiled = jax.jit(lambda s, c: method.image(s, c)).lower(scene, camera).compile()
    return (lambda: compiled(scene, camera)), compiled.cost_analysis()["flops"]


def main(quick: bool) -> None:
    size, small, rounds = (256, 32, 3) if quick else (1024, 128, 31)
    table = []
    for name, (without, more) in PARTS.items():
        row = {"part": name}
        for kind, pixels in (("planned", size), ("rays", small)):
            camera = nj.Camera((pixels, pixels), 4e-3 / pixels)
            runs, flops = {}, {}
            for which, given in (("without", without), ("with", {**without, **more})):
                scene = RINGS(**given)
                method = nj.plan(scene, camera).method if kind == "planned" else nj.Traced()
                runs[which], flops[which] = image_of(scene, camera, method)
                row[f"{kind}_{which}"] = repr(method)
            seconds = records.medians(runs, rounds)
            row[f"{kind}_operations"] = flops["with"] / flops["without"]
            row[f"{kind}_time"] = seconds["with"] / seconds["without"]
        table.append(row)
        print({key: value if isinstance(value, str) else round(value, 2) for key, value in row.items()}, flush=True)
    for row in table:
        if "beam" in row["part"]:
            assert row["rays_operations"] > 1.01, row
        assert quick or row["planned_time"] < 3, row
    if not quick:
        records.save("parts", table)


if __name__ == "__main__":
    main(records.arguments(__doc__, "256 x 256 pixels, nothing written").quick)
