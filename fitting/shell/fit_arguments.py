"""What the user knows of a photograph, and the arguments of `fitting.fit` that it makes."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from fitting.shell import assignments
from fitting.shell.lamps import Wavelength


class FitOptions(NamedTuple):
    """What the user knows, in SI, standard deviations also as percentages; None for what was not given."""

    wavelength: Wavelength | None = None
    pixel_size: float | None = None
    wavelength_sd: float | str | None = None
    pixel_size_sd: float | str | None = None
    radius: float | None = None
    view: str | None = None
    scene: Path | None = None
    transfer: float | str | None = None
    scale_from: Path | None = None
    parts: Mapping[str, bool] = MappingProxyType({})
    mask: Path | None = None
    mcmc: bool = False
    plate_radius: float | None = None
    plate_radius_sd: float | str | None = None
    page: int | None = None
    radius_sd: float | str | None = None
    prior: Mapping[str, tuple[float, float | str]] = MappingProxyType({})
    fix: Mapping[str, Any] = MappingProxyType({})
    start: Mapping[str, Any] = MappingProxyType({})
    axis: tuple[float, float] | None = None
    axis_sd: float | None = None
    view_angle: float | None = None
    view_angle_sd: float | str | None = None
    light: str | None = None
    channel: str | None = None
    steps: int | None = None
    noise: str | tuple[float, float] | None = None
    response: Path | None = None

    @property
    def of_chain(self) -> dict[str, Any]:
        """What `fitting.sample` is told."""
        priors = {name: prior for name, prior in self.prior.items() if name in assignments.OF_CHAIN}
        return ({"priors": priors} if priors else {}) | ({} if self.steps is None else {"steps": self.steps})

    @property
    def lamp(self) -> str | None:
        """The words for a light of several lines, also where they stand for the wavelength."""
        of_wavelength = None if self.wavelength is None or self.scene is not None else self.wavelength.lamp
        return of_wavelength if self.light is None else self.light


def arguments_of(options: FitOptions) -> dict:
    """The arguments of `fitting.fit`; what a scene file says stands in for what was not given."""
    arguments: dict[str, Any] = {
        "wavelength_sd": options.wavelength_sd,
        "pixel_size": options.pixel_size,
        "pixel_size_sd": options.pixel_size_sd,
        "radius": options.radius,
        "transfer": options.transfer,
    }
    if options.wavelength is not None and options.wavelength_sd is None:
        arguments["wavelength_sd"] = options.wavelength.sd
    for name in ("plate_radius", "plate_radius_sd", "page", "radius_sd", "channel", "noise", "response"):
        if getattr(options, name) is not None:
            arguments[name] = getattr(options, name)
    if options.mask is not None:
        arguments["mask"] = options.mask
    if options.parts:
        arguments["parts"] = dict(options.parts)
    arguments |= _of_model(options)
    if options.scale_from is not None:
        del arguments["pixel_size"]
        arguments["scale"] = options.scale_from
    if options.lamp is not None:
        # A lamp's lines are known; of curves a person may say how well.
        of_curves = None if options.response is None else options.wavelength_sd
        return {**arguments, "wavelength_sd": of_curves, "light": options.lamp, "view": options.view}
    if options.scene is None:
        wavelength = None if options.wavelength is None else options.wavelength.given
        return {**arguments, "wavelength": wavelength, "view": options.view}
    from newtonjax import load_scene

    scene, camera = load_scene(options.scene)
    if options.view not in (None, scene.view):
        raise ValueError(f"--view {options.view}: the scene in {options.scene} is seen {scene.view}; leave --view out")
    if options.wavelength is not None:
        arguments["wavelength"] = options.wavelength.within(float(scene.media[0]))
    elif options.radius is None:
        arguments["wavelength"] = float(scene.wavelength)
    if options.scale_from is None and arguments["pixel_size"] is None and camera is not None:
        arguments["pixel_size"] = float(camera.pixel_size)
    return {**arguments, "view": scene.view, "scene": scene}


def _of_model(options: FitOptions) -> dict[str, Any]:
    """The arguments of `fitting.fit` that say what is known of the parts' numbers."""
    arguments: dict[str, Any] = {"axis_px": options.axis, "axis_px_sd": options.axis_sd}
    arguments |= {"view_angle": options.view_angle, "view_angle_sd": options.view_angle_sd}
    named = {name: value for name, value in arguments.items() if value is not None}
    named |= {name: dict(value) for name, value in (("fixed", options.fix), ("start", options.start)) if value}
    priors = {name: prior for name, prior in options.prior.items() if name not in options.of_chain.get("priors", {})}
    return named | ({"priors": priors} if priors else {})
