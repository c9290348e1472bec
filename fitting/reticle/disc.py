"""The pixel size from a disc of known diameter: its edge as an ellipse, with blur and clipping."""

from typing import Any

import numpy as np
from scipy import ndimage, optimize, special

from fitting.photo import Photograph
from fitting.reasons import Reason
from fitting.reticle.contact import is_contact, is_field_of_fringes
from fitting.reticle.lattice import jackknife_sd, unevenness
from fitting.reticle.result import Scale
from fitting.sheet_reasons import SheetReason

# Sectors of the edge that are left out in turn; pixels beside the edge, in widths of its blur and at least.
_SECTORS, _BESIDE, _LEAST_BESIDE = 16, 5.0, 4.0
# A disc has so many pixels across, and its edge stands out by so much of the picture's range.
_SMALLEST, _LEAST_CONTRAST = 12.0, 0.1
# A disc seen at a slant of 35 degrees; beyond, it is no disc.
_LONGEST = 0.2
_UNITS = np.array([1.0, 1.0, 1.0, 1e-2, 1e-2, 1.0, 0.1, 0.1, 0.1, 0.1, 1.0])
# Where the width of a ring stands among the numbers.
_WIDTH = 10
# Rounds of choosing the pixels and fitting; beyond so many deviations of the noise a pixel counts less.
_ROUNDS, _ROBUST = 2, 3.0
# Where its light is clipped, level, blur and radius may stand for one another: then the radius varies by more.
_MOST_SD = 0.004
# A spot whose hole holds more than this share of it is a ring.
_HOLE = 0.02


def of_disc(photograph: Photograph, diameter: float, diameter_sd: float, allowed: np.ndarray | None = None) -> Scale:
    """The scale of a photograph of one dark or bright disc, or a refusal.

    `allowed` [rows, columns]: True where the user lets pixels count; everywhere where it is not given. Of a bright disc
    the photograph's own lit field is no such mask: it leaves out the dark ground.

    The image is an inner and an outer level with slopes, joined by an error function of the distance from an ellipse;
    what is saturated is at least as bright as it is. Of a ring the outer edge counts, and its width is fitted. The
    standard deviation is the jackknife's over sixteen sectors, with the diameter's own and half of the ellipse's
    stretch beyond its noise.
    """
    allowed = np.ones_like(photograph.lit) if allowed is None else allowed
    start = _start(photograph, allowed)
    if start is None:
        return Scale("refused", SheetReason.NO_DISC(), photograph=photograph)
    if is_contact(photograph.image, start):
        return Scale("refused", SheetReason.CONTACT_OF_A_LENS(), photograph=photograph)
    if is_field_of_fringes(photograph.image, start):
        return Scale("refused", SheetReason.LIT_FIELD(), photograph=photograph)
    vector, edge = start, _Edge(photograph, start, allowed)
    for _ in range(_ROUNDS):
        edge = _Edge(photograph, vector, allowed)
        if not edge.is_enough():
            return _untold(photograph)
        vector = _fitted(edge, vector)
        edge.noted(vector)
        vector = _fitted(edge, vector)
    _, _, radius, a, b, blur, *_ = vector
    if not (radius > _SMALLEST / 2 and np.hypot(a, b) < _LONGEST and 0 < abs(blur) < radius):
        return _untold(photograph)
    parts = _without_sectors(edge, vector)
    radii, stretches = [part[2] for part in parts], np.array([part[3:5] for part in parts])
    sds = np.array([jackknife_sd(list(column)) for column in stretches.T])
    radius_sd = jackknife_sd(radii) / radius
    if not radius_sd < _MOST_SD:
        return _untold(photograph)
    # The ellipse's long side is where pixels are short on the object.
    uneven = unevenness(np.array([-a, -b]), sds)
    # A slant too small to be said still makes the mean of both axes too short.
    slant = np.sqrt(max(a**2 + b**2 - float(np.square(sds).sum()), 0.0))
    size = diameter / (2 * radius)
    relative = np.linalg.norm([radius_sd, diameter_sd / diameter, slant / 2])
    warnings: list[str] = [text for text in photograph.warnings if not _is_saturated(text)]
    if not diameter_sd:
        warnings.append(Reason.TREATED_AS_EXACT(names="disc_diameter"))
    if uneven > 0:
        warnings.append(SheetReason.DISC_NOT_ROUND(uneven=uneven))
    return Scale(
        "ok",
        pixel_size=size,
        pixel_size_sd=float(size * relative),
        pixel_size_x=size * float(np.exp(-a / 2)),
        pixel_size_y=size * float(np.exp(a / 2)),
        pixel_size_x_sd=float(size * np.hypot(radius_sd, sds[0] / 2)),
        pixel_size_y_sd=float(size * np.hypot(radius_sd, sds[0] / 2)),
        stretch=-a,
        shear=-b,
        stretch_sd=float(sds[0]),
        shear_sd=float(sds[1]),
        half_diagonal=float(np.hypot(*(n - 1 for n in photograph.image.shape)) / 2),
        diameter=diameter,
        diameter_sd=diameter_sd or None,
        warnings=warnings,
        photograph=photograph,
        marks=_outline(vector)[None],
    )


def _untold(photograph: Photograph) -> Scale:
    """A refusal of a spot whose edge does not tell its radius; of a clipped one, that it is."""
    reason = SheetReason.DISC_CLIPPED if any(map(_is_saturated, photograph.warnings)) else SheetReason.NO_DISC
    return Scale("refused", reason(), photograph=photograph)


def _is_saturated(warning: str) -> bool:
    return getattr(warning, "code", "") == Reason.SATURATED.name


def _start(photograph: Photograph, allowed: np.ndarray) -> np.ndarray | None:
    """Centre, radius and levels of the largest connected spot on either side of the middle level, off the frame."""
    image = ndimage.gaussian_filter(photograph.image, 1.0)
    low, high = np.percentile(image, [2, 98])
    if high - low < _LEAST_CONTRAST * max(abs(high), 1e-12):
        return None
    best = None
    for is_inside in (image < (low + high) / 2, image > (low + high) / 2):
        labels = np.empty(is_inside.shape, np.int32)
        ndimage.label(is_inside & allowed, output=labels)
        edge = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
        sizes = np.bincount(labels.ravel())
        sizes[edge], sizes[0] = 0, 0
        label = int(np.argmax(sizes))
        y, x = np.nonzero(np.asarray(ndimage.binary_fill_holes(labels == label)))
        if sizes[label] > 0 and len(x) > np.pi * _SMALLEST**2 / 4 and (best is None or len(x) > best[0]):
            hole = 1 - sizes[label] / len(x)
            best = (len(x), x.mean(), y.mean(), np.sqrt(len(x) / np.pi), image[labels == label].mean(), hole)
    if best is None:
        return None
    _, x, y, radius, inside, hole = best
    outside = high if inside < (low + high) / 2 else low
    width = [radius * (1 - np.sqrt(hole))] if hole > _HOLE else []
    return np.array([x, y, radius, 0.0, 0.0, 2.0, inside, outside - inside, 0.0, 0.0, *width])


def _is_usable(photograph: Photograph, start: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """Where the light counts: the lit field; of a bright disc all that is allowed, its dark ground included."""
    contrast = start[7]
    return photograph.lit if contrast > 0 else allowed


class _Edge:
    """The pixels beside an edge, and how a model of it differs from them, in deviations of their noise."""

    def __init__(self, photograph: Photograph, start: np.ndarray, allowed: np.ndarray) -> None:
        rows, columns = photograph.image.shape
        y, x = np.mgrid[:rows, :columns]
        beside = max(_BESIDE * abs(start[5]), _LEAST_BESIDE)
        outside = _distance(start, x, y)
        # Of a ring both edges: a width that nothing holds takes the outer edge along.
        inside = min(beside + sum(start[_WIDTH:]), start[2])
        near = (outside < beside) & (outside > -inside) & _is_usable(photograph, start, allowed)
        self._x, self._y, self._light = x[near], y[near], photograph.image[near]
        top = photograph.image[photograph.lit & ~photograph.mask].min(initial=np.inf)
        self._is_clipped = self._light >= top
        angle = np.arctan2(self._y - start[1], self._x - start[0])
        self.sector = ((angle + np.pi) / (2 * np.pi) * _SECTORS).astype(int) % _SECTORS
        self._noise = 0.02 * abs(float(start[7]))
        # Codes are whole numbers: the light that is clipped begins between two.
        self._top = 0.5 * (top + self._light[~self._is_clipped].max(initial=-np.inf))

    def is_enough(self) -> bool:
        """Whether pixels that are not clipped, in all sectors, hold the edge."""
        usable = ~self._is_clipped
        return len(np.unique(self.sector[usable])) == _SECTORS and int(usable.sum()) >= 50

    def noted(self, vector: np.ndarray) -> None:
        """Take the noise from what a fit leaves of the pixels that are not clipped."""
        residual = (_model(vector, self._x, self._y) - self._light)[~self._is_clipped]
        self._noise = max(1.4826 * float(np.median(np.abs(residual))), 1e-3 * abs(float(vector[7])))

    def residual(self, vector: np.ndarray) -> np.ndarray:
        """Model less light [n]; of a clipped pixel by the probability that noise lifts the model to it (Tobin 1958)."""
        level = np.where(self._is_clipped, self._top, self._light)
        difference = (_model(vector, self._x, self._y) - level) / self._noise
        clipped = -np.sqrt(-2 * special.log_ndtr(np.minimum(difference, 30.0)))
        return np.where(self._is_clipped, clipped, difference)

    def rates(self, vector: np.ndarray) -> np.ndarray:
        """Central differences of the residual [n, numbers]."""
        steps = 1e-4 * _UNITS[: len(vector)] * np.eye(len(vector))
        return np.stack(
            [(self.residual(vector + step) - self.residual(vector - step)) / (2 * step.sum()) for step in steps], axis=1
        )


def _fitted(edge: _Edge, start: np.ndarray) -> np.ndarray:
    """Robust least squares on the pixels beside the edge."""
    rates: Any = edge.rates
    scale = _UNITS[: len(start)]
    fit = optimize.least_squares(
        edge.residual, start, rates, x_scale=scale, loss="soft_l1", f_scale=_ROBUST, max_nfev=40
    )
    return fit.x


def _without_sectors(edge: _Edge, vector: np.ndarray) -> list[np.ndarray]:
    """The numbers without the pixels of each sector in turn: a step of Gauss and Newton from the optimum of all."""
    residual, rates = edge.residual(vector), edge.rates(vector)
    # Of soft_l1.
    weights = 1 / np.sqrt(1 + np.square(residual / _ROBUST))
    vectors = []
    for sector in range(_SECTORS):
        used = np.where(edge.sector == sector, 0.0, weights)[:, None] * rates
        vectors.append(vector - np.linalg.solve(used.T @ rates + 1e-12 * np.eye(len(vector)), used.T @ residual))
    return vectors


def _distance(vector: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Pixels from the ellipse outwards, to first order: its squared form is exp of a symmetric matrix without trace."""
    centre_x, centre_y, radius, a, b = vector[:5]
    dx, dy = x - centre_x, y - centre_y
    m = float(np.hypot(a, b))
    shape = np.sinh(m) / m if m > 0 else 1.0
    square = (np.cosh(m) - a * shape) * dx**2 - 2 * b * shape * dx * dy + (np.cosh(m) + a * shape) * dy**2
    reach, length = np.sqrt(np.maximum(square, 1e-12)), np.hypot(dx, dy)
    return (reach - radius) * length / np.maximum(reach, 1e-6)


def _outline(vector: np.ndarray) -> np.ndarray:
    """Points of the fitted edge [n, (x, y)]."""
    centre_x, centre_y, radius, a, b = vector[:5]
    angle = np.linspace(0, 2 * np.pi, 181)
    wave = np.stack([np.cos(angle), np.sin(angle)])
    m = float(np.hypot(a, b)) / 2
    shape = np.sinh(m) / m / 2 if m > 0 else 0.5
    half = np.array([[np.cosh(m) + a * shape, b * shape], [b * shape, np.cosh(m) - a * shape]])
    return np.array([centre_x, centre_y]) + radius * (half @ wave).T


def _model(vector: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Levels joined by an error function, with one slope of the light; of a ring the inner edge as well."""
    centre_x, centre_y, radius, _, _, blur, inside, contrast, slope_x, slope_y, *width = vector
    distance, spread = _distance(vector, x, y), np.sqrt(2) * max(abs(blur), 1e-3)
    edge = 0.5 * (1 + special.erf(distance / spread))
    if width:
        edge += 0.5 * special.erfc((distance + width[0]) / spread)
    light = 1 + (slope_x * (x - centre_x) + slope_y * (y - centre_y)) / radius
    return (inside + contrast * edge) * light
