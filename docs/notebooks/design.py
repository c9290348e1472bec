# %% [markdown]
# # A set-up designed by gradient
#
# How large should a pixel be at the lens? Small pixels see few rings; with large ones the blur of the camera takes
# the contrast of the fine rings. An image is differentiable in every number of scene and camera, so that the expected
# standard deviation is, too, and a minimizer finds the best pixel. The loss is written here: any other one works
# alike.

# %%
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from scipy.optimize import minimize

import fitting
import newtonjax as nj

jax.config.update("jax_enable_x64", True)
scene = nj.newton_rings(radius=1.0, wavelength=589.3e-9, view="reflected", screen="gap")
camera = nj.Camera((64, 64), pixel_size=30e-6)
rows, columns = np.indices(camera.shape) - 31.5

# %% [markdown]
# The image of a radius, a gap, a brightness and a contrast. The camera blurs by a Gaussian of one pixel, which leaves
# fringes of f turns a pixel exp(-2 (pi f)²) of their contrast. Of the image the Fisher information under shot noise,
# and of that the standard deviation of the radius while the other three numbers are not known.


# %%
def image(numbers, pixel_size):
    radius, gap, brightness, contrast = numbers
    bench = nj.newton_rings(radius=radius, wavelength=589.3e-9, gap=gap, view="reflected", screen="gap")
    sharp = nj.render(bench, eqx.tree_at(lambda c: c.pixel_size, camera, pixel_size), method=nj.ClosedForm())
    turns_a_pixel = 2 * jnp.hypot(rows, columns) * pixel_size**2 / (radius * 589.3e-9)
    middle = sharp.mean()
    return brightness * (middle + contrast * jnp.exp(-2 * (jnp.pi * turns_a_pixel) ** 2) * (sharp - middle))


def loss(log_pixel):
    numbers, pixel_size = jnp.array([1.0, 50e-9, 1.0, 1.0]), jnp.exp(log_pixel)
    slopes = jax.jacfwd(image)(numbers, pixel_size).reshape(-1, 4) * jnp.array([1.0, 1e-7, 1.0, 1.0])
    variance = image(numbers, pixel_size).reshape(-1, 1) / camera.exposure + 1e-6
    information = slopes.T @ (slopes / variance)
    return 0.5 * jnp.log(jnp.linalg.inv(information)[0, 0])  # log of the relative standard deviation


value_and_slope = jax.jit(jax.value_and_grad(loss))
start, step = np.log(30e-6), 1e-4
_, slope = value_and_slope(start)
central = (value_and_slope(start + step)[0] - value_and_slope(start - step)[0]) / (2 * step)
print(f"slope {slope:.6f}, by central differences {central:.6f}")
assert abs(slope - central) < 1e-5 * abs(central)

# %% [markdown]
# A minimizer of SciPy goes down; those of optimistix and optax take the same loss. One compiled program gives the loss
# and its slope, and serves every step.

# %%
found = minimize(lambda place: value_and_slope(place[0]), start, jac=True, method="BFGS", tol=1e-4).x[0]
best = float(np.exp(found))
for name, pixel in (("at the start", 30e-6), ("designed", best)):
    sd = np.exp(value_and_slope(np.log(pixel))[0])
    print(f"{name:12} {pixel * 1e6:6.2f} um, relative standard deviation {sd:.2e}")
least, lower, higher = (float(value_and_slope(found + aside)[0]) for aside in (0.0, -0.1, 0.1))
assert least < min(lower, higher)

# %% [markdown]
# `design` has a loss of its own, limits, and several starts. It knows no blur, and keeps the finest fringe above 2.5
# pixels.

# %%
designed = fitting.design(scene, camera, {"pixel_size": (5e-6, 100e-6)}, starts=2)
print(designed)

# %%
designed.figure()
