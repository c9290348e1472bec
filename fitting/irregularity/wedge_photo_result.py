"""What a photograph of straight fringes returns: their spacing, and the wedge's angle and thickness."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from fitting.irregularity.disc import Pupil
from fitting.parameters import AbstractMeasurement, Origin, Parameter, between, common_from, parameters_from, with_sd
from fitting.photo import Photograph

# Attributes with a standard deviation by their units, in the order of the report; those that have an interval.
UNITS = {
    "spacing_px": "px", "direction": "rad", "distortion": "", "spacing": "m", "wedge_angle": "rad", "thickness": "m",
}  # fmt: skip
_WITH_INTERVAL = ("spacing", "wedge_angle", "thickness")
_NUMBERS = ("change", "fringes", "explained", "agreement", "inflation", "coefficients")


def _key(name: str, part: str = "") -> str:
    """A number's key in JSON, such as spacing_sd_px."""
    stem = name.removesuffix("_px")
    return "_".join(filter(None, (stem, part, UNITS[name])))


@dataclass(frozen=True, repr=False, eq=False)
class WedgePhoto(AbstractMeasurement):
    """The outcome of `fitting.wedge_photo`. Lengths in metres, angles in radians; None is what is not determined.

    - `status`: "ok", "no-scale" where the spacing in pixels is the answer, "refused", or "not-converged".
    - `spacing_px` of the fringes in the middle of the picture, across them, and `direction` across them, from the
      picture's rows towards its columns; `spacing` [m]; `wedge_angle`; `thickness` at the end of the length that was
      given; each with its standard deviation `..._sd`, the last three with a 95 % interval `..._interval`.
    - `distortion`: κ of r (1 + κ r²), r in half diagonals of the picture; `change`: by what share the fringes change
      from the middle to the rim beside it, at most.
    - `budget`: (source, relative standard deviation of the last of spacing, angle and thickness that there is).
    - `fringes` over the pupil; `explained`: share of the picture's variance; `agreement`: of the places whose own
      phase confirms the fringes; `inflation`: of the noise's variance; `pupil`: the circle that was used;
      `coefficients`: of the fringes' phase in it, Zernike terms [turns], as those of `fitting.form`.
    """

    status: str
    message: str = ""
    spacing_px: float | None = None
    spacing_px_sd: float | None = None
    direction: float | None = None
    direction_sd: float | None = None
    distortion: float | None = None
    distortion_sd: float | None = None
    spacing: float | None = None
    spacing_sd: float | None = None
    spacing_interval: tuple[float, float] | None = None
    wedge_angle: float | None = None
    wedge_angle_sd: float | None = None
    wedge_angle_interval: tuple[float, float] | None = None
    thickness: float | None = None
    thickness_sd: float | None = None
    thickness_interval: tuple[float, float] | None = None
    change: float | None = None
    budget: list[tuple[str, float]] = field(default_factory=list)
    fringes: float | None = None
    explained: float | None = None
    agreement: float | None = None
    inflation: float | None = None
    pupil: Pupil | None = None
    coefficients: list[float] | None = None
    warnings: list[str] = field(default_factory=list)
    model: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, Parameter] = field(default_factory=dict)
    photograph: Photograph | None = None
    origin: Origin | None = None

    @property
    def measured(self) -> str:
        """The name of the answer: thickness, wedge_angle, spacing or spacing_px, the first that there is."""
        names = ("thickness", "wedge_angle", "spacing", "spacing_px")
        return next((name for name in names if getattr(self, name) is not None), "wedge_angle")

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the shell: units in the keys, null for what is not determined."""
        numbers: dict[str, Any] = {}
        for name in UNITS:
            numbers |= {_key(name): getattr(self, name), _key(name, "sd"): getattr(self, f"{name}_sd")}
            if name in _WITH_INTERVAL:
                ends = getattr(self, f"{name}_interval")
                numbers[_key(name, "interval")] = ends and list(ends)
        return {
            "status": self.status,
            "message": str(self.message),
            "measured": self.measured,
            **numbers,
            **{name: getattr(self, name) for name in _NUMBERS},
            "budget": [{"source": source, "relative_sd": sd} for source, sd in self.budget],
            "pupil_px": self.pupil and list(self.pupil),
            "model": dict(self.model),
            "parameters": {name: asdict(parameter) for name, parameter in self.parameters.items()},
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "WedgePhoto":
        """The result that `to_dict` was called of."""
        status, message, warnings, origin = common_from(saved)
        numbers: dict[str, Any] = {}
        for name in UNITS:
            numbers |= {name: saved[_key(name)], f"{name}_sd": saved[_key(name, "sd")]}
            if name in _WITH_INTERVAL:
                ends = saved[_key(name, "interval")]
                numbers[f"{name}_interval"] = ends and tuple(ends)
        return cls(
            status,
            message,
            **numbers,
            **{name: saved[name] for name in _NUMBERS},
            budget=[(row["source"], row["relative_sd"]) for row in saved["budget"]],
            pupil=saved["pupil_px"] and Pupil(*saved["pupil_px"]),
            warnings=warnings,
            model=dict(saved["model"]),
            parameters=parameters_from(saved),
            origin=origin,
        )

    def figure(self, ax=None) -> Any:
        """The photograph with the middles of the dark fringes as fitted; the reason where there are none.

        Raises ValueError where there is no photograph, as in a loaded result.
        """
        from fitting.irregularity import figure

        if self.photograph is None:
            raise ValueError(f"there is nothing to draw ({self.status}); a loaded result has no photograph")
        if self.coefficients is None or self.pupil is None:
            return self._reason_figure()
        if ax is None:
            from matplotlib.figure import Figure

            rows, columns = self.photograph.image.shape
            ax = Figure(figsize=(8, 8 * rows / columns + 0.5), layout="constrained").subplots()
        figure.draw_fringes(self.photograph, self.pupil, np.array(self.coefficients), ax)
        ax.set_title(self.headline())
        return ax.figure

    def headline(self) -> str:
        """The answer in one line, or why there is none."""
        value, sd = getattr(self, self.measured), getattr(self, f"{self.measured}_sd")
        if value is None:
            return super().headline()
        return f"{_words(self.measured)} = {with_sd(value, sd, UNITS[self.measured])}"

    def budgets(self) -> dict[str, list[tuple[str, float]]]:
        """The budget of the answer, relative to it."""
        return {f"{_words(self.measured)}, relative": self.budget} if self.budget else {}

    def report(self) -> str:
        """The result as text: the answers, their budget, what the fringes are."""
        lines = [f"[[Result]]  {self.status}" + (f": {self.message}" if self.message else "")]
        lines += [self._line(name, unit) for name, unit in UNITS.items() if getattr(self, name) is not None]
        if self.budget:
            lines += [f"[[Budget]]  relative standard deviations of the {_words(self.measured)}"]
            lines += [f"    {source:<12} {sd:.2g}" for source, sd in self.budget]
        if self.model:
            lines += ["[[Model]]"] + [f"    {part:<12} {why}" for part, why in self.model.items()]
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)

    def _line(self, name: str, unit: str) -> str:
        value, sd = getattr(self, name), getattr(self, f"{name}_sd")
        text = f"    {_words(name)} = {with_sd(value, sd, unit)}"
        if (ends := getattr(self, f"{name}_interval", None)) is not None:
            text += f" (95 %: {between(ends, sd, unit)})"
        return text


def _words(name: str) -> str:
    """A number's name in a sentence."""
    return name.removesuffix("_px").replace("_", " ")
