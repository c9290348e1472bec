"""Refractive indices of named matter, by its dispersion formula.

Indices of glasses, crystals and liquids are relative to air, as catalogues give them, at about 20 °C; the wavelength of
the formulas is that in air [um], for which the vacuum value stands here (1e-5 of an index). Beyond the wavelengths of
which a formula was made nothing is said of the index.
"""

from difflib import get_close_matches
from typing import NamedTuple

from newtonjax.numerics import Scalar, namespace, require, shown
from newtonjax.scene.limits import WAVELENGTH


class Sellmeier(NamedTuple):
    """n² = 1 + Σ B λ² / (λ² - C), λ in um, C in um²."""

    strengths: tuple[float, ...]
    poles: tuple[float, ...]

    def at(self, square):
        """At a squared wavelength [um²]."""
        total = sum(b * square / (square - c) for b, c in zip(self.strengths, self.poles, strict=True))
        return namespace(square).sqrt(1 + total)


class Cauchy(NamedTuple):
    """n = A + B / λ², λ in um."""

    constant: float
    slope: float

    def at(self, square):
        """At a squared wavelength [um²]."""
        return self.constant + self.slope / square


class Ciddor(NamedTuple):
    """n = 1 + Σ A / (B - 1/λ²), λ in um."""

    strengths: tuple[float, ...]
    poles: tuple[float, ...]

    def at(self, square):
        """At a squared wavelength [um²]."""
        return 1 + sum(a / (b - 1 / square) for a, b in zip(self.strengths, self.poles, strict=True))


def _squares(*wavelengths: float) -> tuple[float, ...]:
    return tuple(at * at for at in wavelengths)


# Names as they are usually written. "SCHOTT": Optical glass data sheets, SCHOTT AG 2017.
DISPERSIONS = {
    "N-BK7": Sellmeier((1.03961212, 0.231792344, 1.01046945), (0.00600069867, 0.0200179144, 103.560653)),  # SCHOTT
    "N-K5": Sellmeier((1.08511833, 0.199562005, 0.930511663), (0.00661099503, 0.024110866, 111.982777)),  # SCHOTT
    "N-BAF10": Sellmeier((1.5851495, 0.143559385, 1.08521269), (0.00926681282, 0.0424489805, 105.613573)),  # SCHOTT
    "F2": Sellmeier((1.34533359, 0.209073176, 0.937357162), (0.00997743871, 0.0470450767, 111.886764)),  # SCHOTT
    "SF10": Sellmeier((1.62153902, 0.256287842, 1.64447552), (0.0122241457, 0.0595736775, 147.468793)),  # SCHOTT
    "N-SF11": Sellmeier((1.73759695, 0.313747346, 1.89878101), (0.013188707, 0.0623068142, 155.23629)),  # SCHOTT
    # Malitson, J. Opt. Soc. Am. 55, 1205 (1965).
    "fused silica": Sellmeier((0.6961663, 0.4079426, 0.8974794), _squares(0.0684043, 0.1162414, 9.896161)),
    # Malitson, Appl. Opt. 2, 1103 (1963).
    "CaF2": Sellmeier((0.5675888, 0.4710914, 3.8484723), _squares(0.050263605, 0.1003909, 34.64904)),
    # Dodge, Appl. Opt. 23, 1980 (1984); the ordinary ray.
    "MgF2": Sellmeier((0.48755108, 0.39875031, 2.3120353), _squares(0.04338408, 0.09461442, 23.793604)),
    # Malitson and Dodge, J. Opt. Soc. Am. 62, 1405 (1972); the ordinary ray.
    "sapphire": Sellmeier((1.4313493, 0.65054713, 5.3414021), _squares(0.0726631, 0.1193242, 18.028251)),
    # Daimon and Masumura, Appl. Opt. 46, 3811 (2007), at 20 °C.
    "water": Sellmeier(
        (5.684027565e-1, 1.726177391e-1, 2.086189578e-2, 1.130748688e-1),
        (5.101829712e-3, 1.821153936e-2, 2.620722293e-2, 1.069792721e1),
    ),
    # ISO 8036:2015: n_e = 1.518 and the Abbe number V_e = 44, as two terms of Cauchy's formula.
    "immersion oil": Cauchy(1.497525, 0.0061057),
    # Ciddor, Appl. Opt. 35, 1566 (1996), standard air of 15 °C.
    "air": Ciddor((0.05792105, 0.00167917), (238.0185, 57.362)),
}
# Wavelengths [um] that the formulas hold for, by the sources above; of the oil, whose standard says three, the visible.
RANGES = {
    "N-BK7": (0.3, 2.5),
    "N-K5": (0.31, 2.5),
    "N-BAF10": (0.35, 2.5),
    "F2": (0.32, 2.5),
    "SF10": (0.38, 2.5),
    "N-SF11": (0.37, 2.5),
    "fused silica": (0.21, 3.71),
    "CaF2": (0.23, 9.7),
    "MgF2": (0.2, 7.0),
    "sapphire": (0.2, 5.0),
    "water": (0.182, 1.129),
    "immersion oil": (0.38, 0.8),
    "air": (0.23, 1.69),
}
_ROUNDING = 1e-6
_KEYS = {"".join(filter(str.isalnum, name)).lower(): name for name in DISPERSIONS}
_ALSO = {"bk7": "N-BK7", "silica": "fused silica", "sio2": "fused silica", "sf11": "N-SF11", "oil": "immersion oil"}


def refractive_index(name: str, wavelength: Scalar) -> Scalar:
    """Of named matter at a vacuum wavelength [m], which may be traced: of air itself absolute, else relative to air.

    Names are those of `DISPERSIONS`, whatever their case, hyphens and spaces. Raises ValueError for others, with the
    nearest, and for a wavelength outside of the formula's range.
    """
    if not isinstance(name, str):
        raise ValueError(f"matter is {shown(name)}; allowed: a name such as 'N-BK7'")
    key = "".join(filter(str.isalnum, name)).lower()
    names = _KEYS | _ALSO
    if key not in names:
        near = get_close_matches(key, names, 3, 0.0)
        nearest = ", ".join(dict.fromkeys(names[match] for match in near))
        allowed = f"{', '.join(DISPERSIONS)}, or a number"
        raise ValueError(f"matter {shown(name)} is not known; nearest: {nearest}; allowed: {allowed}")
    require("wavelength", wavelength, f"a positive length, {WAVELENGTH.words}", WAVELENGTH.holds)
    micrometres, (low, high) = wavelength * 1e6, RANGES[names[key]]
    require(
        f"wavelength in {names[key]}",
        wavelength,
        f"{low:g} to {high:g} um, which its formula holds for",
        lambda _: (micrometres > low * (1 - _ROUNDING)) & (micrometres < high * (1 + _ROUNDING)),
    )
    return DISPERSIONS[names[key]].at(micrometres**2)
