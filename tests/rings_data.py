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
    microscope=True,
):
    """Fringes 0.5 ∓ 0.5 cos 2πδ/λ of the exact sphere; dark in contact for reflected light.

    The path difference δ is 2 n t, and what a microscope adds (`added_path`) unless it is not to.
    """
    r2 = coordinates(shape, centre) * pixel_size**2
    height = gap + r2 / radius / (1 + np.sqrt(1 - r2 / radius**2))
    path = 2 * index * height
    if microscope:
        path = path + added_path(r2 / radius**2, height, gap, "reflected" if dark else "transmitted", index)
    image = 0.5 + (-0.5 if dark else 0.5) * np.cos(2 * np.pi * path / WAVELENGTH)
    return image + noise * np.random.default_rng(seed).normal(size=shape)


def added_path(steepness, height, apex, view, index=1.0, glass=1.5, thickness=5e-3):
    """What a microscope that looks at the gap adds to 2 n t [m], to the fourth order of the slope.

    `steepness`: (r/R)²; `height`, `apex`: of the gap at the point and at the apex [m]; `glass`: index of lens and
    plate; `thickness`: of either [m]. Derived in `fitting.model.microscope`, of which this is no copy: it traces rays.
    """
    step = glass - index
    aberration = thickness * (glass**3 - glass) / 8 * steepness**2
    if view == "reflected":
        apart = 2 * index * (2 * glass - index) / glass * (height + apex * step / index)
        return -steepness * (height * step**2 / index + apart) + aberration * ((2 * step / glass) ** 4 - 16)
    slopes = ((2 * index - step) / glass) ** 4 - (step / glass) ** 4
    return steepness * height * (2 * step - step**2 / index - 2 * index) + aberration * slopes


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
