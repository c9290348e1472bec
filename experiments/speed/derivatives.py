"""Claim: the gradient of a sum over an image costs at most five images, Gauss and Newton's matrix eight.

The misfit of a 1024 x 1024 image of the default bench in twelve parameters (radius, wavelength, gap, screen, indices,
thicknesses, tilts of lens and light): value, gradient by `jax.value_and_grad`, and normal equations, without weights
and with, beside one image of the same function, in turns in one process; medians of CPU time, over all threads, and of
wall time. The rays' own derivatives at the nodes are left out: they are the same for every size of image.

What a gradient is made of is measured in the same turns, and given in compiled copies of the image too: the misfit; the
misfit with its cotangent, which JAX hands to the image's rule as a whole image; and the sums over the pixels of a
cotangent. Of its `parts`, misfit and sums, only the sums are this library's own beyond the image.

    python -m experiments.speed.derivatives [--quick]
"""

import json

import jax
import jax.numpy as jnp
import numpy as np

import newtonjax as nj
from experiments import records
from newtonjax.fields import synthesize
from newtonjax.verbs.normal import from_coefficients

LIMITS = {"gradient": 5.0, "normal equations": 8.0, "normal equations with weights": 10.5}
PARAMETERS = 12
# What a gradient is made of, by the names of `ratios`.
PIECES = ("image", "misfit", "misfit and cotangent", "sums", "parts")


def bench() -> nj.Scene:
    return nj.newton_rings(
        2.0, 500e-9, 0.0, screen=1e-3, lens_tilt=(1e-4, 0.0), light_tilt=(1e-4, 0.0), view="transmitted"
    )


def ratios(nodes: int, camera: nj.Camera, rounds: int) -> dict[str, float]:
    """Median CPU and wall time of each over the image's, and CPU time of a gradient and its pieces over a copy's."""
    at = jnp.asarray(nj.Chebyshev(nodes).picture(bench(), camera).coefficients)
    rng = np.random.default_rng(0)
    decay = np.exp(-np.add.outer(np.arange(nodes), np.arange(nodes)))
    moves = jnp.asarray(1e-3 * rng.normal(size=(PARAMETERS, *at.shape)) * decay)
    point = jnp.zeros(PARAMETERS)
    weights = jnp.asarray(rng.uniform(0.5, 2.0, camera.shape))

    def fields(p):
        return at + jnp.einsum("p,pfkl->fkl", p, moves)

    image = jax.jit(lambda p: synthesize(fields(p), camera.shape))
    data = 1.01 * image(point)

    def misfit(p, data):
        return jnp.sum((synthesize(fields(p), camera.shape) - data) ** 2)

    def with_cotangent(p, data):
        residual = synthesize(fields(p), camera.shape) - data
        return jnp.sum(residual**2), 2 * residual

    def sums(p, cotangent):
        return jax.vjp(lambda p: synthesize(fields(p), camera.shape), p)[1](cotangent)

    value, gradient = jax.jit(misfit), jax.jit(jax.value_and_grad(misfit))
    copied, compared, summed = jax.jit(jnp.copy), jax.jit(with_cotangent), jax.jit(sums)
    cotangent = compared(point, data)[1]
    equations = jax.jit(lambda p, data, weights: from_coefficients(fields, p, camera.shape, data, weights))
    solved = equations(point, data, None)
    size = float(jnp.abs(solved.gradient).max())
    np.testing.assert_allclose(2 * solved.gradient, gradient(point, data)[1], rtol=1e-9, atol=1e-9 * size)
    runs = {
        "copy": lambda: copied(data),
        "image": lambda: image(point),
        "misfit": lambda: value(point, data),
        "misfit and cotangent": lambda: compared(point, data),
        "sums": lambda: summed(point, cotangent),
        "gradient": lambda: gradient(point, data),
        "normal equations": lambda: equations(point, data, None),
        "normal equations with weights": lambda: equations(point, data, weights),
    }
    cpu, wall = records.cpu_and_wall(runs, rounds)
    for seconds in (cpu, wall):
        seconds["parts"] = seconds["misfit"] + seconds["sums"]
    in_copies = {f"{name}, in copies": cpu[name] / cpu["copy"] for name in (*PIECES, "gradient")}
    in_images = {name: cpu[name] / cpu["image"] for name in cpu}
    return in_images | in_copies | {f"{name}, wall": wall[name] / wall["image"] for name in wall}


def main(quick: bool) -> None:
    size, rounds, grids = (256, 3, (5,)) if quick else (1024, 31, (5, 9, 17))
    camera = nj.Camera((size, size), 5e-6 * 1024 / size)
    table = [{"nodes": nodes, **ratios(nodes, camera, rounds)} for nodes in grids]
    for row in table:
        print(json.dumps({name: round(value, 2) for name, value in row.items()}, indent=1))
    if not quick:
        records.save("derivatives", table)
    for row in table:
        for name, limit in LIMITS.items():
            assert quick or row[name] <= limit, (name, row)


if __name__ == "__main__":
    main(records.arguments(__doc__, "256 x 256 pixels, one grid, no limits, nothing written").quick)
