"""Claim: what the simulator draws with its defaults, the fit with its defaults measures within its stated deviation.

`fit(render(newton_rings(R, wavelength, gap, view), camera), wavelength=..., pixel_size=..., view=...)` over 200 random
benches: radius 5 mm to 100 m, gap to 5 um, both views, 8 to 40 rings in 256 x 256 pixels, no noise. At least 99 % of
the radii lie within three stated standard deviations of the truth. Beside that the same benches with their gap held:
what is left then is the tolerance of `render`, which draws 2 n t alone where a microscope adds less than that.

    python -m experiments.truth.round_trip [--quick]
"""

import warnings
from typing import NamedTuple

import numpy as np

import fitting
import newtonjax as nj
from experiments import records

WAVELENGTH, SIZE = 589.3e-9, 256


class Bench(NamedTuple):
    """A random bench and its camera, in SI units."""

    radius: float
    gap: float
    view: str
    pixel_size: float
    centre: tuple[float, float]


def random_bench(random: np.random.Generator) -> Bench:
    """One of the benches of the claim."""
    radius = float(np.exp(random.uniform(np.log(5e-3), np.log(100.0))))
    gap, view = float(random.uniform(0, 5e-6)), str(random.choice(["reflected", "transmitted"]))
    pixel_size = float(np.sqrt(random.uniform(8, 40) * radius * WAVELENGTH) / (SIZE / np.sqrt(2)))
    x, y = SIZE / 2 + random.uniform(-0.2, 0.2, 2) * SIZE
    return Bench(radius, gap, view, pixel_size, (float(x), float(y)))


def row(bench: Bench) -> dict:
    """One round trip: the error in radii and in stated deviations, with the gap free and held."""
    scene = nj.newton_rings(bench.radius, WAVELENGTH, bench.gap, bench.view)
    camera = nj.Camera((SIZE, SIZE), bench.pixel_size, centre_px=bench.centre)
    image = np.asarray(nj.render(scene, camera))
    numbers = bench._asdict()
    for name, fixed in (("free", None), ("held", {"gap": bench.gap})):
        given = {"wavelength": WAVELENGTH, "pixel_size": bench.pixel_size, "view": bench.view, "fixed": fixed}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = fitting.fit(image, **given)
        numbers[f"status_{name}"] = result.status
        if result.radius is None or result.radius_sd is None:
            continue
        error = result.radius - bench.radius
        numbers |= {f"error_{name}": error / bench.radius, f"deviations_{name}": error / result.radius_sd}
    return numbers


def summary(rows: list[dict], name: str) -> dict:
    """How many lie within three deviations, the largest error in these, and the median error in radii."""
    deviations = np.abs([entry.get(f"deviations_{name}", np.inf) for entry in rows])
    errors = np.abs([entry.get(f"error_{name}", np.inf) for entry in rows])
    within = int(np.count_nonzero(deviations < 3))
    return {"within_three": within, "largest_deviations": deviations.max(), "median_error": float(np.median(errors))}


def main(quick: bool) -> None:
    random = np.random.default_rng(0)
    rows = [row(random_bench(random)) for _ in range(8 if quick else 200)]
    table = {name: summary(rows, name) for name in ("free", "held")}
    for name, figures in table.items():
        print(
            f"gap {name}: {figures['within_three']} of {len(rows)} within 3 deviations, largest "
            f"{figures['largest_deviations']:.2f}, median error {figures['median_error']:.1e} of R"
        )
    assert table["free"]["within_three"] >= 0.99 * len(rows), "the round trip does not close"
    if not quick:
        records.save("round_trip", {"summary": table, "benches": rows})


if __name__ == "__main__":
    main(records.arguments(__doc__, "eight benches").quick)
