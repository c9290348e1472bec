"""Claim: time and memory grow with what an image is made of, and no faster: the exponent of each.

Medians of compiled calls that take turns, and the bytes that the compiler reserves (output and temporary), against the
pixels, the nodes, the beams, the number of scenes in a sweep, the number of parameters of the normal equations, and the
devices (of the CPU, one thread each, in a process for each number; scenes are shared out). The exponent is the slope of
the logarithms' line over the upper half of the range, where what a call costs by itself has faded.

    python -m experiments.speed.scaling [--quick]
"""

import json
import os
import subprocess
import sys
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

import newtonjax as nj
from experiments import records

SCENE = nj.newton_rings(2.0, 500e-9, 1e-6, view="transmitted", screen=1e-3)
FIELD = 5e-3
BEAMS = (2, 3, 4, 6, 8)
NAMES = ("radius", "wavelength", "gap", "screen", "lens_index", "plate_index", "lens_thickness", "plate_thickness")
POINT = (2.0, 500e-9, 1e-6, 1e-3, 1.5, 1.5, 5e-3, 5e-3)
# What an exponent may not be over: pixels and scenes count singly, pairs of beams and rays at nodes by their squares.
LIMITS = {"pixels": 1.15, "nodes": 1.8, "beams": 2.2, "scenes": 1.15, "parameters": 0.7}


def square(size: int) -> nj.Camera:
    return nj.Camera((size, size), FIELD / size)


@partial(jax.jit, static_argnames="method")
def image(scene, camera, method):
    return method.image(scene, camera)


def of_image(scene, camera, method):
    return (lambda: image(scene, camera, method)), image.lower(scene, camera, method)


def bench(numbers):
    given = dict(zip(NAMES, numbers, strict=False))
    return nj.newton_rings(view="transmitted", **{**dict(zip(NAMES, POINT, strict=True)), **given})


def _by_radius(radius):
    return nj.newton_rings(radius, 500e-9, 1e-6, view="transmitted", screen=1e-3)


def of_sweep(count: int, size: int):
    radii, camera, method = jnp.linspace(1.0, 2.0, count), square(size), nj.Chebyshev(5)
    mean = jax.jit(lambda r: jax.lax.map(lambda one: method.image(_by_radius(one), camera).mean(), r, batch_size=8))
    return (lambda: mean(radii)), mean.lower(radii)


def of_equations(count: int, size: int):
    point, camera = jnp.asarray(POINT[:count]), square(size)
    made = jax.jit(lambda p, data: nj.normal_equations(bench, p, camera, data, None, nj.Chebyshev(9)))
    data = jnp.zeros((size, size))
    return (lambda: made(point, data)), made.lower(point, data)


def axes(quick: bool) -> dict:
    """By axis and way: the values, and what makes (a call, its lowered form) of one."""
    size = 128 if quick else 1024
    beams = {n: nj.choose_beams(nj.newton_rings(2.0, 500e-9, 1e-6, "reflected", screen=1e-3), number=n) for n in BEAMS}
    found = {
        ("pixels", "Chebyshev(9)"): (
            (128, 256, 512) if quick else (256, 512, 1024, 2048, 4096),
            lambda n: of_image(SCENE, square(n), nj.Chebyshev(9)),
        ),
        ("nodes", f"{size} x {size} pixels"): (
            (5, 9) if quick else (5, 9, 17, 33, 65),
            lambda n: of_image(SCENE, square(size), nj.Chebyshev(n)),
        ),
    }
    if quick:
        return found
    return found | {
        ("pixels", "Chebyshev(9), float32"): (
            (256, 512, 1024, 2048, 4096),
            lambda n: of_image(SCENE, square(n), nj.Chebyshev(9, "float32")),
        ),
        ("pixels", "Traced"): ((32, 64, 128, 256), lambda n: of_image(SCENE, square(n), nj.Traced())),
        ("beams", "Chebyshev(9)"): (BEAMS, lambda n: of_image(beams[n], square(size), nj.Chebyshev(9))),
        ("beams", "Traced"): (BEAMS, lambda n: of_image(beams[n], square(96), nj.Traced())),
        ("scenes", "a sweep of 256 x 256"): ((8, 16, 32, 64, 128), lambda n: of_sweep(n, 256)),
        ("parameters", "normal equations"): ((1, 2, 4, 8), lambda n: of_equations(n, size)),
    }


def measure(values, make, rounds: int, square_it: bool) -> dict:
    """Seconds and bytes at each value, and their exponents."""
    made = {value: make(value) for value in values}
    seconds = records.medians({value: call for value, (call, _) in made.items()}, rounds)
    size = {}
    for value, (_, lowered) in made.items():
        analysis = lowered.compile().memory_analysis()
        size[value] = int(analysis.output_size_in_bytes + analysis.temp_size_in_bytes)
    counts = np.array([value**2 if square_it else value for value in values], float)
    upper = slice(len(values) // 2 - (len(values) == 2), None)
    time_slope, memory_slope = (
        float(np.polyfit(np.log(counts[upper]), np.log([table[value] for value in values][upper]), 1)[0])
        for table in (seconds, size)
    )
    return {
        "values": counts.astype(int).tolist(),
        "seconds": [seconds[value] for value in values],
        "bytes": [size[value] for value in values],
        "time_exponent": time_slope,
        "memory_exponent": memory_slope,
    }


def over_devices(count: int) -> float:
    """Median seconds of eight images of rays at every pixel, shared out over so many devices of the CPU."""
    flags = f"--xla_force_host_platform_device_count={count} --xla_cpu_multi_thread_eigen=false"
    environment = {**os.environ, "XLA_FLAGS": flags, "JAX_PLATFORMS": "cpu", "NPROC": str(count)}
    said = subprocess.run(
        [sys.executable, "-m", "experiments.speed.scaling", "--child"],
        cwd=Path(__file__).parents[2],
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    )
    return json.loads(said.stdout.splitlines()[-1])


def child() -> None:
    from jax.sharding import Mesh, NamedSharding, PartitionSpec

    jax.config.update("jax_enable_x64", True)
    mesh = Mesh(np.array(jax.devices()), ("scenes",))
    shared = NamedSharding(mesh, PartitionSpec("scenes"))
    camera, method = square(96), nj.Traced()
    radii = jax.device_put(np.linspace(1.0, 2.0, 8), shared)
    made = jax.jit(jax.vmap(lambda r: method.image(_by_radius(r), camera)), in_shardings=shared, out_shardings=shared)
    print(json.dumps(records.medians({"image": lambda: made(radii)}, 7)["image"]))


def main(quick: bool) -> None:
    table = []
    for (axis, way), (values, make) in axes(quick).items():
        row = {"axis": axis, "way": way, **measure(values, make, 3 if quick else 9, axis == "pixels")}
        table.append(row)
        print(f"{axis:<11} {way:<24} time ~ n^{row['time_exponent']:.2f}, memory ~ n^{row['memory_exponent']:.2f}")
        assert quick or row["time_exponent"] <= LIMITS[axis], row
    if quick:
        return
    one, two = over_devices(1), over_devices(2)
    print(f"devices     8 scenes of 96 x 96 rays: 1 takes {one / two:.2f} times as long as 2")
    table.append({"axis": "devices", "way": "Traced, 8 scenes", "values": [1, 2], "seconds": [one, two]})
    records.save("scaling", table)


if __name__ == "__main__":
    if sys.argv[1:] == ["--child"]:
        child()
    else:
        main(records.arguments(__doc__, "two axes, small images, no limits, nothing written").quick)
