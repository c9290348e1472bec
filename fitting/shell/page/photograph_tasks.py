"""What the worker does with a photograph: look at it, and measure it."""

import hashlib
import tomllib
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from importlib.resources import files as resources
from pathlib import Path
from typing import Any

import fitting
from fitting.parameters import Source, output, page, png, section
from fitting.shell import quantities
from fitting.shell.answer import as_png
from fitting.shell.fit_verb import ring_tables
from fitting.shell.page import pictures
from fitting.shell.page.settings import MASK, SCALE, Settings
from fitting.shell.scale_verb import points_of

Tell = Callable[[str, Any], None]
# The fit's steps as they are told.
PROGRESS, ANSWER = "progress", "answer"
_SAMPLE = "sample.png"


def sample() -> tuple[bytes, str, Settings]:
    """The sample photograph, its name, and what is known of it, as a person would type it."""
    data = resources("fitting") / "data"
    about = tomllib.loads((data / "sample.toml").read_text(encoding="utf-8"))["given"]
    units = {"wavelength": ("nm", 1e9), "pixel_size": ("um", 1e6)}
    texts = {name: value for name, value in about.items() if isinstance(value, str)}
    for name, (unit, factor) in units.items():
        texts |= {key: f"{about[key] * factor:.10g}{unit}" for key in (name, f"{name}_sd")}
    return (data / _SAMPLE).read_bytes(), _SAMPLE, Settings(texts)


def look(files: Path, tell: Tell, data: bytes, name: str, region: Mapping[str, float] | None = None) -> dict[str, Any]:
    """Size, preview and usable part of a photograph, which a `region` narrows. Raises ValueError for what is none."""
    del tell
    with _as_file(files, data, name) as path:
        photograph = fitting.read(path)
    rows, columns = photograph.mask.shape
    mask = photograph.mask & pictures.region_mask(region, (rows, columns))
    return {
        "rows": rows,
        "columns": columns,
        "usable": float(mask.mean()),
        "warnings": [str(text) for text in photograph.warnings],
        "pictures": {
            "photograph.jpg": pictures.preview(photograph.image),
            "region.jpg": pictures.preview(photograph.image, mask),
        },
    }


def measure(
    files: Path, tell: Tell, data: bytes, name: str, settings: Settings, region: Mapping[str, float] | None = None
) -> dict[str, bytes]:
    """Files of the result by name; the answer itself is told before they are drawn."""
    arguments = settings.arguments()
    added: dict[str, bytes] = {}
    with _as_file(files, data, name) as path:
        if region is not None:
            mask = pictures.region_mask(region, fitting.read(path).mask.shape)
            arguments["mask"] = mask
            added[MASK] = png.encode(mask.astype(float), 8)
        if settings.scale is not None:
            scale_file = files / SCALE
            added[SCALE] = output.json_text(dict(settings.scale)).encode()
            scale_file.write_bytes(added[SCALE])
            arguments["scale"] = scale_file
        result = fitting.fit(path, progress=lambda done, steps: tell(PROGRESS, (done, steps)), **arguments)
    tell(ANSWER, _answer(result))
    text = f"{result.report()}\n"
    added |= {"result.json": output.json_text(result.to_dict()).encode(), "report.txt": (text + section(text)).encode()}
    if result.status == "refused":
        return added
    picture = as_png(result.figure())
    command = "; ".join(settings.shell_lines(name))
    source = Source(name, hashlib.sha256(data).hexdigest())
    report_page = page(result, [source], command, {"Result": picture}, text)
    texts = {**ring_tables(result), "report.html": report_page}
    return {**added, **{file: table.encode() for file, table in texts.items()}, "result.png": picture}


def _answer(result: fitting.FitResult) -> dict[str, Any]:
    """What the page shows of a result: its numbers, and the rings over the photograph."""
    return {
        **result.to_dict(),
        "headline": result.headline(),
        "dominant": result.dominant(),
        "pictures": pictures.of_result(result),
    }


@contextmanager
def _as_file(files: Path, data: bytes, name: str) -> Generator[Path, None, None]:
    """The photograph as a file, for its time here alone; its name is cleaned of whatever could lead elsewhere."""
    path = files / name
    path.write_bytes(data)
    try:
        yield path
    finally:
        for leftover in files.glob("*"):
            leftover.unlink()


def scale(files: Path, tell: Tell, points: list[str], distance: str, distance_sd: str) -> dict[str, Any]:
    """The scale of two points and their distance, as texts. Raises ValueError for what is none."""
    del files, tell
    return fitting.scale(
        points=points_of(points),
        distance=quantities.positive_length(distance),
        distance_sd=quantities.length_sd(distance_sd) if distance_sd else None,
    ).to_dict()
