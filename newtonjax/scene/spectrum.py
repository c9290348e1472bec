"""Spectra: lines and bands with weights, and the coherence that light of them has."""

from dataclasses import replace
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Complex, Float

from newtonjax.numerics import Scalar, as_complex, as_vector, is_concrete, namespace, require, require_choice
from newtonjax.scene.limits import WAVELENGTH

# Profiles of lines: for each the field of this name, and its Fourier transform in `Lines.fading`.
PROFILES = ("gaussian", "lorentzian", "triangle")
_LENGTHS = f"positive lengths, {WAVELENGTH.words}"
_WIDTHS = "a width of 0 m or more for each line, below its wavelength"
_POWERS = "a power of 0 or more for each line, not all of them 0"


def _numbers(values) -> Any:
    return None if values is None else as_vector(values)


class Spectrum(eqx.Module):
    """Lines and bands of light. Every number may be traced; how many lines there are is not.

    - `wavelengths`: of the lines in vacuum [m], [lines].
    - `weights`: their powers, in any unit, [lines]; `shares` are these over their sum.
    - `gaussian`, `lorentzian`, `triangle`: full widths at half maximum of the lines [m], [lines], of profiles in
      wavenumber; None where no line has such a width. A line that has several is their convolution. A triangle is what
      interpolation between samples makes of each of them.

    Raises ValueError for wavelengths, weights or widths that no light has.
    """

    wavelengths: Float[Any, " lines"] = eqx.field(converter=as_vector)
    weights: Float[Any, " lines"] = eqx.field(converter=as_vector)
    gaussian: Float[Any, " lines"] | None = eqx.field(converter=_numbers, default=None)
    lorentzian: Float[Any, " lines"] | None = eqx.field(converter=_numbers, default=None)
    triangle: Float[Any, " lines"] | None = eqx.field(converter=_numbers, default=None)

    def __check_init__(self):
        require("wavelengths", self.wavelengths, _LENGTHS, WAVELENGTH.holds)
        require("weights", self.weights, _POWERS, lambda w: np.isfinite(w).all() and (w >= 0).all() and w.any())
        sizes = {np.shape(self.wavelengths), np.shape(self.weights)}
        for name in PROFILES:
            if (width := getattr(self, name)) is not None:
                require(name, width, _WIDTHS, lambda w: w >= 0)
                sizes.add(np.shape(width))
                if is_concrete(width, self.wavelengths) and sizes == {np.shape(self.wavelengths)}:
                    require(name, width, _WIDTHS, lambda w: (w >= 0) & (w < np.asarray(self.wavelengths)))
        if len(sizes) > 1 or len(next(iter(sizes))) != 1 or not np.size(self.wavelengths):
            raise ValueError(
                f"wavelengths, weights and widths have shapes {sorted(sizes)}; allowed: one number each for every line"
            )

    @property
    def shares(self) -> Float[Any, " lines"]:
        """Of the lines in the power of the light."""
        return self.weights / self.weights.sum()

    @property
    def wavelength(self) -> Scalar:
        """Of the mean wavenumber [m], in vacuum: about it the phase of the coherence has no slope."""
        return 1 / (self.shares / self.wavelengths).sum()

    def is_sharp_line(self) -> bool:
        """Whether it is one line without a width."""
        return len(self.weights) == 1 and all(getattr(self, name) is None for name in PROFILES)

    def filtered(self, centre: Scalar, width: Scalar) -> "Spectrum":
        """Behind a filter of Gaussian transmittance with a centre and a full width at half maximum [m].

        A Gaussian line behind it is a narrower Gaussian line; other profiles keep their shape, so they should be
        narrower than the filter.
        """
        line_width = 0.0 if self.gaussian is None else self.gaussian
        total = line_width**2 + width**2
        steepness = 4 * np.log(2)
        passed = namespace(self, centre, width).exp(-steepness * (self.wavelengths - centre) ** 2 / total)
        passed = passed * (width**2 / total) ** 0.5
        middle = (self.wavelengths * width**2 + centre * line_width**2) / total
        gaussian = None if self.gaussian is None else self.gaussian * (width**2 / total) ** 0.5
        return replace(self, wavelengths=middle, weights=self.weights * passed, gaussian=gaussian)

    def weighted(self, response: Float[Any, " lines"]) -> "Spectrum":
        """As a detector of this response to each line takes it."""
        return replace(self, weights=self.weights * response)

    def coherence(self, path: Float[Any, "..."]) -> Complex[Any, "..."]:
        """The complex degree of coherence at a path difference [m], over the carrier of `wavelength`.

        The Fourier transform of the spectrum (Born and Wolf, Principles of Optics, section 10.3): its modulus is the
        visibility of two equal beams.
        """
        return lines_of(self).coherence(path / self.wavelength)


class Lines(NamedTuple):
    """A spectrum over its mean wavenumber, [lines] each.

    - `shares`: of the power; `ratios`: wavenumbers over the mean one.
    - `gaussian`, `lorentzian`, `triangle`: full widths at half maximum over the mean wavenumber; or None.
    """

    shares: Float[Any, " lines"]
    ratios: Float[Any, " lines"]
    gaussian: Float[Any, " lines"] | None
    lorentzian: Float[Any, " lines"] | None
    triangle: Float[Any, " lines"] | None

    @property
    def widths(self) -> tuple[Float[Any, " lines"] | None, ...]:
        """By profile, in the order of `PROFILES`."""
        return tuple(getattr(self, name) for name in PROFILES)

    @property
    def are_sharp(self) -> bool:
        """Whether no line has a width."""
        return all(width is None for width in self.widths)

    def coherence(self, turns: Float[Any, "..."]) -> Complex[Any, "..."]:
        """Σ share · fading · e^{2πi (ratio - 1) turns}, at path differences in turns of the carrier."""
        xp = namespace(self, turns)
        phase = 2 * np.pi * (_beside(self.ratios, turns) - 1) * turns
        power = _beside(self.shares, turns) * self.fading(turns)
        return as_complex((power * xp.cos(phase)).sum(0)) + 1j * as_complex((power * xp.sin(phase)).sum(0))

    def fading(self, turns: Float[Any, "..."]) -> Any:
        """Fourier transforms of the profiles [lines, ...], 1 at the path difference 0; 1.0 of sharp lines.

        Even in the path difference, and smooth in the widths at a width of 0.
        """
        xp, fading = namespace(self, turns), 1.0
        if self.gaussian is not None:
            reduced = _beside(self.gaussian, turns) * turns
            fading = fading * xp.exp(-(np.pi**2 / (4 * np.log(2))) * (reduced * reduced))
        if self.lorentzian is not None:
            fading = fading * xp.exp(-np.pi * _beside(self.lorentzian, turns) * abs(turns))
        if self.triangle is not None:
            fading = fading * xp.sinc(_beside(self.triangle, turns) * turns) ** 2
        return fading


def _beside(table, turns):
    """A number for each line, before the axes of the path differences."""
    return table.reshape(*table.shape, *[1] * (1 + np.ndim(turns) - table.ndim))


def lines_of(spectrum: Spectrum) -> Lines:
    """The spectrum over its mean wavenumber. Of a width Δλ at λ the wavenumber has Δλ/λ²."""
    ratios = spectrum.wavelength / spectrum.wavelengths

    def reduced(width):
        return None if width is None else width / spectrum.wavelengths * ratios

    return Lines(spectrum.shares, ratios, *(reduced(getattr(spectrum, name)) for name in PROFILES))


def spectral_line(
    wavelength: Scalar,
    width: Scalar | None = None,
    shape: str = "gaussian",
    *,
    coherence_length: Scalar | None = None,
) -> Spectrum:
    """One line, sharp unless it has a width: full width at half maximum [m], or coherence length [m].

    - `shape`: "gaussian" or "lorentzian".
    - `coherence_length`: path difference at which the visibility is 1/e.

    Raises ValueError for another shape, and where both a width and a coherence length are given.
    """
    require_choice("shape", shape, ("gaussian", "lorentzian"))
    if width is not None and coherence_length is not None:
        raise ValueError("width and coherence_length of one line; give one of them")
    if coherence_length is not None:
        require("coherence_length", coherence_length, "a positive length in metres", lambda v: v > 0)
        narrowing = 1.0 if shape == "lorentzian" else 2 * np.log(2) ** 0.5
        width = narrowing * wavelength**2 / (np.pi * coherence_length)
    widths = {} if width is None else {shape: (width,)}
    return Spectrum((wavelength,), (1.0,), **widths)


def sampled_spectrum(wavelengths: Float[Any, " samples"], powers: Float[Any, " samples"]) -> Spectrum:
    """A continuous spectrum from samples of its power per wavelength, linear in between, and to 0 beyond the ends.

    - `wavelengths`: ascending, in vacuum [m]; `powers`: in any unit.

    Raises ValueError for wavelengths that do not ascend, and as `Spectrum`.
    """
    xp, at = namespace(wavelengths, powers), as_vector(wavelengths)
    require("wavelengths", at, f"two or more, ascending, {WAVELENGTH.words}", _ascends)
    steps = xp.diff(at)
    edges = xp.concatenate([steps[:1], steps, steps[-1:]])
    widths = (edges[1:] + edges[:-1]) / 2
    samples = f"a number for each of the {len(widths)} wavelengths"
    require("powers", powers, samples, lambda values: np.shape(values) == np.shape(widths))
    return Spectrum(at, as_vector(powers) * widths, triangle=widths)


def _ascends(at: np.ndarray) -> bool:
    return np.ndim(at) == 1 and len(at) > 1 and bool(np.all(WAVELENGTH.holds(at))) and bool(np.all(np.diff(at) > 0))
