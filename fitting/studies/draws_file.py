"""Draws in a NetCDF file: one row a draw, every column with its unit, and what study they belong to."""

import io
from pathlib import Path

import numpy as np
from jaxtyping import Float
from scipy.io import netcdf_file

from fitting.parameters import output

_ROW = "draw"


class DrawsFile:
    """A file of a target at rows of given numbers, which may end before the rows do.

    `columns`: the rows, by number; `target`: the name of the measured number; `units`: of all; `study`: texts that say
    what they are. `targets`: what the file has already.

    Raises ValueError where the file is of another study, or not a file of draws.
    """

    def __init__(
        self,
        path: Path,
        columns: dict[str, Float[np.ndarray, " rows"]],
        target: str,
        units: dict[str, str],
        study: dict[str, str],
    ):
        self.path, self.columns, self.target, self.units, self.study = path, columns, target, units, study
        self.targets = self._read() if path.exists() else np.zeros(0)

    def write(self, targets: Float[np.ndarray, " fits"]) -> None:
        """A whole file or none."""
        content = io.BytesIO()
        with netcdf_file(content, "w") as file:
            for name, text in self.study.items():
                setattr(file, name, text.encode())
            file.createDimension(_ROW, len(targets))
            for name, values in {**self.columns, self.target: targets}.items():
                column = file.createVariable(name, "f8", (_ROW,))
                column[:] = values[: len(targets)]
                column.units = (self.units[name] or "1").encode()
            file.flush()
            output.write(self.path, content.getvalue(), force=True)

    def _read(self) -> Float[np.ndarray, " fits"]:
        try:
            with netcdf_file(str(self.path), "r", mmap=False) as file:
                same = all(getattr(file, name, b"") == text.encode() for name, text in self.study.items())
                columns = {name: np.array(column[:], dtype=float) for name, column in file.variables.items()}
        except (TypeError, ValueError, IndexError, KeyError, AttributeError, OverflowError, OSError) as error:
            raise ValueError(f"{self.path} is not a file of draws ({error}); {_ELSE}") from None
        targets = columns.get(self.target, np.zeros(0))
        rows = {name: values[: len(targets)] for name, values in self.columns.items()}
        if not (same and all(np.array_equal(columns.get(name, np.zeros(0)), values) for name, values in rows.items())):
            raise ValueError(f"{self.path} holds draws of another study; {_ELSE}")
        return targets


_ELSE = "remove it, or name another file or folder"
