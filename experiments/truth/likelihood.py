"""Claim: a few hundred moments are the whole image's likelihood, at a fraction of its cost.

Part 1: the log-likelihood (but for a constant) from moments against the sum over all pixels, for 100 random sets of all
unknowns whose phase stays within a quarter turn of the reference; its cost against that sum in NumPy and jitted.
Part 2: `fitting.fit` with thirteen free parameters, warm, against scipy.optimize.least_squares with a numerical
Jacobian on the same pixels and parameters from a near-true start: ours from the same start, and ours with its own
search. 1024 x 1024 pixels; medians and ratios of one run.

    python -m experiments.truth.likelihood [--quick]
"""

import argparse
import json
import time

import jax
import jax.numpy as jnp
import numpy as np
from scipy.optimize import least_squares

import fitting
from experiments import records
from fitting.estimate import CONTRAST, contrast_at_nodes, frame_on, moments, sums
from fitting.estimate.fringe_moments import residuals
from fitting.model import GapModel, as_arrays, localize, model_coefficients
from fitting.photo import Photograph, reduce
from fitting.photo.codes import Codes, Curve

WAVELENGTH, PIXEL, RADIUS, NOISE = 589.3e-9, 5e-6, 1.0, 0.05


def design(size: int):
    """x, y [-1, 1] and the polynomials of a degree-2 background and a degree-1 contrast."""
    y, x = np.mgrid[:size, :size] * 2 / (size - 1) - 1.0
    return x, y, [x**0, x, y, x * x, x * y, y * y], [x**0, x, y]


def image_of(values, size, parts, xp=np):
    """The exact model at every pixel: turns, centre x, y [half sizes], phase, six background, three contrast terms."""
    x, y, background, contrast = parts
    half = (size - 1) / 2
    turns, x0, y0, phase = values[:4]
    r2 = ((x - x0) ** 2 + (y - y0) ** 2) * half**2
    k = turns / half**2
    c2 = (k * WAVELENGTH / PIXEL) ** 2
    argument = 2 * k * r2 / (1 + xp.sqrt(1 - c2 * r2)) + phase
    smooth = sum(v * t for v, t in zip(values[4:10], background, strict=True))
    size_ = sum(v * t for v, t in zip(values[10:], contrast, strict=True))
    return smooth + size_ * xp.cos(2 * xp.pi * argument)


def truth(size: int) -> np.ndarray:
    """Thirteen numbers: rings of 1 m, off centre, unevenly lit."""
    half = (size - 1) / 2
    turns = PIXEL**2 / (RADIUS * WAVELENGTH) * half**2
    return np.array([turns, 0.05, -0.03, 0.5, 0.5, 0.05, -0.04, -0.06, 0.03, -0.05, 0.4, 0.05, -0.06])


def median(function, repeats: int) -> float:
    """Median time of a call that blocks [s]."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        jax.block_until_ready(function())
        times.append(time.perf_counter() - began)
    return float(np.median(times))


def likelihood(size: int, repeats: int) -> dict:
    """Part 1."""
    rng = np.random.default_rng(1)
    parts, best = design(size), truth(size)
    image = image_of(best, size, parts) + NOISE * rng.normal(size=(size, size))
    mask = np.ones((size, size), bool)
    reduced = reduce(Photograph(Codes(image, Curve(1.0, 1.0)), mask, mask, "grey", "linear"), 1, np.float64)
    frame = frame_on(reduced.grid)
    half = (size - 1) / 2
    model = as_arrays(GapModel(frame, (WAVELENGTH / PIXEL, 1.0)))
    stretch = frame.unit / half  # the model counts in half diagonals, the exact one in half sides

    def free(values):
        return jnp.array([values[0] * stretch**2, values[1] / stretch, values[2] / stretch, values[3], *[0.0] * 5])

    kept = moments(*sums(reduced, np.asarray(localize(model, free(best)).value[0])))
    chebyshev_of = _to_chebyshev()

    @jax.jit
    def from_moments(numbers, background, contrast, kept):
        phase, shape = model(numbers)
        modulus = shape * (jnp.asarray(contrast_at_nodes()) @ contrast)
        left = residuals(kept, model_coefficients(background, modulus, phase, kept.reference))
        return -(left @ left + kept.rest) / (2 * NOISE**2)

    def arguments(values):
        background, contrast = chebyshev_of(values)
        return free(values), background.at[0].add(-reduced.offset), contrast, kept

    errors = []
    for _ in range(100):
        move = rng.normal(size=13)
        move[4:] *= 0.02
        phase = _phase(best, parts, half)
        move[:4] *= [0.05, 0.002, 0.002, 0.05]
        away = np.abs(_phase(best + move, parts, half) - phase).max()
        move[:4] *= min(1.0, rng.uniform(0.05, 0.25) / away)
        values = best + move
        full = -np.sum((image - image_of(values, size, parts)) ** 2) / (2 * NOISE**2)
        errors.append(abs(float(from_moments(*arguments(values))) - full))
    jitted = jax.jit(lambda v, d, *p: -jnp.sum((d - _jax_image(v, size, p)) ** 2) / (2 * NOISE**2))
    data, flat = jnp.asarray(image), [jnp.asarray(p) for p in (parts[0], parts[1])]
    ready = arguments(best)
    ours = median(lambda: from_moments(*ready), 50 * repeats)
    return {
        "largest_error": float(max(errors)),
        "numpy_over_moments": median(lambda: np.sum((image - image_of(best, size, parts)) ** 2), repeats) / ours,
        "jitted_over_moments": median(lambda: jitted(jnp.asarray(best), data, *flat), 3 * repeats) / ours,
        "moments_us": ours * 1e6,
        "basis": int(kept.target.shape[0]),
    }


def _phase(values, parts, half):
    return values[0] * ((parts[0] - values[1]) ** 2 + (parts[1] - values[2]) ** 2) + values[3] + 0 * half


def _jax_image(values, size, parts):
    x, y = parts
    return image_of(values, size, (x, y, [x**0, x, y, x * x, x * y, y * y], [x**0, x, y]), jnp)


def _to_chebyshev():
    """Coefficients by `degrees` for the polynomials of `design`: x² = (T2 + T0) / 2."""
    from fitting.model import BACKGROUND, degrees

    low = [tuple(d) for d in degrees(BACKGROUND)]
    high = [tuple(d) for d in degrees(CONTRAST)]

    def convert(values):
        one, x, y, xx, xy, yy = values[4:10]
        table = dict.fromkeys(low, 0.0)
        table |= {(0, 0): one + xx / 2 + yy / 2, (0, 1): x, (1, 0): y, (0, 2): xx / 2, (1, 1): xy, (2, 0): yy / 2}
        second = dict.fromkeys(high, 0.0) | dict(zip(((0, 0), (0, 1), (1, 0)), values[10:], strict=True))
        return jnp.array(list(table.values())), jnp.array(list(second.values()))

    return convert


def speed(size: int, repeats: int) -> dict:
    """Part 2."""
    parts, best = design(size), truth(size)
    image = image_of(best, size, parts) + NOISE * np.random.default_rng(2).normal(size=(size, size))
    half = (size - 1) / 2
    start = best * np.array([1.0005, 1.002, 1.002, 1.01] + [1.02] * 9)
    began = time.perf_counter()
    theirs = least_squares(lambda v: (image_of(v, size, parts) - image).ravel(), start)
    seconds = time.perf_counter() - began
    scale = start[0] / half**2
    given = {
        "fringe_scale_per_px2": scale,
        "centre_px": (half * (1 + start[1]), half * (1 + start[2])),
    }

    def ours(**more):
        return fitting.fit(image, wavelength=WAVELENGTH, pixel_size=PIXEL, **more)

    ours(), ours(start=given)  # compiles
    times = {}
    for name, more in (("same_start", {"start": given}), ("own_search", {})):
        times[name] = float(np.median([ours(**more).seconds for _ in range(repeats)]))
    result = ours()
    radius = PIXEL**2 / (theirs.x[0] / half**2 * WAVELENGTH)
    return {
        "scipy_s": seconds,
        "scipy_evaluations": int(theirs.nfev),
        "scipy_over_same_start": seconds / times["same_start"],
        "scipy_over_own_search": seconds / times["own_search"],
        **{f"{name}_s": value for name, value in times.items()},
        "difference_over_sd": float((result.radius - radius) / result.radius_sd),
        "illumination": result.model["illumination"],
    }


def main() -> None:
    """Run both parts and write the numbers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="512 pixels a side, nothing written")
    options = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    size, repeats = (512, 3) if options.quick else (1024, 9)
    found = {"size": size, "likelihood": likelihood(size, repeats), "fit": speed(size, repeats)}
    print(json.dumps(found, indent=1))
    assert found["likelihood"]["largest_error"] < 1e-3, "the moments are not the likelihood"
    if not options.quick:
        records.save("likelihood", found)


if __name__ == "__main__":
    main()
