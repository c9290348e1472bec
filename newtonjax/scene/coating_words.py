"""Coatings by a few words: layers from the glass on, or a mirror."""

import re

from newtonjax.numerics import Scalar, shown
from newtonjax.scene.coatings import Coating
from newtonjax.scene.glasses import refractive_index

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_INDEX = re.compile(rf"({_NUMBER})(?:\s*\+\s*({_NUMBER})\s*[ij])?")
_LENGTH = re.compile(f"({_NUMBER})" + r"\s*(nm|um|\N{MICRO SIGN}m|\N{GREEK SMALL LETTER MU}m|m)")
_METRES = {"nm": 1e-9, "m": 1.0}
GRAMMAR = (
    "layers from the glass on, index:thickness each, such as '1.38:107nm', 'MgF2:107nm' or "
    "'1.5:20nm, 0.05+3.1i:30nm', or a mirror such as 'mirror:90%' or 'mirror:0.9'"
)


def coating(text: str, wavelength: Scalar = 589.3e-9) -> Coating:
    """The coating that a few words name.

    - `1.38:107nm`: a layer of an index and a thickness; `1.46:20nm, 0.05+3.1i:30nm`: several, that on the glass first,
      absorbing ones with a complex index.
    - `MgF2:107nm`: of matter that `refractive_index` names, at the `wavelength` in vacuum [m].
    - `mirror:90%`, `mirror:0.9`: a reflectance.

    Raises ValueError for what is none of these.
    """
    if not isinstance(text, str):
        raise ValueError(f"coating is {shown(text)}; allowed: {GRAMMAR}")
    name, colon, share = text.partition(":")
    if colon and name.strip().lower() == "mirror":
        return Coating(reflectance=_share(share.strip(), text))
    layers = [_layer(part, text, wavelength) for part in text.split(",")]
    thicknesses, indices, extinctions = zip(*layers, strict=True)
    return Coating(thicknesses, indices, extinctions if any(extinctions) else None)


def _share(word: str, text: str) -> float:
    is_percent = word.endswith("%")
    match = re.fullmatch(_NUMBER, word.removesuffix("%").strip())
    if match is None:
        raise ValueError(f"coating {text!r}: {word!r} is no reflectance; give it as in mirror:90% or mirror:0.9")
    return float(match[0]) * (0.01 if is_percent else 1.0)


def _layer(part: str, text: str, wavelength: Scalar) -> tuple[Scalar, Scalar, float]:
    """Thickness, index and extinction."""
    name, colon, thickness = (word.strip() for word in part.partition(":"))
    number, length = _INDEX.fullmatch(name), _LENGTH.fullmatch(thickness)
    if not (colon and length and (number or name[:1].isalpha())):
        raise ValueError(f"coating {shown(text)}: {shown(part.strip())} is no layer; allowed: {GRAMMAR}")
    metres = float(length[1]) * _METRES.get(length[2], 1e-6)
    if number is None:
        return metres, refractive_index(name, wavelength), 0.0
    return metres, float(number[1]), float(number[2] or 0.0)
