"""Made tables of ring readings: of a sphere with honest readings, and of what goes wrong with tables."""

from dataclasses import dataclass

import numpy as np

WAVELENGTH = 589.3e-9
# What goes wrong, one kind a row of the table.
KINDS = (
    "equidistant",
    "fourth power",
    "miscounted between groups",
    "miscounted from some ring on",
    "radii among diameters",
    "two digits exchanged",
    "series of different scale",
    "series of different scale, no column",
    "series counted apart",
    "rings' errors common to the series",
    "stated sd a tenth of the true",
    "micrometres for millimetres",
)


@dataclass(frozen=True)
class MadeTable:
    """Columns of a table, and the lens radius [m] behind them; None where no radius is."""

    columns: dict[str, np.ndarray]
    radius: float | None


def honest(seed: int, fewest: int = 3) -> MadeTable:
    """A sphere's diameters: 3 to 40 rings with orders missing, a gap or none, reading sd 1 to 20 um, stated or not.

    A third of the tables holds two to four series, named by a column or not.
    """
    rng = np.random.default_rng((seed, 0))
    radius = 10 ** rng.uniform(-1.3, 1.0)
    count = round(10 ** rng.uniform(np.log10(fewest), np.log10(40)))
    order = _orders(rng, count)
    offset = rng.choice([0.0, rng.uniform(-0.5, 8.0)])
    series = int(rng.choice([1, 1, rng.integers(2, 5)]))
    order, number = np.tile(order, series), np.repeat(np.arange(series), count)
    columns, sd = _read(rng, order, _sphere(radius, order + offset))
    if rng.random() < 0.4:
        columns["sd_mm"] = np.full(len(order), 1e3 * sd)
    if series > 1 and rng.random() < 0.5:
        columns["series"] = number
    return MadeTable(columns, radius)


def coarse(seed: int) -> MadeTable:
    """An honest table whose diameters are read to the power of ten next below the spacing of its rings.

    Some half of the spacing in the mean: the errors of equal repeats are then one rounding.
    """
    made = honest(seed)
    spacing = np.diff(2e3 * _sphere(made.radius or 1.0, np.unique(made.columns["order"])))
    places = -int(np.floor(np.log10(0.5 * np.median(spacing)) + 0.3))
    columns = {name: column for name, column in made.columns.items() if name != "sd_mm"}
    return MadeTable(columns | {"diameter_mm": np.round(columns["diameter_mm"], places)}, made.radius)


def off_model(kind: str, seed: int) -> MadeTable:
    """A table of a kind of `KINDS`."""
    rng = np.random.default_rng((seed, 1 + KINDS.index(kind)))
    radius = 10 ** rng.uniform(-1.0, 0.5)
    count = int(rng.integers(6, 25))
    order = np.arange(count) + float(rng.integers(1, 6))
    sizes = _sphere(radius, order + rng.choice([0.0, rng.uniform(-0.3, 2.0)]))
    if kind in ("equidistant", "fourth power"):
        largest = 10 ** rng.uniform(-3.0, -2.0)
        power = 1.0 if kind == "equidistant" else 0.25
        return MadeTable(_read(rng, order, largest * (order / order[-1]) ** power)[0], None)
    if kind == "miscounted between groups":
        return _miscounted_between_groups(rng, radius)
    if "series" in kind:
        return _series(kind, rng, radius)
    columns, sd = _read(rng, order, sizes)
    diameters = columns["diameter_mm"]
    if kind == "miscounted from some ring on":
        columns["order"] = order - rng.choice([1, 2]) * (np.arange(count) >= rng.integers(2, count - 1))
    elif kind == "radii among diameters":
        share, ring = int(rng.integers(1, count - 1)), np.arange(count)
        is_swapped = np.isin(ring, rng.choice(count, share, replace=False)) if rng.random() < 0.5 else ring < share
        is_swapped = ~is_swapped if rng.random() < 0.5 else is_swapped
        columns["diameter_mm"] = np.where(is_swapped, diameters / 2, diameters)
    elif kind == "two digits exchanged":
        place = int(rng.integers(count))
        diameters[place] = _exchanged(rng, diameters[place])
    elif kind == "stated sd a tenth of the true":
        columns["sd_mm"] = np.full(count, 1e2 * sd)
    else:
        columns["diameter_mm"] = 1e3 * diameters
    return MadeTable(columns, radius)


def _orders(rng: np.random.Generator, count: int) -> np.ndarray:
    """Consecutive orders, each second to fifth one, or some left out at random."""
    first, step = float(rng.integers(1, 12)), float(rng.choice([1, 1, 1, 2, 5]))
    if rng.random() < 0.3:
        return first + np.sort(rng.choice(np.arange(2 * count), count, replace=False))
    return first + step * np.arange(count)


def _sphere(radius: float, order: np.ndarray) -> np.ndarray:
    """Ring radii [m] of the exact sphere: r² = 2 R h - h²."""
    height = np.maximum(order, 0.0) * WAVELENGTH / 2
    return np.sqrt(2 * radius * height - height**2)


def _read(rng: np.random.Generator, order: np.ndarray, sizes: np.ndarray, sd: float | None = None):
    """Columns of diameters read with one sd [m], to a micrometre; and that sd."""
    sd = 10 ** rng.uniform(-6.0, np.log10(20e-6)) if sd is None else sd
    diameters = np.abs(2 * sizes + sd * rng.normal(size=len(order)))
    return {"order": order.astype(float), "diameter_mm": np.round(1e3 * diameters, 3)}, sd


def _miscounted_between_groups(rng: np.random.Generator, radius: float) -> MadeTable:
    """Two or three groups of 4 to 8 rings, and 1 to 3 rings before each next one that were not counted."""
    counted, order, first, missed = [], [], int(rng.integers(5, 25)), 0
    for _ in range(int(rng.integers(2, 4))):
        counted.append(first + np.arange(int(rng.integers(4, 9))))
        order.append(counted[-1] + missed)
        first += int(rng.integers(10, 25))
        missed += int(rng.integers(1, 4))
    counted, order = np.concatenate(counted), np.concatenate(order)
    columns, _ = _read(rng, counted, _sphere(radius, order.astype(float)))
    return MadeTable(columns, radius)


def _series(kind: str, rng: np.random.Generator, radius: float) -> MadeTable:
    """Three to five series of 5 to 12 rings."""
    count, rings = int(rng.integers(3, 6)), int(rng.integers(5, 13))
    order = np.tile(np.arange(1.0, rings + 1), count)
    number = np.repeat(np.arange(count), rings)
    sizes = _sphere(radius, order)
    sd = 10 ** rng.uniform(-6.0, -5.3)
    if "scale" in kind:
        scale_errors = rng.normal(0, 0.01, count)
        # What is common to all series is in no table.
        sizes = sizes * (1 + scale_errors - scale_errors.mean())[number]
    if "common" in kind:
        sizes = sizes + rng.normal(0, 4 * sd, rings)[order.astype(int) - 1]
    columns, _ = _read(rng, order, sizes, sd)
    if "apart" in kind:
        columns["order"] = order + rng.integers(0, 3, count)[number]
    if "no column" not in kind:
        columns["series"] = number
    return MadeTable(columns, radius)


def _exchanged(rng: np.random.Generator, value: float) -> float:
    """A number with two neighbouring digits exchanged."""
    digits = f"{value:.3f}"
    places = [k for k in range(len(digits) - 1) if "." not in digits[k : k + 2] and digits[k] != digits[k + 1]]
    if not places:
        return value
    k = int(rng.choice(places))
    return float(digits[:k] + digits[k + 1] + digits[k] + digits[k + 2 :])
