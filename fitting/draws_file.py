"""Draws in a NetCDF file: one row a draw, every column with its unit, and what study they belong to."""

import io
from pathlib import Path

import numpy as np
from jaxtyping import Float
from scipy.io import netcdf_file

from fitting import output

_ROW = "draw"


def write(
    path: Path,
    columns: dict[str, Float[np.ndarray, " draws"]],
    units: dict[str, str],
    study: dict[str, str],
) -> None:
    """A whole file or none: columns [units] of one length, and texts that say what they are."""
    kept = io.BytesIO()
    with netcdf_file(kept, "w") as file:
        for name, text in study.items():
            setattr(file, name, text.encode())
        file.createDimension(_ROW, len(next(iter(columns.values()))))
        for name, values in columns.items():
            column = file.createVariable(name, "f8", (_ROW,))
            column[:] = values
            column.units = (units[name] or "1").encode()
        file.flush()
        content = kept.getvalue()
    output.write(path, content, force=True)


def read(path: Path, study: dict[str, str]) -> dict[str, Float[np.ndarray, " draws"]]:
    """The columns of a file of the same study; none where there is no file.

    Raises ValueError where the file is of another study, or no such file.
    """
    if not path.exists():
        return {}
    try:
        with netcdf_file(str(path), "r", mmap=False) as file:
            same = all(getattr(file, name, b"") == text.encode() for name, text in study.items())
            columns = {name: np.array(one[:], dtype=float) for name, one in file.variables.items()}
    except (TypeError, ValueError, IndexError, OSError) as error:
        raise ValueError(f"{path} is no file of draws ({error}); name another file, or remove it") from None
    if not same:
        raise ValueError(f"{path} holds draws of another study; name another file, or remove it")
    return columns
