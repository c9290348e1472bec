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
from fitting.photograph import expected_rings
from fitting.shell import quantities
from fitting.shell.answer import as_png
from fitting.shell.fit_verb import ring_tables
from fitting.shell.page import pictures
from fitting.shell.page.pictures import Region
from fitting.shell.page.settings import MASK, SCALE, Settings
from fitting.shell.scale_verb import points_of

Tell = Callable[[str, Any], None]
# What is told while a photograph is measured: steps of the fit, its numbers, and each picture of it when it is drawn.
PROGRESS, ANSWER, PICTURE = "progress", "answer", "picture"
# What the page shows beside the result's own numbers: its methods that say something.
ADDED = ("headline", "dominant", "unstated")
_SAMPLE = "sample.png"
# Of a ring on the screen.
_CORNERS = 120


def sample() -> tuple[bytes, str, Settings]:
    """The sample photograph, its name, and what is known of it, as a person would type it."""
    data = resources("fitting") / "data"
    about = tomllib.loads((data / "sample.toml").read_text(encoding="utf-8"))["given"]
    units = {"wavelength": ("nm", 1e9), "pixel_size": ("um", 1e6)}
    texts = {name: value for name, value in about.items() if isinstance(value, str)}
    for name, (unit, factor) in units.items():
        texts |= {key: f"{about[key] * factor:.10g}{unit}" for key in (name, f"{name}_sd")}
    return (data / _SAMPLE).read_bytes(), _SAMPLE, Settings(texts)


def look(files: Path, tell: Tell, data: bytes, name: str, region: Region = ()) -> dict[str, Any]:
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
    files: Path, tell: Tell, data: bytes, name: str, settings: Settings, region: Region = ()
) -> dict[str, bytes]:
    """Files of the result by name; its numbers are told before, then its pictures, each with its name."""
    arguments = settings.arguments()
    added: dict[str, bytes] = {}
    with _as_file(files, data, name) as path:
        if region:
            mask = pictures.region_mask(region, fitting.read(path).mask.shape)
            arguments["mask"] = mask
            added[MASK] = png.encode(mask.astype(float), 8)
        if settings.scale is not None:
            scale_file = files / SCALE
            added[SCALE] = output.json_text(dict(settings.scale)).encode()
            scale_file.write_bytes(added[SCALE])
            arguments["scale"] = scale_file
        result = fitting.fit(path, progress=lambda done, steps: tell(PROGRESS, (done, steps)), **arguments)
    words = {name: getattr(result, name)() for name in ADDED}
    tell(ANSWER, result.to_dict() | words)
    for picture in pictures.of_result(result):
        tell(PICTURE, picture)
    text = f"{result.report()}\n"
    added |= {"result.json": output.json_text(result.to_dict()).encode(), "report.txt": (text + section(text)).encode()}
    if result.status == "refused":
        return added
    figure = as_png(result.figure())
    command = "; ".join(settings.shell_lines(name))
    source = Source(name, hashlib.sha256(data).hexdigest())
    report_page = page(result, [source], command, {"Result": figure}, text)
    texts = {**ring_tables(result), "report.html": report_page}
    return {**added, **{file: table.encode() for file, table in texts.items()}, "result.png": figure}


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


def expected(files: Path, tell: Tell, shape: tuple[int, int], numbers: Mapping[str, Any]) -> str:
    """The dark rings that are expected of some numbers, as the path of an SVG whose units are pixels.

    `numbers`: arguments of `fitting.photograph.expected_rings`. Raises ValueError where no such rings can be drawn.
    """
    del files, tell
    lines = expected_rings(shape, **numbers)
    return " ".join(
        "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in [*line[: -1 : max(1, len(line) // _CORNERS)], line[-1]])
        for line in lines
    )


def reticle(files: Path, tell: Tell, data: bytes, name: str, kind: str, size: str, size_sd: str) -> dict[str, Any]:
    """The scale of a photograph of a "division", "ruler" or "disc_diameter" of known size, its words and its picture.

    Raises ValueError for texts that are no sizes, and where no such thing is found.
    """
    del tell
    known: dict[str, Any] = {kind: quantities.positive_length(size)}
    known |= {f"{kind}_sd": quantities.length_sd(size_sd)} if size_sd else {}
    with _as_file(files, data, name) as path:
        result = fitting.scale(path, **known)
    if result.status != "ok":
        raise ValueError(result.message)
    words = ". ".join([result.headline(), *map(str, result.warnings)])
    return {"scale": result.to_dict(), "words": words, "picture": pictures.figure_jpeg(result.figure())}


def scale(files: Path, tell: Tell, points: list[str], distance: str, distance_sd: str) -> dict[str, Any]:
    """The scale of two points and their distance, as texts. Raises ValueError for what is none."""
    del files, tell
    return fitting.scale(
        points=points_of(points),
        distance=quantities.positive_length(distance),
        distance_sd=quantities.length_sd(distance_sd) if distance_sd else None,
    ).to_dict()
