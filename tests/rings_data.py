"""Rendered rings for tests of the fit: the exact closed form in NumPy, none of the project's own code."""

import numpy as np

WAVELENGTH = 589.3e-9


def coordinates(shape, centre):
    """Squared distance from a centre (x, y) in pixels."""
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    return (x - centre[0]) ** 2 + (y - centre[1]) ** 2


def rings(
    radius=0.3,
    pixel_size=5e-6,
    shape=(256, 256),
    centre=(130.0, 120.0),
    gap=0.0,
    noise=0.0,
    seed=0,
    dark=True,
    index=1.0,
):
    """Fringes 0.5 ∓ 0.5 cos(4π n t / λ) of the exact sphere; dark in contact for reflected light."""
    r2 = coordinates(shape, centre) * pixel_size**2
    thickness = gap + r2 / radius / (1 + np.sqrt(1 - r2 / radius**2))
    image = 0.5 + (-0.5 if dark else 0.5) * np.cos(4 * np.pi * index * thickness / WAVELENGTH)
    return image + noise * np.random.default_rng(seed).normal(size=shape)


def bound(noise, radius, pixel_size, shape, centre):
    """Cramér–Rao bound of the radius [m] with six unknowns, by central differences over all pixels."""
    truth = np.array([radius, *centre, 0.0, 0.5, 0.5])
    steps = np.array([radius * 1e-6, 1e-3, 1e-3, 1e-11, 1e-3, 1e-3])

    def image(values):
        r, x, y, gap, background, contrast = values
        unit = rings(r, pixel_size, shape, (x, y), gap)
        return (background + contrast * (unit - 0.5) / 0.5).ravel()

    columns = [(image(truth + move) - image(truth - move)) / (2 * move.sum()) for move in np.diag(steps)]
    jacobian = np.stack(columns, axis=1)
    scale = np.linalg.norm(jacobian, axis=0)
    covariance = np.linalg.inv((jacobian / scale).T @ (jacobian / scale))
    return noise * np.sqrt(covariance[0, 0]) / scale[0]
