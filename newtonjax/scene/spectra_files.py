"""Files of spectra: two columns of a CSV file, wavelength and power."""

import csv
from pathlib import Path

import numpy as np

from newtonjax.scene.limits import WAVELENGTH
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
    if not path.is_file():
        raise ValueError(f"{path} is not a file; give a spectrum in CSV, with a header such as wavelength_nm,power")
    text = path.read_text(encoding="utf-8-sig")
    rows = [(number, row) for number, row in enumerate(csv.reader(text.splitlines()), 1) if row and row[0][:1] != "#"]
    if not rows:
        raise ValueError(f"{path} is empty; give a header such as wavelength_nm,power and the samples below it")
    name, _, unit = rows[0][1][0].strip().lower().rpartition("_")
    if name != "wavelength" or unit not in _FACTORS or len(rows[0][1]) != 2:
        raise ValueError(
            f"{path}: the header is {','.join(rows[0][1])!r}; allowed: wavelength_nm,power (or _um, _angstrom, _m)"
        )
    table = np.array([_numbers(path, number, row) for number, row in rows[1:]]).reshape(-1, 2)
    at, powers = table[:, 0] * _FACTORS[unit], table[:, 1]
    _check(path, at, powers, unit)
    return sampled_spectrum(at, powers)


def _numbers(path: Path, number: int, row: list[str]) -> tuple[float, float]:
    try:
        wavelength, power = map(float, row)
    except ValueError:
        raise ValueError(f"{path}, line {number}: {','.join(row)!r}; allowed: two numbers, wavelength,power") from None
    return wavelength, power


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
    if not np.all(np.isfinite(powers)) or np.any(powers < 0) or not powers.any():
        raise ValueError(f"{path} has powers that are negative or all 0; allowed: 0 or more")
