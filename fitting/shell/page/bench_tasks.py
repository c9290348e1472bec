"""What the worker does for the virtual bench: its picture while a slider moves, and numbers beside it."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fitting.shell.page.pictures import jpeg

Tell = Callable[[str, Any], None]
# Pixels to a side.
SIDE = 512


class Slider(NamedTuple):
    """A number of the bench by what a person sees: its unit there, in SI, its range and step, and its first value."""

    title: str
    unit: str
    si: float
    lowest: float
    highest: float
    step: float
    first: float


# Numbers of `newtonjax.newton_rings`, of the camera, and what stands for a number that has no value on a sphere.
SLIDERS = {
    "radius": Slider("Radius of the lens", "m", 1.0, 0.2, 5.0, 0.005, 1.0),
    "across": Slider("Second radius over the first (1: a sphere)", "", 1.0, 0.5, 2.0, 0.005, 1.0),
    "axis": Slider("Direction of the first radius", "°", math.pi / 180, 0.0, 180.0, 1.0, 0.0),
    "conic": Slider("Conic constant of the lens (0: a sphere)", "", 1.0, -50.0, 50.0, 0.5, 0.0),
    "plate": Slider("Curvature of the plate (0: flat)", "1/m", 1.0, -0.15, 2.0, 0.01, 0.0),
    "gap": Slider("Gap at the centre", "nm", 1e-9, 0.0, 2000.0, 1.0, 0.0),
    "wavelength": Slider("Wavelength", "nm", 1e-9, 400.0, 700.0, 0.1, 589.3),
    "lens_index": Slider("Index of the lens", "", 1.0, 1.3, 2.0, 0.001, 1.5),
    "plate_index": Slider("Index of the plate", "", 1.0, 1.3, 2.0, 0.001, 1.5),
    "gap_index": Slider("Index in the gap", "", 1.0, 1.0, 1.7, 0.001, 1.0),
    "pixel_size": Slider("Size of a pixel on the object", "µm", 1e-6, 4.0, 40.0, 0.1, 16.0),
}
VIEWS = ("reflected", "transmitted")
# Lights of several lines or of a band; "" is the one line of the slider.
LIGHTS = {"": "one wavelength", "sodium": "sodium lamp", "mercury": "mercury lamp", "white:5500K": "white light"}
# Of the incident irradiance: what is darker is shown as black.
_DARKEST = 1e-12
_TOO_FINE = (
    "In {share:.0%} of the picture fringes are finer than two pixels: the rings that are seen there are none of the "
    "bench's. Make the pixels smaller, or the radius larger."
)
# No more rings are listed.
_RINGS = 12


def draw(files: Path, tell: Tell, values: Mapping[str, Any]) -> bytes:
    """The rings of a bench as JPEG, white where they are brightest. Raises ValueError for what is no bench."""
    del files, tell
    import newtonjax as nj

    scene, camera = _bench(values)
    if not values.get("light"):
        image = np.asarray(nj.render(scene, camera))
        return jpeg(image / max(float(image.max()), _DARKEST))
    image = np.asarray(nj.render(scene, replace(camera, response=_eye())))
    brightest = max(float(image[:, :, 1].max()), _DARKEST)
    return jpeg(np.asarray(nj.to_srgb(image / brightest)))


def describe(files: Path, tell: Tell, values: Mapping[str, Any]) -> dict[str, Any]:
    """Radii of the first dark rings, and the deviations that a photograph of the bench could give at best.

    Of a bench whose fringes are too fine for its pixels a warning in place of the latter.
    """
    del files, tell
    import fitting
    import newtonjax as nj

    scene, camera = _bench({**values, "light": ""})
    plan = nj.plan(scene, camera)
    path = np.asarray(nj.opd(scene, camera))
    too_fine = _too_fine(path / float(scene.wavelength))
    bounds = "" if too_fine else fitting.information(scene, camera, free=("radius", "gap")).report()
    rings = _dark_rings(path, float(scene.wavelength), scene.view, float(camera.pixel_size))
    way = f"{type(plan.method).__name__}: {plan.reason}; wrong by at most {plan.intensity_error:.1g} of the brightest"
    warning = _TOO_FINE.format(share=too_fine) if too_fine else ""
    return {"rings": rings, "bounds": bounds, "way": way, "warning": warning}


def compare(files: Path, tell: Tell, values: Mapping[str, Any]) -> str:
    """Every way to the picture of a bench: time, memory and errors, and what each would do to a radius."""
    del files, tell
    import fitting

    return fitting.tradeoff(*_bench({**values, "light": ""})).report()


def _too_fine(turns: np.ndarray) -> float:
    """The share of a picture whose fringes are finer than two pixels."""
    steps = np.abs(np.diff(turns, axis=0))[:, 1:], np.abs(np.diff(turns, axis=1))[1:]
    return float(np.mean(np.maximum(*steps) > 0.5))


def _dark_rings(path: np.ndarray, wavelength: float, view: str, pixel_size: float) -> list[dict[str, Any]]:
    """Order and radius [m] of the dark rings along the middle row, where the path has whole waves in reflection.

    In transmission no face turns the phase by half a wave, and they are half a wave further.
    """
    middle = SIDE // 2
    across = pixel_size * (np.arange(middle, SIDE) - (SIDE - 1) / 2)
    r2 = across**2 + (pixel_size / 2) ** 2
    order = np.abs(path[middle, middle:]) / wavelength - (0.5 if view == "transmitted" else 0.0)
    numbers = np.arange(np.ceil(order.min()), np.floor(order.max()) + 1)[:_RINGS]
    radii = np.sqrt(np.interp(numbers, order, r2))
    return [{"order": int(number), "radius_m": float(radius)} for number, radius in zip(numbers, radii, strict=True)]


@cache
def _eye() -> Any:
    """What an eye sees of a spectrum, made once."""
    import newtonjax as nj

    return nj.cie_1931()


def _bench(values: Mapping[str, Any]) -> tuple[Any, Any]:
    """Scene and camera of the sliders' values. Raises ValueError for names or numbers that are none of theirs."""
    import newtonjax as nj

    numbers: dict[str, Any] = {name: slider.first * slider.si for name, slider in SLIDERS.items()}
    for name, value in values.items():
        if name in SLIDERS:
            numbers[name] = _number(name, value)
        elif name not in ("view", "light"):
            raise ValueError(f"{str(name)[:40]!r} is no slider of the bench; allowed: {', '.join(SLIDERS)}")
    view, light = values.get("view", VIEWS[0]), values.get("light", "")
    if view not in VIEWS or light not in LIGHTS:
        raise ValueError(f"allowed views: {', '.join(VIEWS)}; lights: {', '.join(filter(None, LIGHTS))}")
    across, axis, conic, plate = map(numbers.pop, ("across", "axis", "conic", "plate"))
    if across != 1.0 and conic:
        raise ValueError("a lens with two radii has no conic constant; set one of these two sliders back to a sphere")
    numbers |= _faces(conic, plate)
    numbers |= {"radius_across": across * numbers["radius"], "axis": axis} if across != 1.0 else {}
    camera = nj.Camera((SIDE, SIDE), pixel_size=numbers.pop("pixel_size"))
    if light:
        del numbers["wavelength"]
        numbers["light"] = light
    return nj.newton_rings(view=view, **numbers), camera


def _faces(conic: float, plate: float) -> dict[str, float]:
    """Arguments of the bench for its faces, without those that leave a sphere on a flat plate."""
    return ({"conic": conic} if conic else {}) | ({"plate_radius": 1 / plate} if plate else {})


def _number(name: str, value: Any) -> float:
    slider = SLIDERS[name]
    if not isinstance(value, int | float) or not slider.lowest <= value <= slider.highest:
        unit = f" {slider.unit}".rstrip()
        raise ValueError(f"{name} is {str(value)[:40]}; allowed: {slider.lowest:g} to {slider.highest:g}{unit}")
    return float(value) * slider.si
