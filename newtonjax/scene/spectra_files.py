"""CSV files of spectra, wavelength and power, and of cameras' responses, wavelength and a column for each channel."""

import csv
from pathlib import Path

import numpy as np

from newtonjax.numerics import shown
from newtonjax.scene.limits import WAVELENGTH
from newtonjax.scene.response import Response, cie_1931
from newtonjax.scene.spectrum import Spectrum, sampled_spectrum

_FACTORS = {"nm": 1e-9, "um": 1e-6, "m": 1.0, "angstrom": 1e-10}
# A step so many times the usual one is a gap.
_GAP = 4.0


def read_spectrum(path: Path) -> Spectrum:
    """The spectrum in a CSV file of two columns, wavelength in vacuum and power per wavelength, linear in between.

    The header names the unit: `wavelength_nm`, `wavelength_um`, `wavelength_angstrom` or `wavelength_m`; lines that
    begin with # are left out.

    Raises ValueError, in one line with the file and its line, for no such header, a number that is none, wavelengths
    that do not ascend or that no light has, negative powers, a gap, and fewer than three samples.
    """
    at, columns = _table(path, "spectrum", ("power",))
    if columns.shape[1] != 1:
        raise ValueError(f"{path} has {columns.shape[1]} columns of powers; allowed: wavelength_nm,power")
    return sampled_spectrum(at, columns[:, 0])


def camera_response(text: str) -> Response:
    """The responses of a camera's channels that a few words name.

    - `cie_1931`: those of the CIE's standard observer.
    - `camera.csv`: a file of a column of wavelengths in vacuum and one column for each channel, red, green and blue, or
      one; responses to power, linear in between. Its header and what is refused are as in `read_spectrum`.

    Raises ValueError for what is none of these.
    """
    if not isinstance(text, str):
        raise ValueError(f"response is {shown(text)}; allowed: cie_1931, or a file camera.csv")
    name = text.strip()
    if name.lower() == "cie_1931":
        return cie_1931()
    if not name.lower().endswith(".csv"):
        raise ValueError(f"response {shown(text)} is not known; allowed: cie_1931, or a file camera.csv")
    path = Path(name)
    at, columns = _table(path, "response", ("red", "green", "blue"))
    if columns.shape[1] not in (1, 3):
        raise ValueError(f"{path} has {columns.shape[1]} channels; allowed: one, or three: red,green,blue")
    return Response(at, columns.T)


def _table(path: Path, kind: str, channels: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths [m] and columns of a file, checked; `kind` and `channels` for its messages."""
    header = ",".join(("wavelength_nm", *channels))
    if not path.is_file():
        raise ValueError(f"{path} is not a file; give a {kind} in CSV, with a header such as {header}")
    text = path.read_text(encoding="utf-8-sig")
    rows = [(number, row) for number, row in enumerate(csv.reader(text.splitlines()), 1) if row and row[0][:1] != "#"]
    if not rows:
        raise ValueError(f"{path} is empty; give a header such as {header} and the samples below it")
    name, _, unit = rows[0][1][0].strip().lower().rpartition("_")
    width = len(rows[0][1])
    if name != "wavelength" or unit not in _FACTORS or width < 2:
        raise ValueError(f"{path}: the header is {','.join(rows[0][1])!r}; allowed: {header} (or _um, _angstrom, _m)")
    table = np.array([_numbers(path, number, row, width) for number, row in rows[1:]]).reshape(-1, width)
    at, powers = table[:, 0] * _FACTORS[unit], table[:, 1:]
    _check(path, at, powers, unit)
    return at, powers


def _numbers(path: Path, number: int, row: list[str], width: int) -> list[float]:
    try:
        numbers = [float(cell) for cell in row]
    except ValueError:
        numbers = []
    if len(numbers) != width:
        raise ValueError(f"{path}, line {number}: {','.join(row)!r}; allowed: {width} numbers, the wavelength first")
    return numbers


def _check(path: Path, at: np.ndarray, powers: np.ndarray, unit: str) -> None:
    if len(at) < 3:
        raise ValueError(f"{path} has {len(at)} samples; allowed: three or more")
    if not np.all(np.isfinite(at)) or not np.all(WAVELENGTH.holds(at)):
        raise ValueError(
            f"{path}: wavelengths reach from {at.min():.3g} m to {at.max():.3g} m by the unit {unit} of its header; "
            f"allowed: {WAVELENGTH.words}"
        )
    steps = np.diff(at)
    if np.any(steps <= 0):
        row = int(np.argmax(steps <= 0)) + 1
        raise ValueError(f"{path}: sample {row + 1} lies below the one before; allowed: ascending wavelengths")
    if steps.max() > _GAP * np.median(steps):
        low = at[int(steps.argmax())]
        raise ValueError(
            f"{path} has a gap of {steps.max() * 1e9:.3g} nm at {low * 1e9:.4g} nm; allowed: samples at most {_GAP:g} "
            "times the usual step apart (fill it in, with powers of 0 where there is no light)"
        )
    if not np.all(np.isfinite(powers)) or np.any(powers < 0) or not powers.any(axis=0).all():
        raise ValueError(f"{path} has powers that are negative or all 0; allowed: 0 or more")
