"""The verb `sensitivity`: how well each number of a bench must be known, as text, table and picture."""

import csv
import io
from dataclasses import asdict
from pathlib import Path

import numpy as np

from fitting.parameters import knobs
from fitting.report import output
from fitting.shell import assignments, session
from fitting.shell.answer import as_png
from fitting.shell.progress import progress, steps
from fitting.studies import FREE, Sensitivity, Spread, derivative_images, errors, free_beside, sensitivity, spread

_FILES = ("sensitivity.csv", "sensitivity.json", "sensitivity.png")
_OF_DRAWS = ("spread.csv", "spread.json", "spread.png", "spread.nc")
_PICTURES = 5
_DRAWS = 128


def run(
    path: Path,
    pixels: tuple,
    target: str,
    accuracy: float,
    free: list[str] | None,
    known: list[str],
    draws: int | None,
    folder: Path | None,
    force: bool,
) -> int:
    """Compute, print the tables, write the files; the exit status."""
    session.prepare()
    session.keep_rays()
    scene, camera, said = session.scene_and_camera(path, *pixels)
    files = output.files_of(folder, (*_FILES, *(_OF_DRAWS if known else ())), force, (path,))
    there = knobs(scene, camera)
    names = FREE if free is None else _names_of(free)
    given = assignments.known(known, {name: knob.unit for name, knob in there.items()})
    if given:
        errors(there, given, free_beside(target, names, there), draws or _DRAWS)
    elif draws is not None:
        raise ValueError("--draws goes with --known NAME=SD, which says what is drawn")
    with progress("differentiating"):
        found = sensitivity(scene, camera, target, accuracy, names)
        shown = [target, *(one.name for one in found.neglected[:_PICTURES])]
        images = derivative_images(scene, camera, shown) if files else {}
    print(f"{said}\n{found}")
    if files:
        answer = {"scene": str(path), **asdict(found)}
        _write(files, (_csv(found), output.json_text(answer), as_png(figure(found, images))), force)
    if given:
        with steps("fitting") as report:
            spreads = spread(
                scene,
                camera,
                given,
                target,
                names,
                draws=draws or _DRAWS,
                keep=files[-1] if files else None,
                report=report,
            )
        print(spreads)
        if files:
            answer = {"scene": str(path), **asdict(spreads)}
            tables = _shares_csv(spreads), output.json_text(answer), as_png(spread_figure(spreads))
            _write(files[len(_FILES) :], tables, force)
    return 0


def _write(files: list[Path], contents: tuple[str | bytes, ...], force: bool) -> None:
    for file, content in zip(files, contents, strict=False):
        output.write(file, content, force)


def _names_of(texts: list[str]) -> list[str]:
    """Names out of an option's texts, which may hold several with commas."""
    return [name for text in texts for name in text.split(",")]


def _csv(found: Sensitivity) -> str:
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(["name", "unit", "value", f"slope_{found.unit or '1'}_per_unit", "tolerance"])
    for one in found.neglected:
        writer.writerow([one.name, one.unit, one.value, one.slope, "" if np.isinf(one.tolerance) else one.tolerance])
    return text.getvalue()


def _shares_csv(found: Spread) -> str:
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    index = ("first", "first_low", "first_high", "total", "total_low", "total_high")
    writer.writerow(["name", "unit", "sd", f"slope_sd_{found.unit or '1'}", *index])
    for one in found.shares:
        row = (one.name, one.unit, one.sd, one.slope_sd, one.first, *one.first_range, one.total, *one.total_range)
        writer.writerow(row)
    return text.getvalue()


def figure(found: Sensitivity, images: dict[str, np.ndarray]):
    """How well each number must be known, and the derivatives of the image, each on its own scale."""
    from matplotlib.figure import Figure

    made = Figure(figsize=(11, 5.2), layout="constrained")
    grid = made.add_gridspec(2, 5)
    axes = made.add_subplot(grid[:, :2])
    # What may be wrong by its own size need not be known.
    rows = [one for one in found.neglected if one.tolerance < one.size][::-1]
    shares = np.array([one.tolerance / one.size for one in rows])
    axes.barh(range(len(rows)), np.log10(1 / shares), color="tab:blue", height=0.6)
    axes.set_yticks(range(len(rows)), [one.name.replace("_", " ") for one in rows])
    for k, one in enumerate(rows):
        size, unit = _readable(one.tolerance, one.unit)
        axes.annotate(f" ± {size:.3g} {unit}", (np.log10(1 / shares[k]), k), va="center", fontsize=8)
    axes.set_xlabel("digits to which it must be known\n(of a mrad for tilts of 0, of the wavelength for a gap)")
    axes.set_title(f"to know the {found.target} to {abs(found.accuracy / found.value):.2g} of it", fontsize=10)
    axes.set_xlim(0.0, 1.35 * max(np.log10(1 / shares), default=1.0))
    for place, (name, image) in enumerate(images.items()):
        axes = made.add_subplot(grid[place // 3, 2 + place % 3])
        edge = float(np.abs(image).max()) or 1.0
        axes.imshow(image, cmap="RdBu_r", vmin=-edge, vmax=edge)
        unit = next((one.unit for one in found.neglected if one.name == name), found.unit)
        per = f" per {unit or 'unit'}"
        axes.set_title(
            f"photoelectrons{per} of {name.replace('_', ' ')}\nred +{edge:.2g}, blue -{edge:.2g}", fontsize=7
        )
        axes.set_xticks([])
        axes.set_yticks([])
    return made


def spread_figure(found: Spread):
    """The draws beside the normal curve that slopes predict, and each number's share of their variance."""
    from matplotlib.figure import Figure

    made = Figure(figsize=(10, 4), layout="constrained")
    draws, shares = made.subplots(1, 2)
    unit = f" {found.unit}" if found.unit else ""
    draws.hist(found.found, bins=30, density=True, color="tab:blue", alpha=0.6, label="fits with errors drawn")
    if found.slope_sd > 0.02 * found.sd:
        low, high = draws.get_xlim()
        at = np.linspace(low, high, 400)
        bell = np.exp(-(((at - found.value) / found.slope_sd) ** 2) / 2) / (found.slope_sd * np.sqrt(2 * np.pi))
        draws.plot(at, bell, color="k", lw=1, label=f"by slopes alone, sd {found.slope_sd:.3g}{unit}")
    draws.axvline(found.value, color="tab:red", lw=1, label="the value in the image")
    draws.set(
        title=f"{len(found.found)} fits, sd {found.sd:.3g}{unit}",
        xlabel=f"{found.target} [{found.unit or 1}]",
        yticks=[],
    )
    draws.legend(fontsize=8)
    rows = found.shares[::-1]
    height = 0.35
    for shift, name, label in (
        (height / 2, "first", "first order: by itself"),
        (-height / 2, "total", "total: with what others add"),
    ):
        values = np.array([getattr(one, name) for one in rows])
        low, high = np.array([getattr(one, f"{name}_range") for one in rows]).T
        error = np.maximum([values - low, high - values], 0.0)
        shares.barh(np.arange(len(rows)) + shift, values, height, xerr=error, label=label)
    shares.set_yticks(
        range(len(rows)), [f"{one.name.replace('_', ' ')} ± {_with_unit(one.sd, one.unit)}" for one in rows]
    )
    shares.set(title="share of the variance (Sobol), bars 95 %", xlabel="share")
    shares.legend(fontsize=8)
    return made


def _with_unit(value: float, unit: str) -> str:
    size, name = _readable(value, unit)
    return f"{size:.3g} {name}".rstrip()


def _readable(value: float, unit: str) -> tuple[float, str]:
    """A length in nm to m, an angle in mrad, other units as they are."""
    if unit == "m":
        for factor, name in ((1e9, "nm"), (1e6, "um"), (1e3, "mm")):
            if value * factor < 1000:
                return value * factor, name
    return (value * 1e3, "mrad") if unit == "rad" else (value, unit)
