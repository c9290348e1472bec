"""What a fit returns: numbers with their standard deviations, the reason where there are none, and a report."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fitting.estimate import Fitted, pictures
from fitting.parameters import TABLE, Quantities
from fitting.photo import Photograph

# What makes a row of the budget smaller that is no given quantity's.
_ADVICE = {
    "noise": "more light, more frames, or a mask over what is not rings",
    "oblique view": "look along the normal",
    "distortion": "keep the rings in the middle of a longer focal length",
    "fifth order": "keep the rings in the middle of a longer focal length",
    "distortion's law": "keep the rings in the middle of a longer focal length",
    "contact": "press less, or leave the rings next to the disc out by a mask",
    "sodium's two lines": "fewer rings, or a laser",
    "view of a steep sphere": "give the bench as a scene",
    "model": "look at the residual picture; mask what is not of one ring system, or take more rings",
}
# Two-sided 95 % of a normal distribution.
_COVERAGE = 1.959963984540054


@dataclass(frozen=True)
class Parameter:
    """A number of the model, in SI units (`centre_px` in pixels): its value, standard deviation, and whether given."""

    value: float
    sd: float | None
    fixed: bool


@dataclass(frozen=True)
class Picture:
    """What the pictures are drawn from: the photograph, and of its fit what is asked for, at every pixel.

    `fitted`: the model image; `phase`: of the rings [turns]; `weights`: of the pixels.
    """

    photograph: Photograph
    found: Fitted

    @cached_property
    def fitted(self) -> np.ndarray:
        return pictures.fitted(self.found, self.phase)

    @cached_property
    def phase(self) -> np.ndarray:
        return pictures.phase(self.found)

    @cached_property
    def weights(self) -> np.ndarray:
        return pictures.weights(self.found, self.photograph.mask)


class Evidence(NamedTuple):
    """What a posterior is made of: the fit, what was given, the noise's variance per unit weight, the covariance."""

    found: Fitted
    known: Quantities
    variance: float
    covariance: np.ndarray


@dataclass(frozen=True)
class FitResult:
    """The outcome of `fitting.fit`. Lengths in metres; `None` is what the data do not give.

    - `status`: "ok", "no-scale" (rings, but a quantity is missing for a radius), "refused" or "not-converged";
      `message`: the reason.
    - `radius`, `radius_sd` (total), `radius_interval` (95 %), `radius_sd_noise`.
    - `fringe_scale_per_px2`: s²/(R λ) times the gap's index, what the image alone says; where there is a distortion,
      in the image's middle, or without a pixel size on the mean of the field; `fringe_scale_sd`: all but what is given.
    - `centre_px` (x, y); `gap`: at the centre, known modulo half a wavelength in the gap; `contact_radius`: of the disc
      that is pressed flat, None without.
    - `explained_variance`: share of the variance about a smooth background that the fringes explain.
    - `budget`: (source, standard deviation) of the measured quantity, `measured` by name.
    - `parameters` by name; `covariance` of those free, from noise, in the order `names`.
    - `residual` [rows, columns]: photograph less model, in units of the photograph's brightest pixels.
    - `evidence`: what `fitting.sample` draws from.
    """

    status: str
    message: str = ""
    measured: str = "radius"
    radius: float | None = None
    radius_sd: float | None = None
    radius_interval: tuple[float, float] | None = None
    radius_sd_noise: float | None = None
    fringe_scale_per_px2: float | None = None
    fringe_scale_sd: float | None = None
    centre_px: tuple[float, float] | None = None
    gap: float | None = None
    contact_radius: float | None = None
    explained_variance: float | None = None
    budget: list[tuple[str, float]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    model: dict[str, str] = field(default_factory=dict)
    seconds: float = 0.0
    parameters: dict[str, Parameter] = field(default_factory=dict)
    names: tuple[str, ...] = ()
    covariance: np.ndarray | None = None
    picture: Picture | None = None
    evidence: Evidence | None = field(default=None, repr=False)

    @property
    def residual(self) -> np.ndarray | None:
        """Photograph less model [rows, columns], None without a fit."""
        return None if self.picture is None else self.picture.photograph.image - self.picture.fitted

    def as_dict(self) -> dict:
        """The JSON object of the shell: units in the keys, null for what is not known."""
        radius, scale = TABLE["radius"], TABLE["fringe_scale"]
        answer = {
            "status": self.status,
            "message": self.message,
            radius.key(): self.radius,
            radius.key("sd"): self.radius_sd,
            radius.key("interval"): self.radius_interval and list(self.radius_interval),
            radius.key("sd_noise"): self.radius_sd_noise,
            scale.key(): self.fringe_scale_per_px2,
            scale.key("sd"): self.fringe_scale_sd,
            "centre_px": self.centre_px and list(self.centre_px),
            TABLE["gap"].key(): self.gap,
            TABLE["contact_radius"].key(): self.contact_radius,
            "explained_variance": self.explained_variance,
            "budget": [{"source": source, "sd_m": sd} for source, sd in self.budget],
            "warnings": list(self.warnings),
            "model": dict(self.model),
            "seconds": self.seconds,
        }
        if self.measured != "radius" and self.measured in self.parameters:
            spec, parameter = TABLE[self.measured], self.parameters[self.measured]
            answer |= {spec.key(): parameter.value, spec.key("sd"): parameter.sd}
        return {key: _finite(value) for key, value in answer.items()}

    def dominant(self) -> str:
        """The largest row of the budget, its share of the variance, and what would make it smaller; empty without."""
        total = sum(sd**2 for _, sd in self.budget)
        if not total:
            return ""
        source, sd = max(self.budget, key=lambda row: row[1])
        advice = TABLE[source].advice if source in TABLE else ""
        advice = _ADVICE.get(source) or advice or _ADVICE["model"]
        return f"largest: {source}, {sd**2 / total:.0%} of the variance; {advice}"

    def report(self) -> str:
        """The result as text: the answer, its budget, the parameters, and what was modelled."""
        lines = [f"[[Result]]  {self.status}" + (f": {self.message}" if self.message else "")]
        answer = self.parameters.get(self.measured)
        if self.status == "ok" and answer and answer.sd is not None:
            low, high = self.radius_interval or interval(answer.value, answer.sd)
            unit = TABLE[self.measured].in_unit
            lines += [
                f"    {self.measured} = {answer.value:.8g} +/- {answer.sd:.2g}{unit} "
                f"({answer.sd / answer.value:.2g} relative; 95 %: {low:.8g} to {high:.8g})"
            ]
        if self.fringe_scale_per_px2 is not None:
            sd = f" +/- {self.fringe_scale_sd:.2g}" if self.fringe_scale_sd is not None else ""
            lines += [f"    fringe scale n s²/(R λ) = {self.fringe_scale_per_px2:.8g}{sd} per px²"]
        if self.explained_variance is not None:
            lines += [f"    fringes explain {self.explained_variance:.1%} of the variance"]
        if self.budget:
            lines += ["[[Budget]]  standard deviations of " + self.measured]
            width = max(len(source) for source, _ in self.budget)
            lines += [f"    {source:<{width}} {sd:.3g}" for source, sd in self.budget]
            lines += [f"    {self.dominant()}"] if self.dominant() else []
        if self.parameters:
            lines += ["[[Parameters]]"]
            width = max(len(name) for name in self.parameters)
            for name, parameter in self.parameters.items():
                sd = "(given)" if parameter.fixed else f"+/- {parameter.sd:.2g}" if parameter.sd is not None else ""
                sd = f"+/- {parameter.sd:.2g} (given)" if parameter.fixed and parameter.sd else sd
                lines += [f"    {name:<{width}} {parameter.value:.8g} {sd}"]
        if self.model:
            lines += ["[[Model]]"] + [f"    {part:<12} {why}" for part, why in self.model.items()]
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)


def _finite(value):
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def interval(value: float, sd: float) -> tuple[float, float]:
    """95 %, normal in the logarithm: a length cannot be negative, and s²/(k λ) is a product."""
    factor = float(np.exp(_COVERAGE * sd / value))
    return value / factor, value * factor
