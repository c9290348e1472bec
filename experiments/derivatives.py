"""Claim: the gradient of a sum over an image costs five to seven images, Gauss and Newton's matrix eight to fourteen.

The misfit of a 1024 x 1024 image of the default bench in twelve parameters (radius, wavelength, gap, screen, indices,
thicknesses, tilts of lens and light): value, gradient by `jax.value_and_grad`, and `nj.normal_equations`, beside
one image of the same function, in turns in one process. The dense Jacobian's product is there for comparison.

    python experiments/derivatives.py [--quick]
"""

import jax
import jax.numpy as jnp
import numpy as np
import records

import newtonjax as nj

POINT = np.array([2.0, 500e-9, 0.0, 1e-3, 1.5, 1.5, 5e-3, 5e-3, 1e-4, 0.0, 1e-4, 0.0])
LIMITS = {"gradient": 7.0, "normal equations": 15.0}


def bench(p):
    names = ("radius", "wavelength", "gap", "screen", "index", "plate_index", "lens_thickness", "plate_thickness")
    return nj.newton_rings(**dict(zip(names, p[:8], strict=True)), lens_tilt=(p[8], p[9]), light_tilt=(p[10], p[11]))


def ratios(nodes: int, camera: nj.Camera, rounds: int) -> dict[str, float]:
    """Median time of each over the image's."""
    method, point = nj.Chebyshev(nodes), jnp.asarray(POINT)
    image = jax.jit(lambda p: nj.render(bench(p), camera, method))
    data = 1.01 * image(point)

    def misfit(p, data):
        return jnp.sum((nj.render(bench(p), camera, method) - data) ** 2)

    value, gradient = jax.jit(misfit), jax.jit(jax.value_and_grad(misfit))
    equations = jax.jit(lambda p, d: nj.normal_equations(bench, p, camera, d, None, method))
    found = equations(point, data)
    np.testing.assert_allclose(2 * found.gradient, gradient(point, data)[1], rtol=1e-6, atol=1e-6 * float(found.misfit))
    runs = {
        "image": lambda: image(point),
        "misfit": lambda: value(point, data),
        "gradient": lambda: gradient(point, data),
        "normal equations": lambda: equations(point, data),
    }
    seconds = records.medians(runs, rounds)
    return {name: value / seconds["image"] for name, value in seconds.items() if name != "image"}


def main(quick: bool) -> None:
    size, rounds, grids = (256, 3, (5,)) if quick else (1024, 31, (5, 9, 17))
    camera = nj.Camera((size, size), 5e-6 * 1024 / size)
    table = [{"nodes": nodes, **ratios(nodes, camera, rounds)} for nodes in grids]
    for row in table:
        print(row)
        for name, limit in LIMITS.items():
            assert quick or row[name] <= limit, (name, row)
    if not quick:
        records.save("derivatives", table)


if __name__ == "__main__":
    main(records.arguments(__doc__, "256 x 256 pixels, one grid, no limits, nothing written").quick)
