"""Named lamps and lines: wavelengths that need not be typed."""

from collections.abc import Callable
from typing import Any, NamedTuple

from fitting.shell.quantities import positive_length
from newtonjax.scene import BANDS, LAMPS, LINES

# What the mean of a doublet may be off its middle [m]: lines that a dense vapour makes equal, or 2 : 1 of a thin one,
# evenly spread between.
_MEAN_SD = {"sodium": 0.0575e-9, "mercury-yellow": 0.2e-9}
# Of a lamp of several lines, over their rms distance from their mean: what it makes of the doublets above.
_SD_OF_LINES = 0.2
# Lines further apart than this [m] are colours of their own.
_APART = 5e-9
# In standard air [m]. "sodium" is the middle of its doublet.
_SODIUM = 589.294
_INDEX_OF_AIR = 1.00028


class Wavelength(NamedTuple):
    """A wavelength as it was given [m]; `line` is True for the air wavelength of a named line.

    `words`: as it was typed. `sd`: standard deviation of a doublet's mean, by its lines' unknown intensities; None for
    anything else. `lamp`: the words for a light of lines so far apart that a photograph shows several; the wavelength
    is their mean.
    """

    given: float
    line: bool
    words: str
    sd: float | None = None
    lamp: str | None = None

    def within(self, ambient_index: float) -> float:
        """The wavelength for a scene whose surroundings have this index [m].

        Where air counts as 1 (the default) its wavelength is a named line's air value; where the surroundings have
        the index of air, or more, indices are absolute and the vacuum value, 2.8e-4 longer, belongs to them.
        """
        return self.given * _INDEX_OF_AIR if self.line and ambient_index > 1.0001 else self.given


def in_air(wavelength: Wavelength | None, sd: float | str | None) -> dict[str, float | str | None]:
    """The arguments `wavelength` and `wavelength_sd` of a verb without a scene; a line's own sd where none is given."""
    if wavelength is None:
        return {"wavelength": None, "wavelength_sd": sd}
    return {"wavelength": wavelength.within(1.0), "wavelength_sd": wavelength.sd if sd is None else sd}


def wavelength(text: str) -> Wavelength:
    """A wavelength such as "589.3nm", a line or lamp such as "sodium", or the mean of any light that `lamp` reads.

    Raises ValueError, in one line, for what is neither.
    """
    name = text.strip().lower()
    if name == "sodium":
        return Wavelength(_SODIUM * 1e-9, True, text, _MEAN_SD[name])
    if name in LINES:
        return Wavelength(LINES[name] * 1e-9, True, text, _MEAN_SD.get(name))
    if name in LAMPS or any(sign in name for sign in ":/") or name.endswith(".csv"):
        return _mean(text)
    try:
        return Wavelength(positive_length(text), False, text)
    except ValueError as error:
        lines = f", or a line: {', '.join(['sodium', *LINES, 'hene'])}"
        raise ValueError(f"{error}{'' if any(map(str.isdigit, text)) else lines}") from None


def _mean(text: str) -> Wavelength:
    """Of a lamp: the mean of its lines by wavenumber, in air for named lamps."""
    import numpy as np

    from newtonjax.scene import lamp  # JAX, which the help does without

    spectrum = lamp(text)
    mean = float(spectrum.wavelength)
    spread = float(np.sqrt((spectrum.shares * (spectrum.wavelengths - mean) ** 2).sum()))
    is_named = text.partition(":")[0].strip().lower() in LAMPS
    lines = np.asarray(spectrum.wavelengths)
    several = is_named and float(np.ptp(lines)) > _APART
    return Wavelength(mean, is_named, text, _SD_OF_LINES * spread or None, text if several else None)


def light(text: str) -> str:
    """The words for a light, checked. Raises ValueError, in one line, for what names none."""
    from newtonjax.scene import lamp

    if text.strip().lower() == "unknown":
        raise ValueError(
            "'unknown' is for several photographs of one set-up: `newtonjax together A.tif B.tif --light unknown`; "
            "give the lamp, or leave --light out for the fringe scale"
        )
    lamp(text)
    return text


# What the shell completes, by what reads the option.
NAMES: dict[Callable[[str], Any], tuple[str, ...]] = {
    wavelength: ("sodium", *LINES, "hene"),
    light: (*LAMPS, *LINES, *BANDS),
}
