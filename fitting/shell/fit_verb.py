"""The verbs `fit` and `demo`: from a photograph and options to an answer on the screen and in files."""

import shlex
import sys
import tomllib
from collections.abc import Mapping
from functools import partial
from importlib.resources import as_file, files
from itertools import count
from pathlib import Path
from typing import Any

import fitting
from fitting.parameters import PART_OPTIONS, with_sd
from fitting.shell import assignments, session, stopping
from fitting.shell.answer import Extras, Outputs, as_png
from fitting.shell.fit_arguments import FitOptions, arguments_of
from fitting.shell.options import MODEL_OPTIONS
from fitting.shell.progress import progress
from fitting.shell.report_page import Measured

# Files that `newtonjax rings` reads, by the kind of their rings.
_RING_TABLES = {"dark": "dark_rings.csv", "bright": "bright_rings.csv"}
# Pictures of a chain, by their titles in the page.
_OF_CHAIN = {"corner.png": "Posterior", "trace.png": "Chain"}


def model_of(values: dict[str, Any]) -> dict[str, Any]:
    """What is asked of the rings' model, of the values of `options.with_model_options`: fields of `FitOptions`."""
    parts = {name: values[name] for name in PART_OPTIONS if values[name] is not None}
    readers = {"prior": assignments.priors, "fix": assignments.held, "start": assignments.start}
    named = {name: read(values[name]) if values[name] else {} for name, read in readers.items()}
    return {"parts": parts, **{name: values[name] for name in MODEL_OPTIONS}, **named}


def run(photo: Path, options: FitOptions, outputs: Outputs) -> int:
    """Fit, report, write; the exit status."""
    pictures = tuple(_OF_CHAIN) if options.mcmc else ()
    outputs = outputs._replace(more=(*_RING_TABLES.values(), *pictures))
    _check(photo, options, outputs)
    with progress(f"fitting {photo.name}"):
        session.prepare()
        arguments = arguments_of(options)
        result = fitting.fit(photo, **arguments)
    measured = [Measured(photo, arguments)]
    if not options.mcmc or result.evidence is None:
        advice = _scale_advice(photo, options) if result.status == "no-scale" else ""
        return outputs.write(result, measured, Extras(text=advice, files=partial(ring_tables, result)))
    picture = outputs.keep(result)
    chain = _chain(result, outputs, options.of_chain)
    outputs = outputs._replace(force=True)  # of what is there now the files of this run are replaced
    # The draws are in the chain's own file.
    posterior = {key: value for key, value in chain.to_dict().items() if key not in ("draws", "log_prob")}
    extras = Extras({"posterior": posterior}, "\n" + chain.report(), partial(_files, result, chain), _OF_CHAIN)
    return outputs.write(result, measured, extras, picture)


def _chain(result, outputs: Outputs, settings: Mapping[str, Any]):
    """Draws from the posterior; in a folder every step is kept, and a chain that was broken off goes on.

    With --force that of another fit is put beside: it may have taken hours.
    """
    from fitting.sampling import WRITING, OtherChainError

    file = None if outputs.folder is None else outputs.folder / "chain.h5"
    if file is not None:
        stopping.keep(file, "the same command with --force goes on with it", WRITING)
    try:
        return fitting.sample(result, path=file, progress=True, **settings)
    except OtherChainError:
        if file is None or not outputs.force:
            raise
        beside = next(path for n in count(1) if not (path := file.with_name(f"chain-{n}.h5")).exists())
        file.rename(beside)
        print(f"newtonjax: the draws of another fit are kept in {beside}", file=sys.stderr)
        return fitting.sample(result, path=file, progress=True, **settings)


def _files(result, chain) -> dict[str, bytes | str]:
    drawings = {"corner.png": as_png(chain.figure()), "trace.png": as_png(chain.trace_figure())}
    return {**drawings, **ring_tables(result)}


def ring_tables(result) -> dict[str, str]:
    """Radii of the rings by order as CSV, by the name of the file; empty without rings."""
    return {name: _csv(result.ring_table(kind)) for kind, name in _RING_TABLES.items() if result.rings}


def _scale_advice(photo: Path, options: FitOptions) -> str:
    """How to get the pixel size that a radius needs; nothing where it was given."""
    if options.pixel_size is not None or options.scale_from is not None:
        return ""
    lamp = "--wavelength sodium"
    if options.lamp is not None:
        lamp = f"--light {shlex.quote(options.lamp)}"
    elif options.wavelength is not None:
        lamp = f"--wavelength {shlex.quote(options.wavelength.words)}"
    fit = f"newtonjax fit {shlex.quote(str(photo))} {lamp}"
    view = "" if options.view is None else f" --view {options.view}"
    return (
        "\n[[Next]]  for a radius: photograph a ruler at the same place, then\n"
        "    newtonjax scale ruler.jpg --ruler 1mm --json scale.json\n"
        f"    {fit}{view} --scale-from scale.json\n"
        "or read two of its lines in pixels in place of the first command:\n"
        "    newtonjax scale --point 120,340 --point 980,352 --distance 10mm --json scale.json\n"
        "or, in place of the ruler, a lens of known radius:\n"
        f"    newtonjax fit known.jpg {lamp} --radius 1m --radius-sd 0.5%{view} --json scale.json"
    )


def _csv(columns: Mapping[str, list]) -> str:
    rows = [",".join(f"{number:.9g}" for number in row) for row in zip(*columns.values(), strict=True)]
    return "\n".join([",".join(columns), *rows, ""])


def demo(folder: Path, force: bool) -> int:
    """Fit the sample and compare with its truth; the exit status."""
    data = files("fitting") / "data"
    sample = tomllib.loads((data / "sample.toml").read_text(encoding="utf-8"))
    outputs = Outputs(folder=folder, force=force, more=tuple(_RING_TABLES.values()))
    with as_file(data / "sample.png") as photo:
        _check(photo, FitOptions(), outputs)
        with progress("fitting the sample"):
            session.prepare()
            result = fitting.fit(photo, **sample["given"])
        status = outputs.write(result, [Measured(photo, {})], Extras(files=partial(ring_tables, result)))
    print(_comparison(result, sample["truth"]["radius"]))
    print(f"picture: {outputs.in_folder()['picture']}")
    return status


def _check(photo: Path, options: FitOptions, outputs: Outputs) -> None:
    """Refuse before anything slow starts what cannot be read or written."""
    check_files({photo: "photograph"})
    check_options(options)
    if options.mcmc and options.lamp is not None:
        raise ValueError(f"--mcmc draws from the fit of one wavelength, not of light {options.lamp}; leave --mcmc out")
    if options.mcmc and options.plate_radius is not None:
        raise ValueError("--mcmc draws the rings' own radius; leave --plate-radius out, and take the plate off after")
    read = photo, options.scene, options.mask, options.scale_from, options.response
    outputs.check(tuple(filter(None, read)))


def check_files(roles: Mapping[Path | None, str]) -> None:
    """Raises FileNotFoundError for a path that is no file, with its role."""
    for path, role in roles.items():
        if path is not None and not path.is_file():
            from fitting.photo import not_a_file

            raise not_a_file(path, f"the path of a {role}", is_photograph=role == "photograph")


def check_options(options: FitOptions) -> None:
    """Refuse files that are not there, and a pixel size that is given twice."""
    files_given = {options.scene: "scene", options.mask: "mask", options.scale_from: "scale's JSON"}
    check_files(files_given | {options.response: "camera's response"})
    if options.scale_from is not None and options.pixel_size is not None:
        raise ValueError("--scale-from and --pixel-size both give the pixel size; leave one out")
    if not options.mcmc and (settings := options.of_chain):
        option = "--steps" if "steps" in settings else f"--prior {next(iter(settings['priors']))}"
        raise ValueError(f"{option} is of a chain; add --mcmc, or leave it out")
    if options.light is not None and options.wavelength is not None:
        raise ValueError("--light and --wavelength both say what the light is; leave one out")


def _comparison(result, truth: float) -> str:
    if result.radius is None:
        return f"true radius: {truth:.6g} m; found: none"
    distance = abs(result.radius - truth) / result.radius_sd
    return (
        f"true radius: {truth:.6g} m; found: {with_sd(result.radius, result.radius_sd, 'm')}, "
        f"{distance:.2g} standard deviations away"
    )
