"""Whether two sources are one picture: counted twice, it would make a standard deviation too small."""

import filecmp
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np


def check_no_picture_twice(sources: Sequence[Any], labels: Sequence[str], settings: Sequence[Any]) -> None:
    """Raises ValueError where two sources hold the same, under one name or two, and have the same settings."""
    for first, second in combinations(range(len(sources)), 2):
        if settings[first] == settings[second] and _is_same(sources[first], sources[second]):
            names = " and ".join(dict.fromkeys((labels[first], labels[second])))
            raise ValueError(
                f"{names}: pictures {first + 1} and {second + 1} are one picture, which would count twice; give "
                "different ones"
            )


def _is_same(first: Any, second: Any) -> bool:
    if isinstance(first, np.ndarray) and isinstance(second, np.ndarray):
        return first is second or (first.shape == second.shape and np.array_equal(first, second))
    if not isinstance(first, str | Path) or not isinstance(second, str | Path):
        return False
    if not Path(first).is_file() or not Path(second).is_file():  # what reads it says so
        return False
    return filecmp.cmp(first, second, shallow=False)
