"""The same image, loss and gradient on any number of devices and processes: run by `test_sharding.py`.

python tests/sharded.py DEVICES PROCESSES NUMBER PORT

Each process has DEVICES devices. The first one prints the answers of one device, of its own devices, and of those of
all processes.
"""

import json
import os
import sys
from functools import partial

devices, processes, number, port = map(int, sys.argv[1:])
os.environ |= {"XLA_FLAGS": f"--xla_force_host_platform_device_count={devices}", "JAX_PLATFORMS": "cpu"}

import jax  # noqa: E402 (the flags come first)
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
from compilations import QUICKLY  # noqa: E402
from jax.sharding import Mesh, NamedSharding, PartitionSpec  # noqa: E402

jax.config.update("jax_enable_x64", True)
jax.distributed.initialize(f"localhost:{port}", processes, number)

import newtonjax as nj  # noqa: E402

CAMERA = nj.Camera((64, 48), 60e-6)
RADII = np.array([1.0, 1.5, 2.0, 2.5])
METHODS = {"Chebyshev": nj.Chebyshev(9), "Traced": nj.Traced(chunk=256)}
# Weights of a sum: of an image on several processes, which see a part each, all see its sums.
WEIGHTS = np.cos(np.arange(CAMERA.shape[0] * CAMERA.shape[1], dtype=float)).reshape(CAMERA.shape)
compiled = partial(jax.jit, compiler_options=QUICKLY)


def image(radius, method):
    return nj.render(
        nj.newton_rings(radius, 550e-9, 1e-7, screen=5e-3, light_tilt=(1e-3, 0.0), view="transmitted"), CAMERA, method
    )


def loss(radius, method):
    """Of an image, and the image."""
    pixels = image(radius, method)
    return jnp.sum(pixels**2) / CAMERA.shape[0], pixels


# Jitted without shardings: traced once, and then a part of a program for each set of devices.
with_gradient = {
    name: jax.jit(jax.value_and_grad(partial(loss, method=method), has_aux=True)) for name, method in METHODS.items()
}
losses = jax.jit(jax.vmap(lambda radius: loss(radius, METHODS["Chebyshev"])[0]))


def answers(shared_by, methods):
    """Images shared out by rows, and a batch of losses shared out, over some devices."""
    mesh = Mesh(np.array(shared_by), ("rows",))
    rows, batch = NamedSharding(mesh, PartitionSpec("rows", None)), NamedSharding(mesh, PartitionSpec("rows"))
    everywhere = NamedSharding(mesh, PartitionSpec())
    at_hand = [device for device in shared_by if device.process_index == jax.process_index()]
    numbers = {}
    for name in methods:
        function = with_gradient[name]
        program = compiled(
            lambda radius, function=function: function(radius),
            in_shardings=everywhere,
            out_shardings=((everywhere, rows), everywhere),
        )
        (value, pixels), slope = program(2.0)
        assert len(pixels.addressable_shards) == len(at_hand)
        assert pixels.addressable_shards[0].data.shape == (CAMERA.shape[0] // len(shared_by), CAMERA.shape[1])
        numbers[name] = float(jax.jit(jnp.vdot, out_shardings=everywhere)(pixels, jax.device_put(WEIGHTS, rows)))
        numbers[f"{name} loss"], numbers[f"{name} gradient"] = float(value), float(slope)
    of_batch = compiled(lambda radii: losses(radii), in_shardings=batch, out_shardings=batch)(
        jax.device_put(RADII, batch)
    )
    assert len(of_batch.addressable_shards) == len(at_hand)
    numbers["batch"] = float(jax.jit(jnp.sum, out_shardings=everywhere)(of_batch))
    return numbers


assert len(jax.devices()) == devices * processes
# Only the first process keeps compiled code, so the long program is that of one process alone.
results = {"all processes": answers(jax.devices(), ["Chebyshev"])}
if number == 0:
    local = jax.local_devices()
    results |= {"one process": answers(local, METHODS), "one device": answers(local[:1], METHODS)}
    print(json.dumps(results))
