"""The same image, loss and gradient on any number of devices and processes: run by `test_sharding.py`.

python tests/sharded.py DEVICES [PROCESSES NUMBER PORT]
"""

import json
import os
import sys
from functools import partial

devices, processes, number, port = (int(text) for text in (*sys.argv[1:], 1, 0, 0)[:4])
os.environ |= {"XLA_FLAGS": f"--xla_force_host_platform_device_count={devices}", "JAX_PLATFORMS": "cpu"}

import jax  # noqa: E402 (the flags come first)
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
from compilations import QUICKLY  # noqa: E402
from jax.sharding import Mesh, NamedSharding, PartitionSpec  # noqa: E402

jax.config.update("jax_enable_x64", True)
if processes > 1:
    jax.distributed.initialize(f"localhost:{port}", processes, number)

import newtonjax as nj  # noqa: E402

CAMERA = nj.Camera((64, 48), 60e-6)
RADII = np.array([1.0, 1.5, 2.0, 2.5])


def image(radius, method):
    return nj.render(
        nj.newton_rings(radius, 550e-9, 1e-7, screen=5e-3, light_tilt=(1e-3, 0.0), view="transmitted"), CAMERA, method
    )


def loss(radius, method):
    return jnp.sum(image(radius, method) ** 2) / CAMERA.shape[0]


mesh = Mesh(np.array(jax.devices()), ("rows",))
rows, batch = NamedSharding(mesh, PartitionSpec("rows", None)), NamedSharding(mesh, PartitionSpec("rows"))
alone = NamedSharding(mesh, PartitionSpec())
assert len(jax.devices()) == devices * processes
compiled = partial(jax.jit, compiler_options=QUICKLY)


def over_rows(method):
    """The loss of an image shared out by rows, and the image."""

    def sharded(radius):
        made = jax.lax.with_sharding_constraint(image(radius, method), rows)
        return jnp.sum(made**2) / CAMERA.shape[0], made

    return sharded


found = {}
for method in (nj.Chebyshev(9), nj.Traced(chunk=256)):
    name = type(method).__name__
    outputs = ((alone, rows), alone)
    (value, made), slope = compiled(jax.value_and_grad(over_rows(method), has_aux=True), out_shardings=outputs)(2.0)
    assert len(made.addressable_shards) == devices
    assert made.addressable_shards[0].data.shape == (CAMERA.shape[0] // (devices * processes), CAMERA.shape[1])
    # Every process looks at the whole only through sums, which all of them have.
    weights = jnp.cos(jnp.arange(CAMERA.shape[0] * CAMERA.shape[1], dtype=float)).reshape(CAMERA.shape)
    found[name] = float(jax.jit(jnp.vdot, out_shardings=alone)(made, weights))
    found[f"{name} loss"], found[f"{name} gradient"] = float(value), float(slope)
losses = compiled(jax.vmap(lambda r: loss(r, nj.Chebyshev(9))), in_shardings=batch, out_shardings=batch)(
    jax.device_put(RADII, batch)
)
found["batch"] = float(jax.jit(jnp.sum, out_shardings=alone)(losses))
if number == 0:
    print(json.dumps(found))
