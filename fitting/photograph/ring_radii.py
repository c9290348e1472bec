"""The radii of the rings by their order, as the fitted model has them: what people plot by hand."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from fitting.estimate import Fitted
from fitting.model import PARTS, GapModel, gap_phase, numbers_of
from fitting.parameters import EXPONENTS, NUMBERS, Numbers, Quantities, block_of

KINDS = ("dark", "bright")
# Numbers that change the phase at one distance from the rings' centre; all others move pixels, or mean to nothing.
# Rows of blocks whose distances are computed at a time.
_ROWS = 128
_RADIAL = ("curvature", "phase", *PARTS["contact"].parameters, *PARTS["film"].parameters)
# Points of r² between which the phase is all but straight, and Newton's steps from there.
_POINTS, _STEPS = 4000, 3
# Degree in r² of a traced bench's phase, in the mean over the azimuth.
_DEGREE = 6
# A ring whose radius is nothing within so many deviations is the spot at the centre.
_SPOT = 3.0


class FittedRing(NamedTuple):
    """A ring of the fitted model, and its radius on the object.

    - `order`: counted from contact as in `fitting.rings`: of dark rings from 1 in reflection, of bright ones likewise.
    - `kind`: "dark" or "bright".
    - `radius_px`, `radius_px_sd`: with distortion and view undone: the root of the product of an ellipse's half axes.
    - `radius`, `radius_sd` [m]: with the deviation of the pixel size; None without a scale.
    - `sphere_px`: where the ring of the sphere alone would be, r² = 2 R h - h² at its height h over the apex: without a
      pressed contact, a film, and what a microscope adds. None for a ring that the sphere has not.

    The rings are one model's, so their deviations are not independent.
    """

    order: int
    kind: str
    radius_px: float
    radius_px_sd: float
    radius: float | None = None
    radius_sd: float | None = None
    sphere_px: float | None = None


# Of its fields in JSON, units in the keys.
KEYS = ("order", "kind", "radius_px", "radius_sd_px", "radius_m", "radius_sd_m", "sphere_radius_px")


class _Law(NamedTuple):
    """Phase [turns] at squared radii [px²], and its derivatives [radii, radial numbers]."""

    phase: np.ndarray
    slopes: np.ndarray


def rings_of(fit: Fitted, known: Quantities, contact_phase: float, covariance: np.ndarray) -> list[FittedRing]:
    """Dark and bright rings within the light that was used, from the centre outwards.

    `contact_phase` [turns]: of touching faces, a half where they are dark; `covariance`: of the fit's unknowns.
    """
    low, high = _used_squares(fit)
    squares, turns = np.linspace(low, high, _POINTS), _turns_of_contact(fit, contact_phase)
    phase = _law(fit, squares).phase - turns
    halves = np.arange(np.ceil(2 * phase[0]), np.floor(2 * phase.max()) + 1)
    halves = halves[(halves >= 0) & (halves > 2 * phase[0] + 1e-9)]
    if not len(halves):
        return []
    # Where a film or a pressed disc keeps the phase from rising, the outer place counts.
    rising = np.maximum.accumulate(phase)
    r2 = np.interp(halves / 2, rising, squares)
    step = 1e-4 * (high - low)
    for _ in range(_STEPS):
        growth = _growth(fit, r2, step)
        r2 = np.clip(r2 - (_law(fit, r2).phase - turns - halves / 2) / growth, 0.25 * r2, high)
    radius_px = np.sqrt(r2)
    by_number = -_law(fit, r2).slopes / (2 * radius_px * _growth(fit, r2, step))[:, None]
    spread = block_of(covariance, _RADIAL)
    radius_px_sd = _deviations(by_number, spread)
    values, slope, _, _ = fit.model.answer(known, Numbers(*fit.numbers), contact_phase)
    lengths = _lengths(known, values, slope, radius_px, by_number, spread)
    spheres = _sphere_radii(halves / 2 + turns - _apex_phase(fit), values)
    is_bright = (halves + 2 * contact_phase) % 2 == 0
    if fit.solution.point.modulus.mean() < 0:  # as if seen from the other side
        is_bright = ~is_bright
    columns = np.ceil(halves / 2).astype(int), is_bright, radius_px, radius_px_sd, lengths, spheres
    return [
        FittedRing(int(order), KINDS[int(bright)], float(px), float(px_sd), *length, sphere_px=sphere)
        for order, bright, px, px_sd, length, sphere in zip(*columns, strict=True)
        if px > _SPOT * px_sd
    ]


def _sphere_radii(turns: np.ndarray, values: Mapping[str, float]) -> list[float | None]:
    """Radii [px] at which the sphere alone is so many turns above its apex."""
    if "radius" in values:
        height = turns * values["wavelength"] / (2 * values["gap_index"])
        squares = (2 * values["radius"] * height - height**2) / values["pixel_size"] ** 2
    else:
        squares = turns / values["fringe_scale_per_px2"]
    return [float(np.sqrt(square)) if square > 0 else None for square in squares]


def _apex_phase(fit: Fitted) -> float:
    """The phase at the apex of the sphere [turns]."""
    if isinstance(fit.model, GapModel):
        return float(Numbers(*fit.numbers).phase)
    return float(_law(fit, np.zeros(1)).phase[0])


def _turns_of_contact(fit: Fitted, contact_phase: float) -> float:
    """The phase of touching faces; where whole turns are not counted, that next to the apex, as in `gap_phase`."""
    if isinstance(fit.model, GapModel) and not fit.model.microscope.modulo:
        return contact_phase
    return contact_phase + float(np.floor(_apex_phase(fit) - contact_phase + 0.25))


def _used_squares(fit: Fitted) -> tuple[float, float]:
    """Least and largest r² of the blocks with light [px²]; 0 where the centre is among them."""
    grid, used = fit.reduced.grid, fit.left.weights > 0
    lows, highs, nearest = [], [], (np.inf, False)
    # By rows: distances of all blocks at once, with what they are computed of, take more memory than the fit itself.
    for first in range(0, len(grid.y), _ROWS):
        rows = slice(first, first + _ROWS)
        r2 = _squares(fit, grid.x[None], grid.y[rows, None])
        place = np.unravel_index(r2.argmin(), r2.shape)
        nearest = min(nearest, (float(r2[place]), bool(used[rows][place])), key=lambda pair: pair[0])
        of_used = r2[used[rows]]
        lows += [float(of_used.min())] if of_used.size else []
        highs += [float(of_used.max())] if of_used.size else []
    is_inside = nearest[1] and min(lows) <= 2 * grid.block**2
    return (0.0 if is_inside else min(lows)), max(highs)


def _squares(fit: Fitted, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return gap_phase.squared_distance(fit.model, x, y, fit.numbers)


def _growth(fit: Fitted, r2: np.ndarray, step: float) -> np.ndarray:
    """Turns per px²."""
    below = np.maximum(r2 - step, 0.0)
    return (_law(fit, r2 + step).phase - _law(fit, below).phase) / (r2 + step - below)


def _law(fit: Fitted, r2: np.ndarray) -> _Law:
    return _of_formula(fit.model, fit.numbers, r2) if isinstance(fit.model, GapModel) else _of_bench(fit, r2)


def _of_formula(model: GapModel, vector: np.ndarray, r2: np.ndarray) -> _Law:
    """The gap formula about a centre in the middle of the frame, where nothing is displaced.

    A form's terms mean to nothing over the azimuth.
    """
    numbers = Numbers(*vector)
    radial = {name: getattr(numbers, name) for name in (*_RADIAL, *numbers_of(("oblique_view",)))}
    centred = np.array(Numbers(**({"centre_x": 0.0, "centre_y": 0.0} | radial)))
    x, y = model.frame.middle
    unit = gap_phase.squared_distance(model, np.array([x + 1.0]), np.array([y]), centred)
    phase, slopes = gap_phase.phase_and_slopes(model, x + np.sqrt(r2 / unit), np.full_like(r2, y), centred)
    columns = [np.broadcast_to(slopes.get(name, 0.0), r2.shape) for name in _RADIAL]
    return _Law(phase, np.stack(columns, axis=1))


def _of_bench(fit: Fitted, r2: np.ndarray) -> _Law:
    """A traced bench's phase at its nodes, as a polynomial in r²: its mean over the azimuth, as the nodes cover it."""
    frame, fields = fit.model.frame, fit.solution.fields
    at_nodes = _squares(fit, frame.x, frame.y)
    half = at_nodes.max() / 2
    inside, at = chebyshev.chebvander(at_nodes / half - 1, _DEGREE), chebyshev.chebvander(r2 / half - 1, _DEGREE)
    columns = [NUMBERS.index(name) for name in _RADIAL]
    tables = np.column_stack([fields.phase, fields.slopes[:, columns]])
    values = at @ np.linalg.lstsq(inside, tables, rcond=None)[0]
    return _Law(values[:, 0], values[:, 1:])


def _deviations(by_number: np.ndarray, spread: np.ndarray) -> np.ndarray:
    return np.sqrt(np.maximum(np.einsum("ri,ij,rj->r", by_number, spread, by_number), 0.0))


def _lengths(
    known: Quantities, values: Mapping[str, float], slope: float, radius_px: np.ndarray, by_number: np.ndarray, spread
) -> Sequence[tuple[float, float] | tuple[None, None]]:
    """Radii and their deviations [m], where the pixel size is given or measured.

    `slope`: of what is measured by the first number.
    """
    if known.unknown is None:
        return [(None, None)] * len(radius_px)
    size, radius = values["pixel_size"], values["pixel_size"] * radius_px
    relative = known.sd.get("pixel_size", 0.0) / size
    by_number = by_number * size
    if known.unknown == "pixel_size":
        by_number[:, _RADIAL.index("curvature")] += radius_px * slope
        shares = [EXPONENTS[name] / EXPONENTS["pixel_size"] * sd / values[name] for name, sd in known.sd.items()]
        relative = float(np.linalg.norm(shares))
    sd = np.hypot(_deviations(by_number, spread), radius * relative)
    return list(zip(radius.tolist(), sd.tolist(), strict=True))


def table_of(rings: Sequence[FittedRing], kind: str) -> dict[str, list]:
    """Columns of one kind, as `fitting.rings` reads them: of the sphere's rings, in mm, without a scale in pixels.

    Where the ring itself is, stands beside it; the deviation is that ring's.
    """
    rows = [ring for ring in rings if ring.kind == kind and ring.sphere_px is not None]
    unit = "px" if any(ring.radius is None for ring in rows) else "mm"
    columns: dict[str, list] = {"order": [], f"radius_{unit}": [], f"sd_{unit}": [], f"seen_{unit}": []}
    for ring in rows:
        factor = 1.0 if ring.radius is None else 1e3 * ring.radius / ring.radius_px
        sd = ring.radius_px_sd if ring.radius_sd is None else 1e3 * ring.radius_sd
        row = ring.order, factor * (ring.sphere_px or 0.0), sd, factor * ring.radius_px
        for column, value in zip(columns.values(), row, strict=True):
            column.append(value)
    return columns
