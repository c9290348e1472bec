# %% [markdown]
# # Your own surface and lamp
#
# A surface is a height over its base, a lamp a list of wavelengths and powers. Neither needs a change of the package.

# %%
import equinox as eqx
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np

import newtonjax as nj


class Ripple(nj.AbstractFigure):
    """Waves of 4 mm that a polishing tool left."""

    radius: float
    height: float

    def sag(self, x, y):
        return self.height * jnp.cos(2 * jnp.pi * x / 4e-3)


# %% [markdown]
# The ripple goes onto the lens's convex face, which is the one before the gap.

# %%
plain = nj.newton_rings(radius=2.0, wavelength=546.1e-9, view="reflected", screen="gap")
ripple = Ripple(radius=8e-3, height=40e-9)
rippled = eqx.tree_at(lambda s: s.surfaces[1].figure, plain, ripple, is_leaf=lambda part: part is None)
camera = nj.Camera((128, 128), pixel_size=60e-6)
figure, panels = plt.subplots(1, 2)
for panel, scene in zip(panels, (plain, rippled), strict=True):
    panel.imshow(nj.render(scene, camera), cmap="gray")
figure

# %% [markdown]
# The path difference changes by twice the height of the ripple.

# %%
change = np.asarray(nj.opd(rippled, camera) - nj.opd(plain, camera))
print(f"{np.ptp(change) * 1e9:.1f} nm from crest to trough")
assert abs(np.ptp(change) - 4 * 40e-9) < 2e-9

# %% [markdown]
# A lamp of two bands, as a white LED has: a narrow blue one, and a broad yellow one. The rings are in the colours
# that an eye sees, and soon pale.

# %%
wavelengths = np.linspace(400e-9, 700e-9, 61)
powers = np.exp(-(((wavelengths - 455e-9) / 12e-9) ** 2)) + 0.6 * np.exp(-(((wavelengths - 560e-9) / 60e-9) ** 2))
led = nj.sampled_spectrum(wavelengths, powers)
coloured = nj.newton_rings(radius=2.0, light=led, view="reflected", screen="gap")
seen = np.asarray(nj.render(coloured, nj.Camera((128, 128), 40e-6, response=nj.cie_1931())))
plt.figure().add_subplot().imshow(nj.to_srgb(seen / seen[..., 1].max()))
plt.gcf()
