"""Named lamps and lines: wavelengths that need not be typed."""

from typing import NamedTuple

from fitting.shell.quantities import positive_length

# What the mean of a doublet may be off its middle [m]: lines that a dense vapour makes equal, or 2 : 1 of a thin one,
# evenly spread between.
_MEAN_SD = {"sodium": 0.0575e-9, "mercury-yellow": 0.2e-9}
# In standard air [m] (NIST Atomic Spectra Database; the laser's vacuum line 632.9912 nm of the mise en pratique of the
# metre over 1.000277). "sodium" and "mercury-yellow" are the middles of their doublets.
_IN_AIR = {
    "sodium": 589.294e-9,
    "sodium-d1": 589.5924e-9,
    "sodium-d2": 588.9950e-9,
    "hene": 632.8162e-9,
    "mercury-violet": 404.656e-9,
    "mercury-blue": 435.833e-9,
    "mercury-green": 546.075e-9,
    "mercury-yellow": 578.013e-9,
    "cadmium-red": 643.847e-9,
    "hydrogen-red": 656.28e-9,
    "hydrogen-blue": 486.13e-9,
    "helium-yellow": 587.562e-9,
}
_INDEX_OF_AIR = 1.00028


class Wavelength(NamedTuple):
    """A wavelength as it was given [m]; `line` is True for the air wavelength of a named line.

    `sd`: standard deviation of a doublet's mean, by its lines' unknown intensities; None for anything else.
    """

    given: float
    line: bool
    sd: float | None = None

    def within(self, ambient_index: float) -> float:
        """The wavelength for a scene whose surroundings have this index [m].

        Where air counts as 1 (the default) its wavelength is a named line's air value; where the surroundings have
        the index of air, or more, indices are absolute and the vacuum value, 2.8e-4 longer, belongs to them.
        """
        return self.given * _INDEX_OF_AIR if self.line and ambient_index > 1.0001 else self.given


def wavelength(text: str) -> Wavelength:
    """A wavelength such as "589.3nm", or the name of a line or lamp such as "sodium".

    Raises ValueError, in one line, for what is neither.
    """
    name = text.strip().lower()
    if name in _IN_AIR:
        return Wavelength(_IN_AIR[name], line=True, sd=_MEAN_SD.get(name))
    try:
        return Wavelength(positive_length(text), line=False)
    except ValueError as error:
        hint = "" if any(character.isdigit() for character in text) else f", or a line: {', '.join(_IN_AIR)}"
        raise ValueError(f"{error}{hint}") from None
