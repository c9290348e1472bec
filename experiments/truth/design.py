"""Claim: designs by gradient beat a grid of 10 000 renders in result and cost.

Three benches: Newton's rings before a telephone's camera, a test plate of 50 mm in a workshop, and a microsphere of
10 um in water under a microscope. Each is designed by `fitting.design`, and by the best of a grid of 10 000 designs
that keeps the limits. The grid is charged one render of the sensor a design (to judge one takes seven, by differences;
here it is judged by our own forecast, which is much cheaper). What is known of wavelength and index leaves the same
share of the radius to every design of a focused bench; it is small here, so that it does not hide what a design gains.

Then photographs of the design, with shot and read noise, in codes, and with the errors of what is known drawn, are
measured by `fitting.measurement`, which weighs pixels by their noise: scatter of the radius over the forecast.
`fitting.fit` weighs all pixels alike: it is held against the forecast of that, (JᵀJ)⁻¹ JᵀVJ (JᵀJ)⁻¹, on 256 x 256
pixels.

    python -m experiments.truth.design [--photographs 100] [--fits 100] [--quick]
"""

import argparse
import shutil
import time
from dataclasses import replace

import jax
import numpy as np
from jax import numpy as jnp
from matplotlib.figure import Figure

import fitting
import newtonjax as nj
from experiments import records
from fitting.parameters import chosen, free_names, knobs
from fitting.studies.design_job import DesignTask
from fitting.studies.electrons import photoelectrons, variance
from fitting.studies.prospects import Limits, forecast
from newtonjax.verbs.normal import from_coefficients

jax.config.update("jax_enable_x64", True)


def microsphere(radius: float, wavelength: float, gap: float) -> nj.Scene:
    """A sphere in water under a cover glass, seen through it by an oil immersion objective focused on the glass."""
    faces = (0.17e-3, 0.0), (0.0, 0.0), (-gap, -1 / radius), (-gap - 2 * radius, 1 / radius)  # height, curvature
    return nj.Scene(
        surfaces=tuple(nj.Surface(curvature, (0.0, 0.0, height)) for height, curvature in faces),
        media=(1.515, 1.515, 1.333, 1.59, 1.333),
        light=nj.Light(wavelength),
        screen=nj.Surface(),
        beams=("T0 R1 T0", "T0 T1 R2 T1 T0"),
    )


# Bench, sensor, what varies, how well the rest is known, and the share of the field on which `fit` is tried.
PROBLEMS = {
    "teaching laboratory, telephone": (
        nj.newton_rings(1.0, 589.3e-9, 0.1e-6, "reflected", screen="gap"),
        nj.Camera((3000, 4000), 2e-6, exposure=20_000.0, full_well=6000.0, read_noise=3.0, bits=8),
        {"field": (2e-3, 12e-3), "pixel_size": (2e-6, 20e-6), "exposure": (1e3, 1e6)},
        {"wavelength": 6e-15},
        1 / 3,
    ),
    "workshop, test plate of 50 mm": (
        nj.newton_rings(0.05, 632.8e-9, 0.2e-6, "reflected", screen="gap"),
        nj.Camera((2048, 2448), 2e-6, exposure=50_000.0, full_well=10_000.0, read_noise=3.0, bits=12),
        {"field": (0.2e-3, 4e-3), "pixel_size": (0.5e-6, 5e-6), "gap": (0.05e-6, 5e-6), "exposure": (1e3, 1e6)},
        {"wavelength": 6e-15},
        1 / 3,
    ),
    "microsphere of 10 um in water": (
        microsphere(10e-6, 550e-9, 0.1e-6),
        nj.Camera((2048, 2048), 3.45e-9, exposure=1e6, full_well=30_000.0, read_noise=2.0, bits=16),
        {"wavelength": (400e-9, 700e-9), "field": (1e-6, 6e-6), "gap": (0.05e-6, 1e-6), "exposure": (1e4, 1e7)},
        {"wavelength": 1e-13, "gap_index": 1e-6},
        1.0,
    ),
}
_GRID = 10_000
# Parts of a photograph that these benches do not have: not looked for.
PARTS = dict.fromkeys(("oblique_view", "distortion", "fifth_order", "lens_form", "contact", "film"), False)


def by_grid(scene, camera, vary, known, count: int) -> tuple[float, int]:
    """Least relative deviation on the grid, and how many of its designs keep the limits."""
    job = DesignTask(scene, camera, vary, {}, "radius", None, known, None)
    layout, bench = job.layout(9, 64), job.bench(Limits(2.5, 0.9, 0.5, np.inf))
    each = round(count ** (1 / len(vary)))
    axes = [np.geomspace(low, high, each) for low, high in vary.values()]
    designs = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    found = [forecast(layout, bench, design, job.over[:1]) for design in designs]
    total, used = (np.concatenate([getattr(one, name) for one in found]) for name in ("total", "used"))
    feasible = np.all(used <= 1 + 1e-9, axis=1) & np.isfinite(total)
    return float(np.exp(total[feasible].min())) if feasible.any() else np.inf, int(feasible.sum())


def beside_a_render(scene, camera, vary, known, rounds: int) -> dict[str, float]:
    """Median seconds of a design, and of a render of the sensor, its method chosen beforehand."""
    method = nj.plan(scene, camera).method
    runs = {
        "design": lambda: fitting.design(scene, camera, vary, sd=known, starts=1).relative_sd,
        "render": lambda: nj.render(scene, camera, method),
    }
    return records.medians(runs, rounds)


def photograph(scene, camera, known, random: np.random.Generator, method=None) -> np.ndarray:
    """In incident irradiance, as the camera's codes tell it; scene and camera with errors of what is known."""
    knob = knobs(scene, camera)
    for name, sd in known.items():
        scene, camera = knob[name].move(scene, camera, sd * random.normal())
    arrived = random.poisson(np.asarray(nj.render(scene, camera, method)) * camera.exposure)
    code = camera.full_well / (2**camera.bits - 1)
    codes = np.clip(
        np.round((arrived + camera.read_noise * random.normal(size=camera.shape)) / code), 0, 2**camera.bits - 1
    )
    return codes * (code / camera.exposure)


def scatter(design, known, count: int) -> tuple[float, float]:
    """Scatter and mean error of the radius over its value, by `measurement`."""
    scene, camera = design.scene, design.camera
    method = nj.plan(scene, camera, 1e-6).method
    measure = fitting.measurement(scene, camera, method=nj.Chebyshev(9))
    images = (photograph(scene, camera, known, np.random.default_rng(seed), method) for seed in range(count))
    off = np.array([float(measure(image).numbers["radius"]) for image in images]) / design.over[0] - 1
    return float(np.std(off, ddof=1)), float(np.mean(off))


def scatter_of_fits(design, share: float, count: int) -> tuple[float, float]:
    """Scatter of the radius by `fit` over what noise leaves, and over the forecast of equal weights.

    On 256 x 256 pixels over a share of the field, in which these resolve the fringes.
    """
    whole = design.camera
    size = share * min(whole.shape) * float(whole.pixel_size) / 256
    camera = replace(whole, shape=(256, 256), pixel_size=size, centre_px=None)
    found = []
    for seed in range(count):
        image = photograph(design.scene, camera, {}, np.random.default_rng(seed)) * camera.exposure / camera.full_well
        found.append(fitting.fit(image, scene=design.scene, pixel_size=size, parts=PARTS).radius)
    off = float(np.std(np.array(found, dtype=float), ddof=1))
    return off / fitting.information(design.scene, camera).sd("radius"), off / equal_weights(design.scene, camera)


def equal_weights(scene, camera) -> float:
    """Forecast of the radius's deviation by noise, of a fit that weighs all pixels alike [m]."""
    present = knobs(scene, camera)
    numbers = chosen(present, free_names(present, None))
    moves = tuple((name, knob.move) for name, knob in numbers.items())
    scales = jnp.array([knob.scale for knob in numbers.values()])
    of_steps, still = photoelectrons(scene, camera, moves, scales, nj.Chebyshev(17)), jnp.zeros(len(moves))
    alike = from_coefficients(of_steps, still, camera.shape, None, jnp.ones_like).matrix
    noisy = from_coefficients(of_steps, still, camera.shape, None, lambda image: variance(image, camera)).matrix
    inverse = jnp.linalg.inv(alike)
    return float(jnp.sqrt((inverse @ noisy @ inverse)[0, 0]) * scales[0])


def draw(rows, designs) -> Figure:
    """Each designed image, or its middle, and what the design gains beside the bench as it was and the grid."""
    figure = Figure(figsize=(11, 6.4), layout="constrained")
    axes = figure.subplots(2, 3, squeeze=False)
    for k, (row, design) in enumerate(zip(rows, designs, strict=True)):
        whole = design.camera
        # As many pixels as the picture shows singly.
        camera = replace(whole, shape=tuple(min(n, 600) for n in whole.shape), centre_px=None)
        if row["problem"].startswith("microsphere"):
            camera = replace(
                whole, shape=(600, 600), pixel_size=whole.pixel_size * whole.shape[0] / 600, centre_px=None
            )
        half = 0.5 * float(camera.pixel_size) * 600
        size, unit = (1e6, "um") if half < 1e-4 else (1e3, "mm")
        edge = half * size
        image = np.asarray(nj.render(design.scene, camera))
        axes[0, k].imshow(image, cmap="gray", extent=(-edge, edge, edge, -edge))
        wide = float(whole.pixel_size) * size * np.array(whole.shape)
        axes[0, k].set(title=row["problem"], xlabel=f"x [{unit}], of a field of {wide[1]:.3g} x {wide[0]:.3g} {unit}")
        names = ["as it was", "best of grid", "design", "measured"]
        was = np.nan if row["as_it_was"] is None else row["as_it_was"]
        values = [was, row["grid"], row["relative_sd"], row["relative_sd"] * row["scatter_over_forecast"]]
        axes[1, k].bar(names, values, color=["0.6", "tab:orange", "tab:blue", "tab:green"])
        axes[1, k].set(ylabel="relative sd of the radius" if k == 0 else "")
        axes[1, k].set_title(
            f"found in 1/{row['grid_seconds_over_design']:.0f} of the time of 10 000 renders", fontsize=9
        )
        axes[1, k].set_xticks(range(4), names if np.isfinite(was) else ["(breaks a limit)", *names[1:]], fontsize=8)
    return figure


def main() -> None:
    """Design, search the grid, measure; print and keep the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photographs", type=int, default=100)
    parser.add_argument("--fits", type=int, default=100)
    parser.add_argument("--quick", action="store_true", help="the workshop with two photographs, nothing written")
    options = parser.parse_args()
    if options.quick:
        options.photographs, options.fits = 2, 0
    rows, designs, asked = [], [], list(PROBLEMS.items())
    for name, (scene, camera, vary, known, share) in asked[1:2] if options.quick else asked:
        begin = time.perf_counter()
        design = fitting.design(scene, camera, vary, sd=known, starts=1)
        first = time.perf_counter() - begin
        designs.append(design)
        print(design, flush=True)
        seconds = beside_a_render(scene, camera, vary, known, 1 if options.quick else 7)
        grid, feasible = by_grid(scene, camera, vary, known, 256 if options.quick else _GRID)
        spread, bias = scatter(design, known, options.photographs)
        over_noise, over_theirs = scatter_of_fits(design, share, options.fits) if options.fits else (np.nan, np.nan)
        rows.append(
            {
                "problem": name,
                "design": design.values,
                "bindings": [f"{one.name} ({one.side})" for one in design.bindings],
                "relative_sd": design.relative_sd,
                "as_it_was": design.before_sd,
                "grid": grid,
                "grid_feasible": feasible,
                "grid_over_design": grid / design.relative_sd,
                "seconds": seconds["design"],
                "first_seconds": first,
                "evaluations": design.evaluations,
                "render_seconds": seconds["render"],
                "grid_seconds_over_design": _GRID * seconds["render"] / seconds["design"],
                "forecast_noise_sd": design.noise_sd,
                "photographs": options.photographs,
                "scatter_over_forecast": spread / design.relative_sd,
                "bias_over_forecast": bias / design.relative_sd,
                "fits": options.fits,
                "scatter_of_fits_over_noise": over_noise,
                "scatter_of_fits_over_equal_weights": over_theirs,
            }
        )
        print({key: value for key, value in rows[-1].items() if key not in ("design", "bindings")}, flush=True)
        if not options.quick:
            records.save("design", rows, draw(rows, designs))
            shutil.copy(records.RESULTS / "design.png", records.RESULTS.parents[1] / "docs")
    for row in rows:
        assert row["grid_over_design"] > 0.999, "the grid found a better design"


if __name__ == "__main__":
    main()
