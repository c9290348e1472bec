"""Rings under a microscope with what real photographs add, in NumPy: truth for experiments on the error bar."""

from dataclasses import dataclass, replace
from io import BytesIO

import numpy as np

from experiments.truth.drawn_parts import DrawnParts, draw_parts, form_turns, squared_distance, view_of
from experiments.truth.microscope_view import added_path

WAVELENGTH = 589.3e-9
# Finest fringe at the far corner [cycles per pixel].
_FINEST = 0.35
# Parts from the priors that an answer is averaged over.
DRAWN = "drawn from the priors"
DEFECTS = (
    "none",
    "distortion 2 %",
    "tilt 8 deg",
    "gamma 2.2",
    "vignette 20 %",
    "dust and crosshair",
    "JPEG 50",
    "contact 0.3 mm",
    "doublet",
    "second rings",
    "scale 1 %",
    DRAWN,
)


@dataclass(frozen=True)
class Case:
    """One photograph's truth: SI units, the centre in pixels, noise as a share of the fringes' full swing.

    `parts`: those that are drawn from their priors.
    """

    defect: str
    radius: float
    pixel_size: float
    size: int
    centre: tuple[float, float]
    gap: float
    noise: float
    seed: int
    rings: float
    parts: DrawnParts | None = None


def draw_case(defect: str, seed: int, largest: int = 2200) -> Case:
    """Radius 5 mm to 50 m, 3 to 300 rings in view, noise 1 to 20 %, the centre up to one field outside."""
    rng = np.random.default_rng([seed, DEFECTS.index(defect)])
    parts = draw_parts(seed) if defect == DRAWN else None
    while True:
        radius = np.exp(rng.uniform(np.log(5e-3), np.log(50.0)))
        if defect == "contact 0.3 mm":
            radius = np.exp(rng.uniform(np.log(0.3), np.log(50.0)))
        rings = np.exp(rng.uniform(np.log(3.0), np.log(300.0)))
        place = rng.uniform(-1.0, 2.0, 2) if defect != "contact 0.3 mm" else rng.uniform(0.2, 0.8, 2)
        corners = np.array([[0, 0], [0, 1], [1, 0], [1, 1]]) - place
        far2 = (corners**2).sum(axis=1).max()
        near2 = (np.maximum(np.maximum(-place, place - 1), 0) ** 2).sum()
        turns = rings / (far2 - near2)  # over the frame's side squared
        size = int(max(256, np.ceil(2 * turns * np.sqrt(far2) / _FINEST)))
        pixel_size = np.sqrt(turns * radius * WAVELENGTH) / size
        steep = pixel_size * size * np.sqrt(far2) / radius
        fits = defect != "contact 0.3 mm" or 0.5 * pixel_size * size > 2 * 0.3e-3
        if not (size <= largest and steep < 0.3 and fits):
            continue
        noise = np.exp(rng.uniform(np.log(0.01), np.log(0.2)))
        gap = rng.uniform(0, WAVELENGTH / 2) if defect != "contact 0.3 mm" else 0.0
        case = Case(defect, radius, pixel_size, size, tuple(place * (size - 1)), gap, noise, seed, rings)
        # Other rings for the same parts: these stay drawn from their priors.
        case = case if parts is None else _with_parts(case, parts)
        if case.size <= largest:
            return case


def _with_parts(case: Case, parts: DrawnParts) -> Case:
    """The same in as many pixels as its fringes need with parts, and with so many rings."""
    side = np.linspace(0, case.size - 1, 33)
    x, y = np.meshgrid(side, side)
    with_parts = replace(case, parts=parts, gap=parts.gap)
    along_x = phase(with_parts, x + 0.5, y) - phase(with_parts, x - 0.5, y)
    along_y = phase(with_parts, x, y + 0.5) - phase(with_parts, x, y - 0.5)
    size = int(max(256, np.ceil(case.size * float(np.hypot(along_x, along_y).max()) / _FINEST)))
    centre = tuple(np.array(case.centre) / (case.size - 1) * (size - 1))
    return replace(with_parts, size=size, centre=centre, pixel_size=case.pixel_size * case.size / size)


def phase(case: Case, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Turns of the path difference at pixels, the half turn of the reflection left out."""
    if case.parts is not None:
        r2 = squared_distance(case.parts, case.size, case.centre, x, y) * case.pixel_size**2
        turns = _turns(case, r2, _sphere(case, r2), view_of(case.parts))
        return turns + form_turns(case.parts, case.size, case.centre, x, y)
    rng = np.random.default_rng([case.seed, 7])
    half = (case.size - 1) / 2
    unit = np.hypot(half, half)
    sign, other_law = rng.choice([-1.0, 1.0]), rng.random() < 0.5
    kappa = sign * 0.02 if case.defect == "distortion 2 %" else 0.0
    azimuth, tilt = rng.uniform(0, np.pi), np.radians(8.0) if case.defect == "tilt 8 deg" else 0.0

    def on_object(px, py):
        ux, uy = (px - half) / unit, (py - half) / unit
        u2 = ux**2 + uy**2
        if not other_law:
            factor = 1 + kappa * u2
        else:  # the image is the object's point times 1 - kappa rho²: its root by Newton's method
            rho = np.sqrt(u2)
            for _ in range(20):
                rho = rho - (rho * (1 - kappa * rho**2) - np.sqrt(u2)) / (1 - 3 * kappa * rho**2)
            factor = np.where(u2 > 0, rho / np.sqrt(np.where(u2 > 0, u2, 1.0)), 1.0)
        return ux * factor * unit, uy * factor * unit

    centre = case.centre
    if np.hypot(*(np.array(centre) - half)) < unit:
        centre = on_object(*(np.float64(c) for c in centre))
    else:  # outside of the frame the lens is not used: the object's own centre
        centre = tuple(c - half for c in centre)
    ox, oy = on_object(x, y)
    dx, dy = (ox - centre[0]) * case.pixel_size, (oy - centre[1]) * case.pixel_size
    along = (np.cos(azimuth) * dx + np.sin(azimuth) * dy) / np.cos(tilt)
    across = -np.sin(azimuth) * dx + np.cos(azimuth) * dy
    r2 = along**2 + across**2
    thickness = _sphere(case, r2)
    if case.defect == "contact 0.3 mm":
        a = 0.3e-3
        r = np.sqrt(np.maximum(r2, a**2))
        thickness += (-2 * a**2 + 2 / np.pi * ((2 * a**2 - r**2) * np.arcsin(a / r) + a * np.sqrt(r**2 - a**2))) / (
            2 * case.radius
        )
        thickness = np.where(r2 > a**2, thickness, 0.0)
    return _turns(case, r2, thickness, np.cos(tilt))


def _sphere(case: Case, r2: np.ndarray) -> np.ndarray:
    return case.gap + r2 / case.radius / (1 + np.sqrt(1 - r2 / case.radius**2))


def _turns(case: Case, r2: np.ndarray, thickness: np.ndarray, cosine: float) -> np.ndarray:
    glass = {} if case.parts is None else case.parts.glass
    return (2 * thickness * cosine + added_path(case.radius, r2, case.gap, **glass)) / WAVELENGTH


def photograph(case: Case):
    """The image, a float array or 8-bit codes, and the pixel size and its standard deviation as given to the fit."""
    rng = np.random.default_rng([case.seed, 11])
    y, x = np.mgrid[: case.size, : case.size].astype(float)
    turns = phase(case, x, y)
    wave = np.cos(2 * np.pi * turns)
    if case.defect == "doublet":  # lines 0.597 nm apart, intensities 2 : 1, about the same mean
        share = 0.597e-9 / WAVELENGTH
        wave = (2 * np.cos(2 * np.pi * turns * (1 + share / 3)) + np.cos(2 * np.pi * turns * (1 - 2 * share / 3))) / 3
    image = 0.5 - 0.5 * wave
    if case.defect == "second rings":
        shift = rng.uniform(-0.3, 0.3, 2) * case.size
        other = replace(case, defect="none", centre=tuple(np.array(case.centre) + shift), radius=case.radius * 1.7)
        image = (image - 0.05 * np.cos(2 * np.pi * phase(other, x, y)) + 0.05) / 1.1
    half = (case.size - 1) / 2
    if case.defect == "vignette 20 %":
        image *= 1 - 0.2 * ((x - half) ** 2 + (y - half) ** 2) / (2 * half**2)
    if case.defect == "dust and crosshair":
        middle = rng.uniform(0.4, 0.6, 2) * case.size
        image[(np.abs(x - middle[0]) < 2) | (np.abs(y - middle[1]) < 2)] *= 0.15
        for _ in range(25):
            at, width = rng.uniform(0, case.size, 2), rng.uniform(2, 8) * case.size / 512
            image[(x - at[0]) ** 2 + (y - at[1]) ** 2 < width**2] *= 0.3
    if case.defect == "gamma 2.2":
        image = image ** (1 / 2.2)
    image = image + case.noise * rng.normal(size=image.shape)
    if case.defect == "JPEG 50":
        image = _jpeg(image)
    given = case.pixel_size * (1 + (0.01 * rng.normal() if case.defect == "scale 1 %" else 0.0))
    return image, given, 0.01 * given if case.defect == "scale 1 %" else None


def _jpeg(image: np.ndarray) -> np.ndarray:
    import imageio.v3 as iio

    light = np.clip(0.1 + 0.8 * image, 0, 1)
    code = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    file = BytesIO(iio.imwrite("<bytes>", np.uint8(np.round(255 * code)), extension=".jpg", quality=50))
    return np.asarray(iio.imread(file, extension=".jpg"))


def bound(case: Case, pixels: int = 20_000) -> float:
    """Cramér–Rao bound of the radius's relative deviation, six unknowns, without the defect."""
    plain = replace(case, defect="none", parts=None)
    rng = np.random.default_rng(0)
    x, y = rng.uniform(0, case.size - 1, (2, pixels))

    def turns(radius, x0, y0):
        return phase(replace(plain, radius=radius, centre=(x0, y0)), x, y)

    best = np.array([case.radius, *case.centre])
    columns = []
    for k, step in enumerate((1e-6 * case.radius, 1e-3, 1e-3)):
        move = np.eye(3)[k] * step
        columns.append((turns(*(best + move)) - turns(*(best - move))) / (2 * step))
    at = 2 * np.pi * turns(*best)
    swing = np.pi * np.sin(at)
    table = np.stack([swing * column for column in columns] + [swing, np.ones(pixels), np.cos(at)], axis=1)
    scale = np.linalg.norm(table, axis=0)
    with np.errstate(all="ignore"):
        inverse = np.linalg.pinv((table / scale).T @ (table / scale), rcond=1e-14, hermitian=True)
    return float(case.noise * np.sqrt(max(inverse[0, 0], 0.0) * pixels / case.size**2) / scale[0] / case.radius)
