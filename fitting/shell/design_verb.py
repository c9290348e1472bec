"""The verb `design`: from ranges with units to a better bench, as text, scene file, table and picture."""

import csv
import io
from dataclasses import asdict
from pathlib import Path

import numpy as np

import newtonjax as nj
from fitting.designs import Design, design, with_field
from fitting.parameters import knobs
from fitting.report import output
from fitting.shell import assignments, session
from fitting.shell.answer import as_png
from fitting.shell.progress import steps
from newtonjax.benches import scene_text

_FILES = ("design.csv", "design.json", "design.png", "design.toml")
_OVER = 5


def run(path: Path, pixels: tuple, ranges: dict, limits: dict, search: dict, folder: Path | None, force: bool) -> int:
    """Search, print the design, write the files; the exit status."""
    session.prepare()
    session.keep_rays()
    scene, camera, camera_line = session.scene_and_camera(path, *pixels)
    files = output.files_of(folder, _FILES, force, (path,))
    units = {name: knob.unit for name, knob in with_field(camera, knobs(scene, camera)).items()}
    target = search["minimize"].removesuffix("_sd")
    vary = {name: assignments.span(name, text, units) for name, text in assignments.pairs("--vary", ranges["vary"])}
    over = None
    if ranges["over"]:
        low, high = assignments.span(target, ranges["over"], units)
        over = np.geomspace(low, high, _OVER) if low > 0 else np.linspace(low, high, _OVER)
    with steps("searching") as report:
        result = design(
            scene,
            camera,
            vary,
            target=target,
            known=assignments.known(ranges["known"], units),
            over=over,
            robust=search["robust"],
            choose={
                name: [assignments.number(name, value_text, units) for value_text in text.split(",")]
                for name, text in assignments.pairs("--choose", ranges["choose"])
            },
            pixels_per_fringe=limits["pixels_per_fringe"],
            fill=limits["fill"],
            rings=_rings(limits["rings"]),
            starts=search["starts"],
            report=lambda share: report(round(100 * share), 100),
        )
    print(f"sensor, {camera_line}\n{result}")
    if files:
        answer = {
            "scene_before": str(path),
            **{k: v for k, v in asdict(result).items() if k not in ("scene", "camera")},
        }
        answer |= {"shape": result.camera.shape, "pixel_size_m": float(result.camera.pixel_size)}
        bench = scene_text(result.scene, result.camera)
        for file, content in zip(
            files, (_csv(result), output.json_text(answer), as_png(figure(result)), bench), strict=True
        ):
            output.write(file, content, force)
    return 0


def _rings(text: str) -> tuple[float, float]:
    least, _, most = text.partition(":")
    try:
        return float(least or "1e-9"), float(most or "inf")
    except ValueError:
        raise ValueError(f"--rings {text!r}: give LEAST:MOST, such as 3:60, or 3:") from None


def _csv(result: Design) -> str:
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(["name", "unit", "designed", "before"])
    for name, value in result.values.items():
        writer.writerow([name, result.units[name], value, result.before[name]])
    writer.writerow([f"{result.target}_relative_sd", "", result.relative_sd, result.before_sd])
    return text.getvalue()


def figure(result: Design):
    """The image that the design takes, what its limits use, and what each start ended with."""
    from matplotlib.figure import Figure

    canvas = Figure(figsize=(11, 3.8), layout="constrained")
    image, limits, starts = canvas.subplots(1, 3)
    shape = result.camera.shape
    extent = 1e3 * float(result.camera.pixel_size) * np.array([-shape[1], shape[1], -shape[0], shape[0]]) / 2
    image.imshow(np.asarray(nj.render(result.scene, result.camera)), cmap="gray", extent=extent)
    image.set(title=f"the designed image, {shape[0]} x {shape[1]} pixels", xlabel="x on the screen [mm]")
    names = [name for name, used in result.used.items() if used > 0.01][::-1]
    used = [100 * result.used[name] for name in names]
    colors = ["tab:red" if value > 99.9 else "tab:blue" for value in used]
    limits.barh(range(len(names)), used, color=colors, height=0.6)
    limits.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    limits.axvline(100, color="0.4", lw=1)
    limits.set(title="limits", xlabel="used [%] (red: binds)", xlim=(0, 110))
    starts.semilogy(range(1, len(result.starts) + 1), result.starts, "o", color="tab:blue", label="ends of searches")
    if result.before_sd is not None:
        starts.axhline(result.before_sd, color="0.5", ls="--", label="the bench as it was")
    starts.axhline(result.relative_sd, color="tab:red", lw=1, label="the design")
    starts.set(title=f"expected relative sd of the {result.target}", xlabel="search, best first")
    starts.legend(fontsize=8)
    return canvas
