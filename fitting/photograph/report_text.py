"""The text of a fit's result: the answer, its budget, the parameters, and what was modelled."""

from typing import Any

from fitting.model import ADVICE, AXIS, RADIAL
from fitting.parameters import TABLE, Parameter, between, interval, length_unit, text_of, with_sd
from fitting.photograph.ring_radii import KINDS

# What makes a row of the budget smaller that is no given quantity's.
_ADVICE = {
    "noise": "more light, more frames, or a mask over what is not rings",
    "sodium's two lines": "fewer rings, or a laser",
    "blur": "sharpen the focus, and hold camera and lens still",
    "glass looked through": "give the bench as a scene, with the index and thickness of its glass",
    "whole waves of the gap": "hold the gap where it is known (--fix gap=0nm)",
    "light behind few fringes": "more rings in the picture, or more even light",
    "form": "turn the lens and take another photograph, mask its rim, or measure its form by itself",
    "view or form": "look along the normal, or take another photograph with the lens turned by 90 degrees",
    "weak light": "light the field evenly, or mask the part that is no sphere's",
    "prior tension": "photograph a grid with this camera (--scale-from), or turn the lens and take another picture",
    "further lines": "give light in place of the wavelength (--light), or photograph behind a filter",
    "lamp and camera curves": "measure the curves of this lamp and camera, or use a lamp of lines (--light mercury)",
    "model": "look at the residual picture; mask what is not of one ring system, or take more rings",
}
# A distortion of fewer standard deviations says nothing of where its axis is.
_SEEN = 2.0


def report_of(self: Any) -> str:
    """The report of a `FitResult`, section by section."""
    model = [f"    {part:<12} {why}" for part, why in self.model.items()]
    warnings = [f"    {text}" for text in self.warnings]
    sections = (
        _answer(self),
        _budget(self),
        _parameters(self.parameters),
        _rings(self),
        ["[[Model]]", *model] if model else [],
        _priors(self),
        ["[[Warnings]]", *warnings] if warnings else [],
    )
    return "\n".join(line for section in sections for line in section)


def headline_of(self: Any) -> str:
    """The answer in one line, or why there is none."""
    answer = self.parameters.get(self.measured)
    if self.status == "ok" and answer is not None and answer.sd is not None:
        return f"{self.measured} = {text_of(answer)}"
    if self.status == "no-scale" and self.fringe_scale_per_px2 is not None:
        scale = with_sd(self.fringe_scale_per_px2, self.fringe_scale_sd, "per px²")
        return f"fringe scale n s²/(R λ) = {scale}: {self.message}"
    return f"{self.status}: {self.message}" if self.message else self.status


def dominant_of(self: Any) -> str:
    """The largest row of the budget, its share of the variance, and what would make it smaller; empty without."""
    total = sum(sd**2 for _, sd in self.budget)
    if not total:
        return ""
    source, sd = max(self.budget, key=lambda row: row[1])
    advice = TABLE[source].advice if source in TABLE else ""
    advice = _ADVICE.get(source) or ADVICE.get(source) or advice or _ADVICE["model"]
    return f"largest: {source}, {sd**2 / total:.0%} of the variance; {advice}"


def _answer(result: Any) -> list[str]:
    lines = [f"[[Result]]  {result.status}" + (f": {result.message}" if result.message else "")]
    answer = result.parameters.get(result.measured)
    if result.status == "ok" and answer and answer.sd is not None:
        headline, interval_95 = headline_of(result), result.radius_interval or interval(answer.value, answer.sd)
        ends = between(interval_95, answer.sd, TABLE[result.measured].unit)
        lines.append(f"    {headline} ({answer.sd / answer.value:.2g} relative; 95 %: {ends})")
        lines += [f"    {words}"] if (words := unstated_of(result)) else []
    if result.fringe_scale_per_px2 is not None:
        scale = with_sd(result.fringe_scale_per_px2, result.fringe_scale_sd, "per px²")
        lines.append(f"    fringe scale n s²/(R λ) = {scale}")
    if result.explained_variance is not None:
        lines.append(f"    fringes explain {result.explained_variance:.1%} of the variance")
    return lines


def unstated_of(self: Any) -> str:
    """That the deviation lacks quantities which have none, and what a percent of each would be; empty without."""
    answer = self.parameters.get(self.measured)
    if not self.per_percent or answer is None:
        return ""
    by_change = sorted(self.per_percent.items(), key=lambda row: -row[1])
    names = " and ".join(name for name, _ in by_change)
    effects = (
        f"1 % of {name} is {100 * change / answer.value:.3g} % of {self.measured}, "
        + with_sd(float(f"{change:.2g}"), None, answer.unit)
        for name, change in by_change
    )
    have = "have" if len(by_change) > 1 else "has"
    counted = [source for source, _ in self.budget if source in TABLE and not TABLE[source].in_fit]
    scope = "does not include all" if counted else "is of the image alone"
    return f"± {scope}: {names} {have} no standard deviation; {'; '.join(effects)}"


def _budget(result: Any) -> list[str]:
    if not result.budget:
        return []
    answer = result.parameters.get(result.measured)
    factor, unit = length_unit(None if answer is None else answer.value, unit=TABLE[result.measured].unit)
    width = max(len(source) for source, _ in result.budget)
    rows = [f"    {source:<{width}} {sd * factor:.2g}" for source, sd in result.budget if sd]
    largest = dominant_of(result)
    title = f"[[Budget]]  standard deviations of {result.measured}" + (f" [{unit}]" if unit else "")
    return [title, *rows, *([f"    {largest}"] if largest else [])]


def _parameters(parameters: dict[str, Parameter]) -> list[str]:
    """The numbers by name, but for the axis of a distortion that the image does not show."""
    is_distorted = any(name in parameters and _is_seen(parameters[name]) for name in RADIAL)
    printed = {name: number for name, number in parameters.items() if is_distorted or name not in AXIS}
    if not printed:
        return []
    lines, width = ["[[Parameters]]"], max(len(name) for name in printed)
    for name, number in printed.items():
        text = text_of(number).removesuffix(" px" if name.endswith("_px") else "")
        lines.append(f"    {name:<{width}} {text}" + (" (given)" if number.fixed else ""))
    return lines


def _is_seen(number: Parameter) -> bool:
    return abs(number.value) > _SEEN * (number.sd or 0.0)


def _rings(result: Any) -> list[str]:
    """The first two rings of each kind and the last one."""
    lines = []
    for kind in KINDS:
        rows = [ring for ring in result.rings if ring.kind == kind]
        ends = rows if len(rows) < 4 else [*rows[:2], rows[-1]]
        factor, unit = length_unit(ends[-1].radius if ends else None)
        sizes = (
            with_sd(ring.radius_px, ring.radius_px_sd, "px")
            if ring.radius is None
            else with_sd(factor * ring.radius, factor * (ring.radius_sd or 0.0), unit)
            for ring in ends
        )
        by_order = "; ".join(f"{ring.order}: {size}" for ring, size in zip(ends, sizes, strict=True))
        lines += [f"    {len(rows)} {kind}: {by_order}"] if rows else []
    return ["[[Rings]]  radius by order, distortion and view undone", *lines] if lines else []


def _priors(result: Any) -> list[str]:
    """What was taken for granted before the image was seen, a line for each reason."""
    alike: dict[tuple, list[str]] = {}
    for name, prior in result.priors.items():
        alike.setdefault((prior["value"], prior["sd"], prior["reason"]), []).append(name)
    lines = [f"    {', '.join(names)}: {value:.4g} ± {sd:.2g}, {why}" for (value, sd, why), names in alike.items()]
    return ["[[Priors]]", *lines] if lines else []
