# %% [markdown]
# # What the data say
#
# A photograph determines some numbers well, some together, and some not at all. Three views of that: the budget of
# the fit, a chain of draws from the posterior (emcee), and its corner plot. The photograph is made, with a gap that
# is not known.

# %%
import corner
import jax
import numpy as np

import fitting
import newtonjax as nj

bench = nj.newton_rings(radius=0.5, wavelength=589.3e-9, gap=80e-9, view="reflected", screen="gap")
camera = nj.Camera((120, 160), pixel_size=20e-6, exposure=2000.0)
photo = camera.expose(nj.render(bench, camera), jax.random.key(2))
known = {"wavelength": 589.3e-9, "pixel_size": 20e-6, "pixel_size_sd": "0.2%", "view": "reflected"}
result = fitting.fit(photo, transfer="linear", **known)
print(f"R = {result.radius:.4f} m +- {result.radius_sd:.4f} m")

# %% [markdown]
# The budget: by which uncertainty the radius would be off alone. The pixel size dominates, noise is the least.

# %%
for source, sd in result.budget:
    print(f"{source:20} {sd / result.radius:.1e}")

# %% [markdown]
# What the photograph would tell: the bounds of Cramér and Rao, with the pixel size known as above, and with all other
# numbers known.

# %%
print(fitting.information(bench, camera, free=("radius", "gap", "pixel_size"), sd={"pixel_size": "0.2%"}))

# %% [markdown]
# A chain draws all numbers together. Radius and pixel size lie on a line: the image knows the square of the pixel
# size over the radius.

# %%
chain = fitting.sample(result, steps=120, seed=1)
print(chain)

# %%
draws = {name: chain.draws()[name].ravel() for name in ("radius", "pixel_size", "gap_turns")}
corner.corner(np.stack(list(draws.values()), 1), labels=list(draws), plot_contours=False, bins=30)

# %% [markdown]
# The chain and the fit agree on the radius and on its standard deviation.

# %%
mean, sd = draws["radius"].mean(), draws["radius"].std()
print(f"chain {mean:.4f} m +- {sd:.4f} m, fit {result.radius:.4f} m +- {result.radius_sd:.4f} m")
assert abs(mean - result.radius) < result.radius_sd
