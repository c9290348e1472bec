"""Claim: what `explain` predicts bounds what really happens, and the plan is as fast as any method that will do.

Random benches (`accuracy.random_bench`; every third focused on the gap and upright, where the formula applies too, half
of these within the paraxial region). For each: the plan's error against rays at every pixel, and what `explain` says of
polarization, of the exact sphere, of the rays and of the mean over a pixel against images with and without them. Then
the plan's time beside that of every method whose real error keeps the tolerance, at 512 x 512 pixels, taking turns.

    python -m experiments.accuracy.planner [--quick]
"""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np

import newtonjax as nj
from experiments import records
from experiments.accuracy import accuracy
from newtonjax.fields import closed_fields, intensity
from newtonjax.scene import Surface

TOLERANCE = 1e-3
PIXELS, FAST, LADDER, TURNS = 96, 512, (3, 4, 5, 7, 9, 13, 17, 25), 7


def draw(random: np.random.Generator, number: int):
    """A bench and a camera of 96 x 96 pixels."""
    scene, camera = accuracy.random_bench(random, ("transmitted", "reflected")[number % 2], PIXELS)
    if number % 3 == 0:
        radius, light = 1 / float(scene.surfaces[1].curvature), float(scene.wavelength)
        scene = nj.newton_rings(radius, light, random.uniform(0, 2e-6), scene.view, screen="gap")
    return scene, camera


def worst(one, other) -> float:
    return float(jnp.abs(one - other).max() / jnp.maximum(one.max(), other.max()))


def with_and_without(scene, camera) -> dict[str, float]:
    """Largest change of intensity over the peak that leaving out a part really makes, by name as in `explain`."""
    image = nj.render(scene, camera, nj.Traced())
    light = scene.light
    found = {
        "polarization": max(
            worst(image, nj.render(replace(scene, light=replace(light, polarization=angle)), camera, nj.Traced()))
            for angle in (0.0, np.pi / 2)
        )
    }
    fine = 5  # points to a side of a pixel
    small = replace(camera, shape=(PIXELS * fine, PIXELS * fine), pixel_size=float(camera.pixel_size) / fine)
    if float(camera.pixel_size) > 0:
        mean = nj.render(scene, small).reshape(PIXELS, fine, PIXELS, fine).mean(axis=(1, 3))
        found["mean over each pixel"] = worst(image, mean)
    if nj.ClosedForm().refusal(scene) is None:
        x, y = (jnp.asarray(axis) for axis in np.meshgrid(*(np.asarray(a) for a in camera.axes())))
        formula = intensity(closed_fields(scene, x, y))
        found["rays"] = worst(image, formula)
        parabola = intensity(closed_fields(scene, x, y, Surface.parabola))
        found["exact sphere"] = worst(formula, parabola)
    return found


def keeps(scene, camera, method, truth) -> bool:
    """Whether a method's real error keeps the tolerance; one that refuses the scene does not."""
    try:
        return worst(truth, nj.render(scene, camera, method)) <= TOLERANCE
    except ValueError:
        return False


def race(scene, camera, chosen) -> float:
    """The plan's time over that of the fastest method whose real error keeps the tolerance."""
    truth = nj.render(scene, camera, nj.Traced())
    methods = [nj.Chebyshev(n) for n in LADDER] + ([] if nj.ClosedForm().refusal(scene) else [nj.ClosedForm()])
    good = [m for m in methods if m != chosen.method and keeps(scene, camera, m, truth)]
    large = replace(camera, shape=(FAST, FAST), pixel_size=float(camera.pixel_size) * PIXELS / FAST)
    runs = {m: (lambda m=m: nj.render(scene, large, m)) for m in good}
    runs["plan"] = lambda: nj.render(chosen.scene, large, chosen.method)
    seconds = records.medians(runs, TURNS)
    return seconds["plan"] / min(seconds.values())


def main(quick: bool) -> None:
    random = np.random.default_rng(5)
    rows, ratios = [], []
    for number in range(3 if quick else 100):
        scene, camera = draw(random, number)
        said = nj.explain(scene, camera, TOLERANCE)
        truth = nj.render(scene, camera, nj.Traced())
        image = nj.render(said.plan.scene, camera, said.plan.method)
        if not isinstance(said.plan.method, nj.Traced):
            rows.append(("method", said.plan.intensity_error, worst(truth, image)))
        predicted = {part.part: part.error for part in said.omissions}
        for part, real in with_and_without(scene, camera).items():
            if part in predicted:
                rows.append((part, predicted[part], real))
        if not quick or number == 0:
            ratios.append(race(scene, camera, said.plan))
    table = []
    for part in dict.fromkeys(row[0] for row in rows):
        pairs = np.array([row[1:] for row in rows if row[0] == part])
        over = pairs[:, 0] / np.maximum(pairs[:, 1], 1e-12)
        table.append(
            {
                "predicted": part,
                "scenes": len(pairs),
                "bounded": float(np.mean(over >= 1)),
                "median_over": float(np.median(over)),
                "largest_real": float(pairs[:, 1].max()),
            }
        )
    near = float(np.mean(np.array(ratios) <= 1.5))
    for part, said, real in rows:
        if not said >= real:
            print(f"not bounded: {part}, predicted {said:.3g}, real {real:.3g}")
    for line in table:
        print(line)
        assert line["bounded"] >= (0.99 if not quick else 0.6), line
    print(f"plan within 1.5 of the fastest in {near:.0%} of {len(ratios)}; median {np.median(ratios):.2f}")
    if not quick:
        records.save("planner", {"table": table, "plan_over_fastest": sorted(ratios), "within_1.5": near})


if __name__ == "__main__":
    main(records.arguments(__doc__, "three benches, nothing written").quick)
