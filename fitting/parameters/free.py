"""Which numbers of a bench a study measures, and determines with them, where the user names none."""

from collections.abc import Iterable, Sequence

from newtonjax.numerics import names_in, shown

_TARGETS = ("radius", "wedge_angle", "gap")
_OF_RINGS = ("radius", "gap", "centre_x", "centre_y", "exposure", "contrast")
# Fringes of plane faces have no centre.
_OF_A_WEDGE = ("gap", "exposure", "contrast")


def default_target(present: Iterable[str]) -> str:
    """What a bench is for: its radius, else the angle of its wedge, else its gap."""
    names = set(present)
    return next(name for name in _TARGETS if name in names)


def default_free(present: Iterable[str]) -> tuple[str, ...]:
    """What `fit` determines of such a bench."""
    target = default_target(present)
    return _OF_RINGS if target == "radius" else (target, *(name for name in _OF_A_WEDGE if name != target))


def free_names(present: Iterable[str], free: Sequence[str] | str | None) -> tuple[str, ...]:
    """The free numbers that are named, or those of `default_free`."""
    if free is None:
        return default_free(present)
    return names_in("free", free)


def target_first(present: Iterable[str], target: str | None, free: Sequence[str] | str | None) -> tuple[str, ...]:
    """The measured number, and the others that are determined with it."""
    present = tuple(present)
    measured = default_target(present) if target is None else target
    if not isinstance(measured, str):
        raise ValueError(f"target is {shown(measured)}; allowed: the name of a number")
    return (measured, *(name for name in free_names(present, free) if name != measured))
