"""Claim: the spherical wavelets of `Splat` err by the second order of a pair's separation.

Debelov and Dolgov (2021, section 5) leave open how far their algorithm reaches. Here the phase that it gives a pair of
rays at the midpoint of their landing points is compared with the exact one, traced to that very point (500 nm). The
prediction is Fermat's: half the separation's square times the curvature of the wavefronts that spheres about the last
surface points get wrong; with the screen at 0.3 mm and nearer, higher orders add to it. Measured: R = 2 m within 3 mm
of the axis over screens from 0.1 mm to 10 m; lenses from 10 mm to 10 m within their tenth ring over the same screens,
with the boundaries of 1/100 and 1/10 wave; gaps up to 10 mm; and tilts of the light and of the lens. Where a caustic
lies between lens and screen the wavelets, which know no quarter turns, are not compared but marked.

    python -m experiments.paper.wavelets [--quick]
"""

import jax
import jax.numpy as jnp
import numpy as np
from matplotlib.figure import Figure

import newtonjax as nj
from experiments import records
from newtonjax.fields import arrivals_at
from newtonjax.methods.wavelets import pair_error, wavelet_opd
from newtonjax.rays import gather, trace

RADII = np.geomspace(1e-2, 10, 13).tolist()
LIMITS = (0.01, 0.1)
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
        return (first.point + second.point) / 2, pair.separation, wavelet_opd(setting, first, second), pair.error

    return jax.vmap(node)(starts)


@jax.jit
def exact(scene, points):
    """Path difference at points of the screen [m], caustics crossed by both beams together, and whether they arrive."""
    beams = arrivals_at(scene, points)
    return beams.path[1] - beams.path[0], beams.quarter_turns.sum(axis=0), beams.arrives.all(axis=0)


def measure(scene: nj.Scene, reach: float, count: int) -> dict:
    """Largest error on a line of launch points up to so far from the axis, its prediction, and where it grows."""
    radii = np.linspace(reach / count, reach, count)
    points, apart, wavelet, predicted = map(
        np.asarray, pairs_on_the_screen(scene, np.stack([radii, np.zeros(count)], axis=1))
    )
    path, caustics, arrives = map(np.asarray, exact(scene, jnp.asarray(points)))
    use = arrives & (caustics == 0)
    error, predicted = np.abs(wavelet - path) / WAVELENGTH, predicted / WAVELENGTH
    # 2e-10 waves is the rounding of the paths.
    clear = use & (error > 1e-8)
    slope = np.polyfit(np.log(radii[clear]), np.log(error[clear]), 1)[0] if clear.sum() > 3 else float("nan")
    beyond = {limit: radii[use & (error > limit)] for limit in LIMITS}
    return {
        "error_waves": float(error[use].max()) if use.any() else None,
        "predicted_waves": float(predicted[use].max()) if use.any() else None,
        "grows_as_r_to": None if np.isnan(slope) else float(slope),
        "separation_m": float(apart[use].max()) if use.any() else None,
        "hundredth_beyond_m": float(beyond[0.01][0]) if len(beyond[0.01]) else None,
        "tenth_beyond_m": float(beyond[0.1][0]) if len(beyond[0.1]) else None,
        "behind_a_caustic": float(np.mean(arrives & (caustics != 0))),
        "no_single_ray": float(np.mean(~arrives)),
    }


def over_screens(views, screens, count: int) -> list[dict]:
    """R = 2 m within 3 mm of the axis."""
    return [
        {"view": view, "screen_m": screen, **measure(rings(RADIUS, view, screen), REACH, count)}
        for view in views
        for screen in screens
    ]


def over_radii(views, radii, screens) -> list[dict]:
    """Lenses of all radii within their tenth ring."""
    return [
        {
            "view": view,
            "radius_m": radius,
            "screen_m": screen,
            **measure(rings(radius, view, screen), np.sqrt(10 * WAVELENGTH * radius), 20),
        }
        for view in views
        for radius in radii
        for screen in screens
    ]


def over_gaps_and_tilts(views) -> list[dict]:
    """R = 2 m, a screen 10 mm away, one thing changed at a time."""
    changes = [{"gap": gap} for gap in (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)]
    changes += [{"light_tilt": (0.0, tilt)} for tilt in (1e-3, 1e-2, 3e-2, 0.1, 0.3)]
    changes += [{"lens_tilt": (0.0, tilt)} for tilt in (1e-4, 1e-3, 3e-3, 1e-2)]
    return [
        {"view": view, **change, **measure(rings(RADIUS, view, 1e-2, **change), REACH, 60)}
        for view in views
        for change in changes
    ]


def rings(radius: float, view: str, screen: float, **changes) -> nj.Scene:
    """A bench. The lens is thick enough for the steepest face."""
    return nj.newton_rings(radius, WAVELENGTH, view=view, screen=screen, **changes)


def draw(table: dict) -> Figure:
    """Error over the screen's distance; and over radius and distance, with the boundaries and the caustics."""
    figure = Figure(figsize=(13, 4.2), layout="constrained")
    first, *maps = figure.subplots(1, 3)
    for view, colour in (("reflected", "tab:red"), ("transmitted", "tab:blue")):
        rows = [row for row in table["screens"] if row["view"] == view and row["error_waves"]]
        screens = [row["screen_m"] for row in rows]
        first.loglog(screens, [row["error_waves"] for row in rows], "o", color=colour, label=f"{view}, measured")
        first.loglog(screens, [row["predicted_waves"] for row in rows], "-", color=colour, label=f"{view}, predicted")
    for limit in LIMITS:
        first.axhline(limit, color="0.6", lw=0.8)
    first.set(xlabel="distance of the screen [m]", ylabel="largest error [waves]", title="R = 2 m, within 3 mm")
    first.legend(fontsize=8)
    for axes, view in zip(maps, ("reflected", "transmitted"), strict=True):
        rows = [row for row in table["radii"] if row["view"] == view]
        radii, screens = (sorted({row[key] for row in rows}) for key in ("radius_m", "screen_m"))
        shape = (len(radii), len(screens))
        error = np.array([row["error_waves"] or np.nan for row in rows]).reshape(shape)
        marked = np.array([row["behind_a_caustic"] + row["no_single_ray"] > 0 for row in rows]).reshape(shape)
        drawn = axes.pcolormesh(screens, radii, np.log10(error), vmin=-6, vmax=1, shading="nearest")
        axes.contour(screens, radii, np.log10(error), levels=np.log10(LIMITS), colors=["white", "red"])
        across, up = np.meshgrid(screens, radii)
        axes.plot(across[marked], up[marked], "kx", ms=4)
        axes.set(xscale="log", yscale="log", xlabel="distance of the screen [m]", ylabel="radius of the lens [m]")
        axes.set_title(f"{view}, within ring 10 (white 1/100, red 1/10 wave; x: caustic)", fontsize=9)
        figure.colorbar(drawn, ax=axes, label="log10 of the largest error [waves]")
    return figure


def main() -> None:
    """Measure and write table and figure."""
    options = records.arguments(__doc__, "one view, few screens, nothing written")
    views = ("reflected",) if options.quick else ("reflected", "transmitted")
    screens = (1e-3, 1e-2, 1e-1) if options.quick else SCREENS
    radii, distances = ((0.1, 2.0), (1e-3, 1e-1)) if options.quick else (RADII, np.geomspace(1e-4, 10, 21).tolist())
    table = {
        "screens": over_screens(views, screens, 40 if options.quick else 300),
        "radii": over_radii(views, radii, distances),
        "gaps and tilts": over_gaps_and_tilts(views),
    }
    for rows in table.values():
        for row in rows:
            print(row, flush=True)
    near = [row for row in table["screens"] if row["screen_m"] in (1e-3, 1e-2, 1e-1)]
    assert all(abs(row["error_waves"] / row["predicted_waves"] - 1) < 0.2 for row in near), "not of second order"
    if not options.quick:
        records.save("wavelets", table, draw(table))


if __name__ == "__main__":
    main()
