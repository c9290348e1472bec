"""All orders of a gap, the coatings of its faces, and the extent of a source, as tables of a TOML file."""

from typing import Any

import msgspec
import numpy as np

from newtonjax.scene import AllOrders, Coating, Extent, coating

_LAYERS, _MIRROR = ("thicknesses", "indices", "extinctions"), ("reflectance", "phase", "absorptance")
# Words that `coating` takes, or the numbers of a coating.
_COATING = msgspec.defstruct(
    "Coating",
    [
        *((name, tuple[float, ...] | None, None) for name in _LAYERS),
        *((name, float | None, None) for name in _MIRROR),
    ],
    forbid_unknown_fields=True,
    omit_defaults=True,
)
ALL_ORDERS = msgspec.defstruct(
    "AllOrders",
    [(name, str | _COATING | None, None) for name in ("upper", "lower")],
    forbid_unknown_fields=True,
    omit_defaults=True,
)

EXTENT = msgspec.defstruct(
    "Extent",
    [("sine", float), ("shape", str, "disc"), ("radiances", tuple[tuple[float, ...], ...] | None, None)],
    forbid_unknown_fields=True,
    omit_defaults=True,
)


def extent_of(table: Any) -> Extent | None:
    """The source in a table. Raises ValueError for one that does not exist."""
    if table is None:
        return None
    radiances = None if table.radiances is None else np.array(table.radiances, dtype=float)
    return Extent(table.sine, table.shape, radiances)


def table_of_extent(extent: Extent) -> Any:
    """`extent_of` the other way."""
    cells = None if extent.radiances is None else tuple(map(tuple, np.asarray(extent.radiances).tolist()))
    return EXTENT(float(extent.sine), extent.shape, cells)


def orders_of(table: Any) -> AllOrders | None:
    """What [all_orders] says. Raises ValueError for a coating that does not exist, with its name."""
    if table is None:
        return None
    coatings = {}
    for name, content in msgspec.structs.asdict(table).items():
        try:
            if isinstance(content, str):
                coatings[name] = coating(content)
            elif content is not None:
                coatings[name] = Coating(**msgspec.structs.asdict(content))
        except ValueError as error:
            raise ValueError(f"[all_orders] {name}: {error}") from None
    return AllOrders(**coatings)


def table_of_orders(orders: AllOrders | None) -> Any:
    """`orders_of` the other way."""
    return None if orders is None else ALL_ORDERS(*map(_table_of_coating, (orders.upper, orders.lower)))


def _table_of_coating(part: Coating | None) -> Any:
    if part is None:
        return None
    layers = [getattr(part, name) for name in _LAYERS]
    tables = [None if numbers is None else tuple(np.asarray(numbers).tolist()) for numbers in layers]
    return _COATING(*tables, *(getattr(part, name) for name in _MIRROR))
