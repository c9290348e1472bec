# %% [markdown]
# # A photograph to a radius
#
# The photograph is made here, so that the true radius is known: a lens of 0.85 m under a sodium lamp, as a camera
# with shot noise and 8 bits sees it. With one of your own the first cell goes away, and `photo` is its path.

# %%
import jax
import matplotlib.pyplot as plt

import fitting
import newtonjax as nj

bench = nj.newton_rings(radius=0.85, wavelength=589.3e-9, view="reflected", screen="gap")
camera = nj.Camera((240, 320), pixel_size=20e-6, bits=8)
photo = camera.expose(nj.render(bench, camera), jax.random.key(1))
plt.imshow(photo, cmap="gray").figure

# %% [markdown]
# Two numbers must be known besides: the wavelength, and the size of a pixel at the lens with its standard deviation.

# %%
known = {"wavelength": 589.3e-9, "pixel_size": 20e-6, "pixel_size_sd": 0.02e-6, "view": "reflected"}
result = fitting.fit(photo, transfer="linear", **known)
print(result)

# %% [markdown]
# The rings of the fit over the photograph, what the fit leaves, the rings unwrapped, and their profile. In a good fit
# the lines are straight and the second panel is grey noise.

# %%
result.figure()

# %% [markdown]
# What the standard deviation is made of. One percent of the pixel size is two of the radius, whatever the camera.

# %%
for source, sd in result.budget:
    print(f"{source:20} {sd * 1e3:.3f} mm")
apart = (result.radius - 0.85) / result.radius_sd
print(f"{apart:+.1f} standard deviations from the true radius")
assert abs(apart) < 4
