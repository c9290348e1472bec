"""The verbs `fit` and `demo`: from a photograph and options to an answer on the screen and in files."""

import tomllib
from importlib.resources import as_file, files
from pathlib import Path
from typing import NamedTuple

import fitting
from fitting import session
from fitting.answer import Outputs, as_png
from fitting.lamps import Wavelength
from fitting.progress import progress


class Given(NamedTuple):
    """What the user knows, in SI; None for what was not given."""

    wavelength: Wavelength | None = None
    pixel_size: float | None = None
    wavelength_sd: float | None = None
    pixel_size_sd: float | None = None
    radius: float | None = None
    view: str | None = None
    scene: Path | None = None
    transfer: float | str | None = None


def run(photo: Path, given: Given, outputs: Outputs) -> int:
    """Fit, report, write; the exit status."""
    _check(photo, given, outputs)
    session.prepare()
    arguments = _arguments(given)
    with progress(f"fitting {photo.name}"):
        result = fitting.fit(photo, **arguments)
    return outputs.write(result, _picture)


def demo(folder: Path, force: bool) -> int:
    """Fit the sample and compare with its truth; the exit status."""
    data = files("fitting") / "data"
    sample = tomllib.loads((data / "sample.toml").read_text(encoding="utf-8"))
    outputs = Outputs(folder=folder, force=force)
    with as_file(data / "sample.png") as photo:
        _check(photo, Given(), outputs)
        session.prepare()
        with progress("fitting the sample"):
            result = fitting.fit(photo, **sample["given"])
    status = outputs.write(result, _picture)
    print(_comparison(result, sample["truth"]["radius"]))
    print(f"picture: {outputs.in_folder()['picture']}")
    return status


def _check(photo: Path, given: Given, outputs: Outputs) -> None:
    """Refuse before anything slow starts what cannot be read or written."""
    for path, what in ((photo, "photograph"), (given.scene, "scene")):
        if path is not None and not path.is_file():
            raise FileNotFoundError(f"{path} is no file; give the path of a {what}")
    outputs.check(tuple(filter(None, [photo, given.scene])))


def _arguments(given: Given) -> dict:
    """The arguments of `fitting.fit`; what a scene file says stands in for what was not given."""
    known = {
        "wavelength_sd": given.wavelength_sd,
        "pixel_size": given.pixel_size,
        "pixel_size_sd": given.pixel_size_sd,
        "radius": given.radius,
        "transfer": given.transfer,
    }
    if given.scene is None:
        wavelength = None if given.wavelength is None else given.wavelength.within(1.0)
        return {**known, "wavelength": wavelength, "view": given.view or "reflected"}
    from newtonjax import load_scene

    scene, camera = load_scene(given.scene)
    if given.view not in (None, scene.view):
        raise ValueError(f"--view {given.view}: the scene in {given.scene} is seen {scene.view}; leave --view out")
    if given.wavelength is not None:
        known["wavelength"] = given.wavelength.within(float(scene.media[0]))
    elif given.radius is None:
        known["wavelength"] = float(scene.wavelength)
    if given.pixel_size is None and camera is not None:
        known["pixel_size"] = float(camera.pixel_size)
    return {**known, "view": scene.view, "scene": scene}


def _picture(result) -> bytes:
    from fitting.plot import result_figure

    return as_png(result_figure(result))


def _comparison(result, truth: float) -> str:
    if result.radius is None:
        return f"true radius: {truth:.6g} m; found: none"
    away = abs(result.radius - truth) / result.radius_sd
    return (
        f"true radius: {truth:.6g} m; found: {result.radius:.6g} +/- {result.radius_sd:.2g} m, "
        f"{away:.2g} standard deviations away"
    )
