"""Tables of ring readings that tests are made of."""

import numpy as np

import fitting

WAVELENGTH = 589.3e-9
RINGS = "1,0.768\n2,1.086\n3,1.33\n4,1.535\n"


def table(radius=1.0, orders=range(1, 16), offset=0.0, wavelength=WAVELENGTH, noise=0.0, seed=0):
    """Exact diameters [mm] of a sphere's dark rings: its height h is the order's; r² = 2 R h - h²."""
    orders = np.array(list(orders), dtype=float)
    height = (orders + offset) * wavelength / 2
    diameters = 2e3 * np.sqrt(2 * radius * height - height**2)
    return {"order": orders, "diameter_mm": diameters + noise * np.random.default_rng(seed).normal(size=len(orders))}


def written(tmp_path, text):
    path = tmp_path / "table.csv"
    path.write_text(text)
    return path


def rings_of(order, radius=1.0, noise=0.0, seed=0):
    """Diameters [mm] of a sphere's rings."""
    order = np.asarray(order, float)
    height = order * WAVELENGTH / 2
    diameter = 2e3 * np.sqrt(2 * radius * height - height**2)
    return diameter + noise * np.random.default_rng(seed).normal(size=len(order))


def measured(order, diameter, **arguments):
    return fitting.rings({"order": order, "diameter_mm": diameter}, **{"wavelength": WAVELENGTH, **arguments})


def warned(result, *words):
    return any(all(word in text for word in words) for text in result.warnings)


def steep(orders):
    """Exact diameters [mm] of a ball of 1 mm radius, whose outer rings are a quarter as wide as it is."""
    height = orders * WAVELENGTH / 2
    return 2e3 * np.sqrt(2 * 1e-3 * height - height**2)
