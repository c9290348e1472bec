"""The text of a form: words of ISO 10110-5, terms, radii, budget."""

from typing import Any

import numpy as np

from fitting.parameters import with_sd

_NAMES = {
    2: "tilt along columns", 3: "tilt along rows", 4: "power", 5: "astigmatism at 45°", 6: "astigmatism at 0°",
    7: "coma along rows", 8: "coma along columns", 9: "trefoil", 10: "trefoil", 11: "spherical",
}  # fmt: skip


def lines_of(form: Any) -> list[str]:
    """The lines of the report of a `Form` below its status."""
    return [*_pupil_lines(form), *_word_lines(form), *_radius_lines(form), *_term_lines(form), *_budget_lines(form)]


def _pupil_lines(form: Any) -> list[str]:
    x, y, radius = form.pupil or (0.0, 0.0, 0.0)
    steps = ", ".join(f"{step:.3f}" for step in form.steps or ())
    return [
        f"    pupil        centre ({x:.1f}, {y:.1f}), radius {with_sd(radius, form.pupil_sd, 'px')}",
        f"    fringes      {form.fringes or 0.0:.1f} over the pupil; the model explains {form.explained or 0.0:.1%} of "
        "the image variance" + ("" if form.agreement is None else f", {form.agreement:.0%} of the places confirm it"),
        *([] if form.steps is None else [f"    steps        {steps} fringe spacings, of {len(form.steps)} frames"]),
    ]


def _word_lines(form: Any) -> list[str]:
    words = form.indications
    wavelength = form.lengths.wavelength
    base = "wavelength not given" if wavelength is None else f"wavelength {wavelength * 1e9:.6g} nm"
    count = len(form.coefficients or ())
    lines = [f"[[ISO 10110-5]]  in fringe spacings ({base}), {count} terms"]
    a, b, c = (words[name][0] for name in "ABC")
    rms = ", ".join(f"{name} {words[name][0]:.3g}" for name in ("RMSt", "RMSi", "RMSa"))
    lines.append(f"    3/{a:.3g}({b:.3g}/{c:.3g})  {rms}")
    for name, (value, sd) in words.items():
        # Terms that are not reported have no deviation to show.
        if sd == 0:
            continue
        height = "" if wavelength is None else f"   {with_sd(value * wavelength * 5e8, sd * wavelength * 5e8, 'nm')}"
        lines.append(f"    {name:<12} {with_sd(value, sd)}{height}")
    return lines


def _radius_lines(form: Any) -> list[str]:
    rows = [form.parameters[name] for name in ("radius_along", "radius_across") if name in form.parameters]
    if form.curvatures is None:
        return []
    curvature = form.curvatures
    lines = ["[[Radii]]  of the mean curvatures over the pupil"]
    lines += [f"    {row.name:<16} {with_sd(row.value, row.sd, row.unit)}" for row in rows]
    for name, value, sd in (
        ("curvature along", curvature.along, curvature.along_sd),
        ("curvature across", curvature.across, curvature.across_sd),
    ):
        lines.append(f"    {name:<16} {with_sd(value, sd, '1/m')} against the reference")
    angle = with_sd(float(np.degrees(curvature.axis)), float(np.degrees(curvature.axis_sd)), "°")
    return [*lines, f"    axis             {angle} from the rows towards the columns"]


def _term_lines(form: Any) -> list[str]:
    lines = ["[[Terms]]  Zernike, Noll's order, rms, in fringe spacings"]
    for term, (value, sd) in enumerate(zip(form.coefficients or (), form.sds or (), strict=True), 1):
        if term > 1:
            lines.append(f"    Z{term:<11} {with_sd(value, sd):<24} {_NAMES.get(term, '')}".rstrip())
    return lines


def _budget_lines(form: Any) -> list[str]:
    lines = ["[[Budget]]  standard deviations of power, astigmatism and irregularity (rms), in fringe spacings"]
    for source, row in form.budget.items():
        lines.append(f"    {source:<16} " + "  ".join(f"{row[name]:.2g}".ljust(9) for name in row))
    return lines
