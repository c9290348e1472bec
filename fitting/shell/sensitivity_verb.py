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
    scene, camera, camera_line = session.scene_and_camera(path, *pixels)
    files = output.files_of(folder, (*_FILES, *(_OF_DRAWS if known else ())), force, (path,))
    bench_numbers = knobs(scene, camera)
    names = FREE if free is None else _names_of(free)
    deviations = assignments.known(known, {name: knob.unit for name, knob in bench_numbers.items()})
    if deviations:
        errors(bench_numbers, deviations, free_beside(target, names, bench_numbers), draws or _DRAWS)
    elif draws is not None:
        raise ValueError("--draws goes with --known NAME=SD, which says what is drawn")
    with progress("differentiating"):
        result = sensitivity(scene, camera, target, accuracy, names)
        pictured = [target, *(row.name for row in result.neglected[:_PICTURES])]
        images = derivative_images(scene, camera, pictured) if files else {}
    print(f"{camera_line}\n{result}")
    if files:
        answer = {"scene": str(path), **asdict(result)}
        _write(files, (_csv(result), output.json_text(answer), as_png(figure(result, images))), force)
    if deviations:
        with steps("fitting") as report:
            spreads = spread(
                scene,
                camera,
                deviations,
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


def _csv(result: Sensitivity) -> str:
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(["name", "unit", "value", f"slope_{result.unit or '1'}_per_unit", "tolerance"])
    for row in result.neglected:
        writer.writerow([row.name, row.unit, row.value, row.slope, "" if np.isinf(row.tolerance) else row.tolerance])
    return text.getvalue()


def _shares_csv(result: Spread) -> str:
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    index = ("first", "first_low", "first_high", "total", "total_low", "total_high")
    writer.writerow(["name", "unit", "sd", f"slope_sd_{result.unit or '1'}", *index])
    for share in result.shares:
        cells = (
            share.name,
            share.unit,
            share.sd,
            share.slope_sd,
            share.first,
            *share.first_range,
            share.total,
            *share.total_range,
        )
        writer.writerow(cells)
    return text.getvalue()


def figure(result: Sensitivity, images: dict[str, np.ndarray]):
    """How well each number must be known, and the derivatives of the image, each on its own scale."""
    from matplotlib.figure import Figure

    canvas = Figure(figsize=(11, 5.2), layout="constrained")
    grid = canvas.add_gridspec(2, 5)
    axes = canvas.add_subplot(grid[:, :2])
    # What may be wrong by its own size need not be known.
    rows = [row for row in result.neglected if row.tolerance < row.size][::-1]
    shares = np.array([row.tolerance / row.size for row in rows])
    axes.barh(range(len(rows)), np.log10(1 / shares), color="tab:blue", height=0.6)
    axes.set_yticks(range(len(rows)), [row.name.replace("_", " ") for row in rows])
    for k, row in enumerate(rows):
        size, unit = _readable(row.tolerance, row.unit)
        axes.annotate(f" ± {size:.3g} {unit}", (np.log10(1 / shares[k]), k), va="center", fontsize=8)
    axes.set_xlabel("digits to which it must be known\n(of a mrad for tilts of 0, of the wavelength for a gap)")
    axes.set_title(f"to know the {result.target} to {abs(result.accuracy / result.value):.2g} of it", fontsize=10)
    axes.set_xlim(0.0, 1.35 * max(np.log10(1 / shares), default=1.0))
    for place, (name, image) in enumerate(images.items()):
        axes = canvas.add_subplot(grid[place // 3, 2 + place % 3])
        edge = float(np.abs(image).max()) or 1.0
        axes.imshow(image, cmap="RdBu_r", vmin=-edge, vmax=edge)
        unit = next((row.unit for row in result.neglected if row.name == name), result.unit)
        per = f" per {unit or 'unit'}"
        axes.set_title(
            f"photoelectrons{per} of {name.replace('_', ' ')}\nred +{edge:.2g}, blue -{edge:.2g}", fontsize=7
        )
        axes.set_xticks([])
        axes.set_yticks([])
    return canvas


def spread_figure(result: Spread):
    """The draws beside the normal curve that slopes predict, and each number's share of their variance."""
    from matplotlib.figure import Figure

    canvas = Figure(figsize=(10, 4), layout="constrained")
    draws, shares = canvas.subplots(1, 2)
    unit = f" {result.unit}" if result.unit else ""
    draws.hist(result.found, bins=30, density=True, color="tab:blue", alpha=0.6, label="fits with errors drawn")
    if result.slope_sd > 0.02 * result.sd:
        low, high = draws.get_xlim()
        at = np.linspace(low, high, 400)
        bell = np.exp(-(((at - result.value) / result.slope_sd) ** 2) / 2) / (result.slope_sd * np.sqrt(2 * np.pi))
        draws.plot(at, bell, color="k", lw=1, label=f"by slopes alone, sd {result.slope_sd:.3g}{unit}")
    draws.axvline(result.value, color="tab:red", lw=1, label="the value in the image")
    draws.set(
        title=f"{len(result.found)} fits, sd {result.sd:.3g}{unit}",
        xlabel=f"{result.target} [{result.unit or 1}]",
        yticks=[],
    )
    draws.legend(fontsize=8)
    rows = result.shares[::-1]
    height = 0.35
    for shift, name, label in (
        (height / 2, "first", "first order: by itself"),
        (-height / 2, "total", "total: with what others add"),
    ):
        values = np.array([getattr(share, name) for share in rows])
        low, high = np.array([getattr(share, f"{name}_range") for share in rows]).T
        error = np.maximum([values - low, high - values], 0.0)
        shares.barh(np.arange(len(rows)) + shift, values, height, xerr=error, label=label)
    shares.set_yticks(
        range(len(rows)), [f"{share.name.replace('_', ' ')} ± {_with_unit(share.sd, share.unit)}" for share in rows]
    )
    shares.set(title="share of the variance (Sobol), bars 95 %", xlabel="share")
    shares.legend(fontsize=8)
    return canvas


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
