"""What a picture of fringes says of the form of a surface."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fitting.irregularity.curvatures import QUADRATIC, Curvatures, curvatures
from fitting.irregularity.disc import Pupil
from fitting.irregularity.indications import indications
from fitting.irregularity.maps import map_csv
from fitting.parameters import AbstractMeasurement, Origin, Parameter, common_from, output, with_sd
from fitting.photo import Photograph

# Two-sided 95 % of a normal distribution.
_COVERAGE = 1.959963984540054
_NUMBERS = ("fringes", "explained", "agreement", "inflation", "sign", "pupil_sd", "budget", "rivals")
# Of files of earlier versions these are not there.
_OF_FRAMES = ("steps", "contradictions")


class Lengths(NamedTuple):
    """What was given of the light and of the pixels, in metres, None where it was not; `reference`: a radius."""

    wavelength: float | None = None
    wavelength_sd: float | None = None
    pixel_size: float | None = None
    pixel_size_sd: float | None = None
    reference: float | None = None


NO_LENGTHS = Lengths()


@dataclass(frozen=True, repr=False, eq=False)
class Form(AbstractMeasurement):
    """The form of a surface against its reference, in a pupil.

    - `status`: "ok", "refused" or "not-converged" with a `message`.
    - `coefficients` [terms]: of Zernike terms in Noll's order, rms normalization, in fringe spacings of the gap (turns
      of phase, λ/2 each); u runs with the columns, v with the rows. `covariance` [terms, terms].
    - `sign`: the term whose sign was given, None where the sign of all is open; power is then shown positive.
    - `budget`: sources of uncertainty, each with the standard deviations that it makes of power, astigmatism and
      irregularity, in fringe spacings.
    - `pupil`: centre and radius [px]; `pupil_sd` of its rim.
    - `fringes`: over the pupil; `explained`: share of the image's variance; `agreement`: share of places whose own
      phase confirms the form; `inflation`: of the noise's variance over that of white noise.
    - `rivals`: other forms that explain the picture as well, each [terms].
    - `steps` [frames]: of the phase from the first frame, turns, where frames were given; `contradictions` [frames]:
      chi-squared a term between the form of each frame and that of all others.
    """

    status: str
    message: str = ""
    coefficients: list[float] | None = None
    covariance: list[list[float]] | None = None
    quadratic_covariance: list[list[float]] | None = None
    budget: dict[str, dict[str, float]] = field(default_factory=dict)
    fringes: float | None = None
    explained: float | None = None
    agreement: float | None = None
    inflation: float | None = None
    sign: int | None = None
    pupil: Pupil | None = None
    pupil_sd: float | None = None
    rivals: list[list[float]] = field(default_factory=list)
    lengths: Lengths = NO_LENGTHS
    warnings: list[str] = field(default_factory=list)
    steps: list[float] | None = None
    contradictions: list[float] = field(default_factory=list)
    photograph: Photograph | None = None
    reading: int = 1
    origin: Origin | None = None

    @property
    def sds(self) -> list[float] | None:
        """Standard deviations of the coefficients."""
        return None if self.covariance is None else np.sqrt(np.diag(np.array(self.covariance))).tolist()

    def interval(self, term: int) -> tuple[float, float]:
        """The 95 % interval of a term, by its number, in fringe spacings. Raises ValueError without one."""
        if self.coefficients is None or self.sds is None or not 1 <= term <= len(self.coefficients):
            raise ValueError(f"term {term} was not measured; terms 1 to {len(self.coefficients or ())} were")
        value, reach = self.coefficients[term - 1], _COVERAGE * self.sds[term - 1]
        return value - reach, value + reach

    @property
    def indications(self) -> dict[str, tuple[float, float]]:
        """A, B, C, RMSt, RMSi, RMSa of ISO 10110-5 with their sd, in fringe spacings; empty for a refusal."""
        if self.coefficients is None or self.covariance is None:
            return {}
        return indications(np.array(self.coefficients), np.array(self.covariance))

    @property
    def curvatures(self) -> Curvatures | None:
        """Curvatures against the reference along two axes [1/m]; None without wavelength and pixel size."""
        lengths = self.lengths
        if self.coefficients is None or self.pupil is None or lengths.wavelength is None or lengths.pixel_size is None:
            return None
        radius = self.pupil.radius * lengths.pixel_size
        light, pixel = (lengths.wavelength_sd or 0.0, lengths.pixel_size_sd or 0.0)
        relative = np.hypot(light / lengths.wavelength, 2 * pixel / lengths.pixel_size)
        quadratic = np.array(self.coefficients)[list(QUADRATIC)]
        covariance = np.array(self.quadratic_covariance)
        return curvatures(quadratic, covariance, lengths.wavelength / radius**2, float(relative))

    @property
    def parameters(self) -> dict[str, Parameter]:
        """What was measured, by name: z2, z3, ..; A, B, C, RMSt, RMSi, RMSa; radii; empty for a refusal."""
        if self.coefficients is None or self.sds is None:
            return {}
        rows = {
            f"z{term}": (value, sd, "fringe")
            for term, (value, sd) in enumerate(zip(self.coefficients, self.sds, strict=True), 1)
            if term > 1
        }
        rows |= {name: (value, sd, "fringe") for name, (value, sd) in self.indications.items()}
        if self.curvatures is not None:
            rows |= _of_radii(self.curvatures, self.lengths.reference, self.sign is not None)
        return {name: Parameter(float(value), float(sd), False, name, unit) for name, (value, sd, unit) in rows.items()}

    @property
    def model(self) -> dict[str, str]:
        """What was fitted; empty for a refusal."""
        if self.coefficients is None:
            return {}
        sign = "open: power is shown positive" if self.sign is None else f"given by term {self.sign}"
        terms = f"{len(self.coefficients)} Zernike terms, Noll's order, rms"
        return {"form": f"{terms}, in fringe spacings", "sign": sign}

    def headline(self) -> str:
        """Power and irregularity of ISO 10110-5 in one line, or why there are none."""
        if self.status != "ok" or not self.indications:
            return super().headline()
        words = (("power A", "A"), ("irregularity B", "B"))
        return ", ".join(f"{word} = {with_sd(*self.indications[name])}" for word, name in words) + " fringe spacings"

    def budgets(self) -> dict[str, list[tuple[str, float]]]:
        """Those of power, astigmatism and irregularity."""
        names = next(iter(self.budget.values()), {})
        rows = {name: [(source, row[name]) for source, row in self.budget.items()] for name in names}
        return {f"{name}, rms [fringe spacings]": row for name, row in rows.items()}

    def tried_figure(self) -> Any:
        """The picture with the aperture in which fringes were looked for; None without one."""
        from fitting.irregularity import figure

        if self.photograph is None or self.pupil is None:
            return None
        return figure.of_aperture(self.photograph, self.pupil.reduced(self.reading))

    def alternatives(self) -> list[tuple[str, str]]:
        """Forms that explain the picture as well."""
        rows = [", ".join(f"{value:.3g}" for value in rival) for rival in self.rivals]
        return [(f"other form {number}", f"terms {row}") for number, row in enumerate(rows, 1)]

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the shell; heights are in fringe spacings, `nm_per_fringe` makes them nanometres."""
        wavelength = self.lengths.wavelength
        return {
            "status": self.status,
            "message": str(self.message),
            "order": "Noll, rms",
            "coefficients_fringe": self.coefficients,
            "covariance_fringe2": self.covariance,
            "quadratic_covariance_fringe2": self.quadratic_covariance,
            "nm_per_fringe": wavelength and wavelength / 2 * 1e9,
            "pupil_px": self.pupil and list(self.pupil),
            "lengths_m": self.lengths._asdict(),
            **{name: getattr(self, name) for name in (*_NUMBERS, *_OF_FRAMES)},
            "parameters": {name: asdict(parameter) for name, parameter in self.parameters.items()},
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "Form":
        """The form that `to_dict` was called of."""
        status, message, warnings, origin = common_from(saved)
        return cls(
            status,
            message,
            coefficients=saved["coefficients_fringe"],
            covariance=saved["covariance_fringe2"],
            quadratic_covariance=saved["quadratic_covariance_fringe2"],
            pupil=saved["pupil_px"] and Pupil(*saved["pupil_px"]),
            lengths=Lengths(**saved["lengths_m"]),
            warnings=warnings,
            origin=origin,
            **{name: saved[name] for name in _NUMBERS},
            **{name: saved[name] for name in _OF_FRAMES if name in saved},
        )

    def save_map(self, path: str | Path, *, force: bool = False) -> None:
        """Write the departure from the best sphere as CSV: column, row, height and its standard deviation.

        Raises ValueError for a refusal, FileExistsError for a file that is there already, unless `force`.
        """
        output.write(Path(path), self.map_csv(), force)

    def map_csv(self) -> str:
        """The text of `save_map`. Raises ValueError for a refusal."""
        return map_csv(*self._map_arguments())

    def figure(self, ax=None) -> Any:
        """The photograph, the fitted dark fringes over it, the departure from the best sphere and its sd.

        With `ax` the photograph with its fringes alone, drawn into these axes. Raises ValueError where there is no
        photograph, as in a loaded result.
        """
        from fitting.irregularity import figure

        if self.photograph is None:
            raise ValueError(f"there is nothing to draw ({self.status}); a loaded result has no photograph")
        if self.coefficients is None or self.pupil is None:
            return self._reason_figure()
        if ax is None:
            pupil, form, covariance, scale = self._map_arguments()
            drawing = figure.of_form(self.photograph, pupil.reduced(self.reading), form, covariance, scale)
            figure.count_pixels(drawing.axes[:4], self.reading)
            return drawing
        figure.draw_fringes(self.photograph, self.pupil.reduced(self.reading), np.array(self.coefficients), ax)
        figure.count_pixels([ax], self.reading)
        return ax.figure

    def report(self) -> str:
        """The form as text."""
        from fitting.irregularity.report import lines_of

        lines = [f"[[Form]]  {self.status}" + (f": {self.message}" if self.message else "")]
        lines += lines_of(self) if self.coefficients is not None else []
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)

    def _map_arguments(self) -> tuple[Pupil, np.ndarray, np.ndarray, float | None]:
        if self.coefficients is None or self.covariance is None or self.pupil is None:
            raise ValueError(f"there is no form ({self.status}): {self.message}")
        wavelength = self.lengths.wavelength
        scale = wavelength and wavelength / 2 * 1e9
        return self.pupil, np.array(self.coefficients), np.array(self.covariance), scale


def _of_radii(curvature: Curvatures, reference: float | None, signed: bool) -> dict[str, tuple[float, float, str]]:
    """Curvatures against the reference, and the surface's own radii where the sign lets these follow."""
    base = 0.0 if reference is None else 1 / reference
    rows = {
        "curvature_along": (curvature.along, curvature.along_sd, "1/m"),
        "curvature_across": (curvature.across, curvature.across_sd, "1/m"),
        "axis": (curvature.axis, curvature.axis_sd, "rad"),
    }
    for name, value, sd in (
        ("radius_along", curvature.along, curvature.along_sd),
        ("radius_across", curvature.across, curvature.across_sd),
    ):
        curvature_of_surface = base + value
        # Of a curvature within three deviations of zero no radius is said.
        if (signed or reference is None) and abs(curvature_of_surface) > 3 * sd:
            rows[name] = (1 / curvature_of_surface, sd / curvature_of_surface**2, "m")
    return rows
