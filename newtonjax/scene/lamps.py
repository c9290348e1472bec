"""Light by a few words: lamps by name, lines, filters, bands, and files of spectra."""

import math
import re
from pathlib import Path

import numpy as np

from newtonjax.numerics import Scalar, is_concrete, require_one, shown
from newtonjax.scene.illuminants import black_body, illuminant, led, white
from newtonjax.scene.lamp_lines import LAMPS, LINES, in_vacuum, nearest_names
from newtonjax.scene.limits import INDEX
from newtonjax.scene.spectra_files import read_spectrum
from newtonjax.scene.spectrum import Spectrum, spectral_line

_LENGTH = re.compile(r"(\d+\.?\d*|\.\d+)\s*(nm|um|\N{MICRO SIGN}m|\N{GREEK SMALL LETTER MU}m|mm|cm|m)")
_METRES = {"nm": 1e-9, "mm": 1e-3, "cm": 1e-2, "m": 1.0}
# How near to a line the wavelength must be that names it [m].
_NEAR = 2e-9
# What passes a filter, as a share of the light, below which the filter was mistaken.
_DARK = 1e-6
GRAMMAR = (
    "a lamp such as sodium, behind a filter mercury:546nm/10nm, one line mercury:546nm, a wavelength 589.3nm or "
    "589.3nm/0.02nm with its width, led:525nm/30nm, white, white:5500K, white:D65, or a file lamp.csv"
)


def lamp(text: str, ambient_index: Scalar = 1.0) -> Spectrum:
    """The spectrum that a few words name.

    - `sodium`, `mercury`, `hydrogen`, `cadmium`, `helium`, `hene`, `krypton`: the lamp's lines; `mercury:546nm` the
      nearest of them, `mercury:546nm/10nm` all behind a filter of this centre and full width at half maximum.
    - `589.3nm`: one line; `589.3nm/0.02nm` of Gaussian profile and this full width at half maximum,
      `589.3nm/lorentzian:0.02nm` of Lorentzian profile, `589.3nm/coherence:30cm` of this coherence length.
    - `led:525nm/30nm`: a band. `white`, `white:5500K`, `white:D65`: equal power, a black body, a CIE illuminant.
    - `lamp.csv`: a file as `read_spectrum` takes it; `lamp.csv:546nm/10nm` behind a filter.

    Lamps' lines are in standard air where the surroundings count as 1, which they do as long as `ambient_index` is
    below 1.0001, and in vacuum where indices are absolute; what is given as a number stays as it is.

    Raises ValueError for what is none of these, with the names that are nearest.
    """
    if not isinstance(text, str):
        raise ValueError(f"light is {shown(text)}; allowed: {GRAMMAR}")
    text = text.strip()
    name, _, after = _parted(text)
    if name.lower().endswith(".csv"):
        return _behind(read_spectrum(Path(name)), after, text)
    if _LENGTH.match(text):
        return _line(text)
    kind = name.lower()
    if kind == "white":
        return _white(after)
    if kind == "led":
        return led(*_centre_and_width(after, text))
    require_one("ambient_index", ambient_index, INDEX.words, INDEX.holds)
    in_air = not (is_concrete(ambient_index) and ambient_index > 1.0001)
    if kind in LAMPS:
        wavelengths, strengths = zip(*LAMPS[kind], strict=True)
        return _lines(kind, _metres(wavelengths, in_air), strengths, after, text)
    if kind in LINES and not after:
        return spectral_line(_metres([LINES[kind]], in_air)[0])
    raise ValueError(f"light {shown(text)} is not known; nearest: {nearest_names(kind)}; allowed: {GRAMMAR}")


def _parted(text: str) -> tuple[str, str, str]:
    """Name, colon and what comes after it; the colon of a path's drive is none."""
    head, dot, tail = text.lower().partition(".csv")
    if dot:
        cut = len(head) + len(dot)
        return text[:cut], tail[:1], text[cut + 1 :]
    return text.partition(":")


def _metres(air_nm, in_air: bool) -> list[float]:
    return [1e-9 * (wavelength if in_air else in_vacuum(wavelength)) for wavelength in air_nm]


def _lines(kind: str, wavelengths: list[float], strengths, after: str, text: str) -> Spectrum:
    spectrum = Spectrum(wavelengths, strengths)
    if not after or "/" in after:
        return _behind(spectrum, after, text)
    wavelength = _length(after, text)
    distance = np.abs(np.array(wavelengths) - wavelength)
    if distance.min() > _NEAR:
        lines = ", ".join(f"{at * 1e9:.4g}nm" for at in wavelengths)
        raise ValueError(f"light {text!r}: {kind} has no line there; allowed: {lines}, or a filter {kind}:546nm/10nm")
    return spectral_line(wavelengths[int(distance.argmin())])


def _behind(spectrum: Spectrum, after: str, text: str) -> Spectrum:
    """Behind the filter that the text names, if it names any."""
    if not after:
        return spectrum
    try:
        filtered = spectrum.filtered(*_centre_and_width(after, text))
    except ValueError:  # its powers are all 0
        filtered = None
    if filtered is None or filtered.weights.sum() < _DARK * spectrum.weights.sum():
        raise ValueError(f"light {text!r}: nothing of this light passes the filter; give another centre")
    return filtered


def _line(text: str) -> Spectrum:
    wavelength, _, after = text.partition("/")
    at = _length(wavelength, text)
    word, colon, number = after.partition(":")
    if not after:
        return spectral_line(at)
    if not colon:
        return spectral_line(at, _length(word, text))
    if word == "coherence":
        return spectral_line(at, coherence_length=_length(number, text))
    return spectral_line(at, _length(number, text), word)


def _white(after: str) -> Spectrum:
    if not after:
        return white()
    kelvin = re.fullmatch(r"(\d+\.?\d*)\s*[kK]", after)
    return black_body(float(kelvin[1])) if kelvin else illuminant(after)


def _centre_and_width(after: str, text: str) -> tuple[float, float]:
    centre, slash, width = after.partition("/")
    if not slash:
        raise ValueError(f"light {text!r}: give centre and width, as in 546nm/10nm")
    return _length(centre, text), _length(width, text)


def _length(number: str, text: str) -> float:
    match = _LENGTH.fullmatch(number.strip())
    value = float(match[1]) * _METRES.get(match[2], 1e-6) if match else 0.0
    if not (value > 0 and math.isfinite(value)):
        raise ValueError(f"light {text!r}: {number!r} is no positive length; give one with its unit, such as 546nm")
    return value
