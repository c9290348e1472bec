"""Claim: the spherical wavelets of `Splat` err by the second order of a pair's separation, and by no more.

Debelov and Dolgov (2021, section 5) leave open how far their algorithm reaches. Here the phase that it gives a pair of
rays at the midpoint of their landing points is compared with the exact one, traced to that very point: R = 2 m, 500 nm,
within 3 mm of the axis, screens from 0.1 mm to 10 m. The prediction is Fermat's: half the separation's square times
the curvature of the wavefronts that spheres about the last surface points get wrong. Caustics crossed on the way to a
pair, each a quarter turn that the wavelets do not know, are counted.

    python experiments/wavelets.py [--quick]
"""

import argparse
import json
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

import newtonjax as nj
from newtonjax.fields import arrivals
from newtonjax.trace import gather, trace
from newtonjax.wavelets import pair_error, wavelet_opd

jax.config.update("jax_enable_x64", True)

RESULTS = Path(__file__).parent / "results"
RADIUS, WAVELENGTH, REACH = 2.0, 500e-9, 3e-3
SCREENS = (1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 3e-1, 1.0, 3.0, 10.0)


@jax.jit
def pairs_on_the_screen(scene, starts):
    """Midpoints [n, 2], separations, wavelets' path differences and their predicted errors [n], all in metres."""
    routes, setting = gather(scene)

    def node(start):
        one, two = (jax.tree.map(lambda leaf, b=b: leaf[b], routes) for b in (0, 1))
        first, second = trace(one, setting, start)[0], trace(two, setting, start)[0]
        pair = pair_error(one, two, setting, start)
        return (first.point + second.point) / 2, pair.separation, wavelet_opd(setting, first, second), pair.wavelet

    return jax.vmap(node)(starts)


@jax.jit
def exact(scene, points):
    """Path difference at points of the screen [m], caustics crossed by both beams together, and whether they arrive."""
    beams = arrivals(scene, points)
    return beams.path[1] - beams.path[0], beams.quarter_turns.sum(axis=0), beams.arrives.all(axis=0)


def measure(view: str, screen: float, count: int) -> dict:
    """One line of the table."""
    scene = nj.newton_rings(RADIUS, WAVELENGTH, view=view, screen=screen)
    radii = np.linspace(REACH / count, REACH, count)
    points, apart, wavelet, predicted = map(
        np.asarray, pairs_on_the_screen(scene, np.stack([radii, np.zeros(count)], axis=1))
    )
    path, caustics, arrives = map(np.asarray, exact(scene, jnp.asarray(points)))
    use = arrives & (caustics == 0)
    error, predicted = np.abs(wavelet - path) / WAVELENGTH, predicted / WAVELENGTH
    # 2e-10 waves is the rounding of the paths.
    clear = use & (error > 1e-8)
    slope = np.polyfit(np.log(radii[clear]), np.log(error[clear]), 1)[0] if clear.sum() > 3 else float("nan")
    beyond = {limit: radii[use & (error > limit)] for limit in (0.01, 0.1)}
    return {
        "view": view,
        "screen_m": screen,
        "error_waves": float(error[use].max()) if use.any() else None,
        "predicted_waves": float(predicted[use].max()) if use.any() else None,
        "grows_as_r_to": None if np.isnan(slope) else float(slope),
        "separation_m": float(apart[use].max()) if use.any() else None,
        "hundredth_beyond_m": float(beyond[0.01][0]) if len(beyond[0.01]) else None,
        "tenth_beyond_m": float(beyond[0.1][0]) if len(beyond[0.1]) else None,
        "behind_a_caustic": float(np.mean(arrives & (caustics != 0))),
        "no_single_ray": float(np.mean(~arrives)),
    }


def draw(table: list[dict], file: Path) -> None:
    """Error and prediction over the distance of the screen."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4.2), layout="constrained")
    axes = figure.subplots()
    for view, colour in (("reflected", "tab:red"), ("transmitted", "tab:blue")):
        rows = [row for row in table if row["view"] == view and row["error_waves"]]
        screens = [row["screen_m"] for row in rows]
        axes.loglog(screens, [row["error_waves"] for row in rows], "o", color=colour, label=f"{view}, measured")
        axes.loglog(screens, [row["predicted_waves"] for row in rows], "-", color=colour, label=f"{view}, second order")
    for limit in (0.01, 0.1):
        axes.axhline(limit, color="0.6", lw=0.8)
    axes.set(xlabel="distance of the screen [m]", ylabel="largest error within 3 mm [waves]")
    axes.legend()
    figure.savefig(file, dpi=100)


def main() -> None:
    """Measure every screen in both views and write table and figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one view, three screens, nothing written")
    options = parser.parse_args()
    views = ("reflected",) if options.quick else ("reflected", "transmitted")
    screens = (1e-3, 1e-2, 1e-1) if options.quick else SCREENS
    table = [measure(view, screen, 40 if options.quick else 300) for view in views for screen in screens]
    for row in table:
        print(json.dumps(row), flush=True)
    near = [row for row in table if row["screen_m"] in (1e-3, 1e-2, 1e-1)]
    assert all(abs(row["error_waves"] / row["predicted_waves"] - 1) < 0.2 for row in near), "not of second order"
    if not options.quick:
        RESULTS.mkdir(exist_ok=True)
        (RESULTS / "wavelets.json").write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
        draw(table, RESULTS / "wavelets.png")


if __name__ == "__main__":
    main()
