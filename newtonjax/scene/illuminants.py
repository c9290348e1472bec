"""Continuous light: black bodies, daylight, lamps of one band; and the CIE's tables."""

from functools import cache
from pathlib import Path

import numpy as np
from jaxtyping import Float

from newtonjax.numerics import Scalar, namespace, require, require_one, shown
from newtonjax.scene.spectrum import Spectrum, sampled_spectrum

# Second radiation constant [m K] (exact in the SI of 2019), and that of illuminant A's definition.
_C2, _C2_OF_A = 1.438776877e-2, 1.435e-2
_KELVINS = "500 to 100 000 (in kelvin)"


@cache
def cie_table() -> dict[str, Float[np.ndarray, " samples"]]:
    """The CIE's tables from 380 to 780 nm in steps of 5 nm: "wavelength" [m], "x", "y", "z", and "s0", "s1", "s2"."""
    table = np.loadtxt(Path(__file__).with_name("cie_1931.csv"), delimiter=",", skiprows=2).T
    return dict(zip(("wavelength", "x", "y", "z", "s0", "s1", "s2"), (table[0] * 1e-9, *table[1:]), strict=True))


def black_body(temperature: Scalar) -> Spectrum:
    """Planck's law over the visible range, 380 to 780 nm, at a temperature [K].

    Raises ValueError for one that is not 500 K to 100 000 K.
    """
    require_one("temperature", temperature, _KELVINS, lambda t: (t >= 500) & (t <= 1e5))
    return _planck(temperature, _C2)


def _planck(temperature: Scalar, c2: float) -> Spectrum:
    at = cie_table()["wavelength"]
    xp = namespace(temperature)
    return sampled_spectrum(at, (560e-9 / at) ** 5 / xp.expm1(c2 / (at * temperature)))


def white() -> Spectrum:
    """Equal power at every wavelength, 380 to 780 nm: the CIE's illuminant E."""
    return sampled_spectrum(cie_table()["wavelength"], np.ones(81))


def illuminant(name: str) -> Spectrum:
    """The CIE's illuminant A, E, D50, D55, D65 or D75 (CIE 015:2018). Raises ValueError for another name."""
    if not isinstance(name, str):
        raise ValueError(f"illuminant {shown(name)}; allowed: A, E, D50, D55, D65 or D75")
    if name.upper() == "A":
        return _planck(2848.0, _C2_OF_A)
    if name.upper() == "E":
        return white()
    if name.upper() not in ("D50", "D55", "D65", "D75"):
        raise ValueError(f"illuminant {shown(name)}; allowed: A, E, D50, D55, D65 or D75")
    return daylight(100.0 * int(name[1:]) * _C2 / 1.438e-2)


def daylight(temperature: Scalar) -> Spectrum:
    """A phase of daylight of a correlated colour temperature of 4000 K to 25 000 K (CIE 015:2018, section 4.1.2)."""
    require_one("temperature", temperature, "4000 to 25 000 (in kelvin)", lambda t: (t >= 4000) & (t <= 25000))
    xp, t = namespace(temperature), 1e3 / temperature
    warm = 0.244063 + 0.09911 * t + 2.9678 * t**2 - 4.6070 * t**3
    cold = 0.237040 + 0.24748 * t + 1.9018 * t**2 - 2.0064 * t**3
    x = xp.where(temperature <= 7000, warm, cold)
    y = -3.0 * x**2 + 2.87 * x - 0.275
    m = 0.0241 + 0.2562 * x - 0.7341 * y
    m1 = (-1.3515 - 1.7703 * x + 5.9114 * y) / m
    m2 = (0.0300 - 31.4424 * x + 30.0717 * y) / m
    table = cie_table()
    return sampled_spectrum(table["wavelength"], table["s0"] + m1 * table["s1"] + m2 * table["s2"])


def led(centre: Scalar, width: Scalar) -> Spectrum:
    """A band of Gaussian profile in wavelength, of a centre and a full width at half maximum [m], to a thousandth."""
    require("width", width, "a positive length below a third of the centre, in metres", lambda w: w > 0)
    require("width", width, "a positive length below a third of the centre, in metres", lambda w: w < centre / 3)
    steps = np.linspace(-1.5, 1.5, 41)
    return sampled_spectrum(centre + width * steps, np.exp(-4 * np.log(2) * steps**2))
