"""Claim: an image takes the time of a few copies of its array on the device where it is made, a card or a processor.

One short run on whatever JAX's default device is (under ten minutes on a card; --quick: a few seconds on a CPU). Rays
are traced on the host and only coefficients go to the device. Images of 2048², 4096² and 8192² pixels, planned, against
a copy of an array of their size on the same device: bytes written a second, and the ratio. Then a fit of the sample
photograph and frames of a stack, with a card against the same on the CPU alone, and the test modules that matter.

    python -m experiments.speed.gpu [--quick] [--no-tests]
"""

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

import fitting
import newtonjax as nj
from experiments import records

ROOT = Path(__file__).resolve().parents[2]
TESTS = ("test_rendering", "test_methods", "test_gradients", "test_sharding", "test_single", "test_stack")
# An image on a device may cost so many copies of its array there; sums of cosines are bound by arithmetic on a CPU.
COPIES, QUICK_COPIES = {"cpu": 8.0, "gpu": 2.5}, 20.0


def best(function, turns: int) -> float:
    """Least wall seconds of a call, its arrays computed, after a first call."""
    jax.block_until_ready(function())
    times = []
    for _ in range(turns):
        begin = time.perf_counter()
        jax.block_until_ready(function())
        times.append(time.perf_counter() - begin)
    return min(times)


def images(sizes: tuple[int, ...], turns: int) -> list[dict]:
    """Planned images of some sizes against a copy on the device."""
    scene, rows = nj.newton_rings(1.0, 589.3e-9, gap=1e-6, view="reflected", screen=1e-3), []
    copied = jax.jit(lambda x: x + 1.0)
    for size in sizes:
        camera = nj.Camera((size, size), 5e-3 / size)
        plan = nj.plan(scene, camera)
        image = best(lambda plan=plan, camera=camera: nj.render(plan.scene, camera, plan.method), turns)
        array = jnp.zeros((size, size))
        copy = best(lambda array=array: copied(array), turns)
        size_gb = array.nbytes / 1e9
        row = {"pixels": size, "nodes": getattr(plan.method, "nodes", None), "image_s": image, "copy_s": copy}
        rows.append(row | {"ratio": image / copy, "written_gb_s": size_gb / image, "copied_gb_s": 2 * size_gb / copy})
        print(f"{size:5d}²  {image * 1e3:8.2f} ms  {size_gb / image:7.1f} GB/s written  {image / copy:5.2f} copies")
    return rows


def measured(count: int) -> dict:
    """Seconds of a fit of the sample, and of frames of a stack, on the default device and the host."""
    sample = ROOT / "fitting" / "data" / "sample.png"
    given = {"wavelength": 589.294e-9, "pixel_size": 8e-6, "view": "reflected"}
    y, x = np.mgrid[:256, :256] - 128.0
    light = 110 - 70 * np.cos((x * x + y * y) * 1e-3 + np.linspace(0, 9, count)[:, None, None])
    frames = np.rint(light + np.random.default_rng(0).normal(0, 3, light.shape)).astype(np.uint8)
    radius = fitting.fit(sample, **given).radius
    found = {"fit_s": best(lambda: fitting.fit(sample, **given).radius, 2), "radius_m": radius}
    stack = best(lambda: [row.radius for row in fitting.fit_stack(frames, **given)], 1)
    found["stack_frames_s"] = count / stack
    print(f"fit of the sample {found['fit_s']:.2f} s, stack {found['stack_frames_s']:.0f} frames a second")
    return found


def on_the_host() -> dict:
    """The same measured by a process that has the CPU alone."""
    program = "import json; from experiments.speed import gpu; print(json.dumps(gpu.measured(100)))"
    environment = os.environ | {"JAX_PLATFORMS": "cpu", "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment)
    return json.loads(done.stdout.splitlines()[-1])


def tests() -> str:
    """The last line of the test modules that matter on a device."""
    files = [str(next((ROOT / "tests").glob(f"*/{name}.py"))) for name in TESTS]
    command = [sys.executable, "-m", "pytest", "-q", "-n0", *files]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT, timeout=420)
    print(done.stdout[-400:])
    return done.stdout.strip().splitlines()[-1]


def main() -> None:
    """Measure, and save where the whole of it was measured."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one image of 1024², saved nowhere")
    parser.add_argument("--no-tests", action="store_true", help="without the test modules")
    options = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    device = jax.devices()[0]
    print(f"{device.platform}: {device.device_kind}, JAX {jax.__version__}")
    found: dict = {"device": device.device_kind, "platform": device.platform, "jax": jax.__version__}
    found["images"] = images((1024,) if options.quick else (2048, 4096, 8192), 30 if options.quick else 10)
    if options.quick:
        assert found["images"][0]["ratio"] < QUICK_COPIES
        return
    assert found["images"][-1]["ratio"] < COPIES.get(device.platform, COPIES["gpu"])
    found["measured"] = measured(100)
    if device.platform != "cpu":
        found["host"] = on_the_host()
    if not options.no_tests:
        found["tests"] = tests()
    records.save("gpu" if device.platform != "cpu" else "gpu_on_cpu", found)


if __name__ == "__main__":
    main()
