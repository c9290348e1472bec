"""What a fit is asked: a photograph, what is given of its set-up, and what the user wishes; checked."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import jax
import numpy as np

from fitting.estimate import Noise, checked_noise
from fitting.model import PARTS, SceneModel
from fitting.parameters import (
    CameraScale,
    Quantities,
    camera_scale,
    checked_fixed,
    checked_plate,
    checked_start,
    curved_surface,
    quantities,
)
from fitting.photo import Photograph
from fitting.photo import read as read_photograph
from fitting.photograph.meridians import View, checked_view
from fitting.photograph.priors import StatedPrior, axis_priors, checked_axis, checked_priors, forced_parts
from fitting.photograph.verdict import RefusedError
from fitting.reasons import Reason
from newtonjax.numerics import names_in, require_choice, shown
from newtonjax.scene import Scene, required_gap

# Fewer pixels hold no rings.
_FEWEST = 64


@dataclass(frozen=True)
class Task:
    """A photograph to measure, and all that is known of it.

    - `view`: "reflected" or "transmitted"; `scene`: the bench to trace, None for fringes in the gap.
    - `fixed`, `start`: what the user holds, and starts from, by name; `wishes`: whether parts are wanted, by part.
    - `keeps_curve`: whether the user has said how codes follow the light.
    - `priors`: of parts' numbers that are not the default, by name; `scale`: what a grid says of the camera.
    - `view_angle`, `noise`: what the user says of them.
    """

    photograph: Photograph
    quantities: Quantities
    view: str
    scene: Scene | None
    fixed: dict
    start: dict
    wishes: dict[str, bool]
    keeps_curve: bool
    is_guided: bool
    contact_phase: float
    scale: CameraScale | None = None
    priors: dict[str, StatedPrior] = field(default_factory=dict)
    view_angle: View | None = None
    noise: Noise | None = None


def checked_parts(parts) -> dict[str, bool]:
    """The user's wishes by part: one that is forced on forces those that it needs.

    Raises ValueError for other names or values, and where one of those is excluded.
    """
    parts = {} if parts is None else parts
    if not isinstance(parts, dict) or set(parts) - set(PARTS) or not all(isinstance(v, bool) for v in parts.values()):
        raise ValueError(f"parts is {shown(parts)}; allowed: a mapping of {', '.join(PARTS)} to True or False")
    wishes = dict(parts)
    # Of the parts in their order none needs a later one.
    for part in reversed(PARTS):
        for need in PARTS[part].needs if wishes.get(part) else ():
            if not wishes.setdefault(need, True):
                raise ValueError(f"{part} is let in without {need}, which it needs; leave {part} out, or let {need} be")
    return wishes


def task_of(arguments: dict[str, Any]) -> Task:
    """The task of the arguments of `fitting.fit`, by name.

    Raises ValueError and FileNotFoundError for what cannot be used, RefusedError for a photograph without fringes.
    """
    image, scene, view = arguments["image"], arguments["scene"], arguments["view"]
    view = "reflected" if view is None else view
    wishes = checked_parts(arguments["parts"])
    if not isinstance(scene, Scene | None):
        raise ValueError(f"scene is {shown(scene)}; allowed: a Scene, such as newton_rings(1.0), or None")
    scale = None if arguments.get("scale") is None else camera_scale(arguments["scale"])
    given = _quantities(_with_scale(arguments, scale), scene)
    fixed, start = checked_fixed(arguments["fixed"]), checked_start(arguments["start"])
    priors = {} if arguments["priors"] is None else checked_priors(arguments["priors"], _in_scene(wishes, scene))
    has_view = arguments["view_angle"] is not None or arguments["view_angle_sd"] is not None
    view_angle = checked_view(arguments["view_angle"], arguments["view_angle_sd"]) if has_view else None
    if view_angle is not None:
        priors |= priors_of_view(view_angle, priors, wishes, scene)
    has_axis = arguments["axis_px"] is not None or arguments["axis_px_sd"] is not None
    axis = checked_axis(arguments["axis_px"], arguments["axis_px_sd"], priors) if has_axis else None
    photograph = read_photograph(
        np.asarray(image) if isinstance(image, jax.Array) else image,
        arguments["transfer"],
        arguments["mask"],
        arguments["page"],
        arguments.get("channel"),
    )
    if arguments["view"] is None and scene is None:
        photograph.warnings.append(Reason.VIEW_ASSUMED())
    if (usable := int(photograph.mask.sum())) < _FEWEST:
        raise RefusedError(Reason.TOO_FEW_PIXELS(usable=usable, total=photograph.mask.size), photograph)
    if photograph.is_uniform:
        raise RefusedError(Reason.UNIFORM(), photograph)
    shape = photograph.mask.shape
    distortion = None if scale is None else scale.prior_distortion(shape)
    if distortion is not None:
        priors = {"distortion": StatedPrior(*distortion, "grid", "measured on the grid")} | priors
    priors |= {} if axis is None else axis_priors(axis, shape)
    wishes = forced_parts(priors) | wishes if priors else wishes
    photograph.warnings.extend(() if scale is None else scale.size_warning(shape))
    noise = None if arguments.get("noise") is None else checked_noise(arguments["noise"], shape, scene)
    view, keeps_curve = view if scene is None else scene.view, arguments["transfer"] is not None
    is_guided, contact_phase = bool(fixed or start), 0.5 if view == "reflected" else 0.0
    return Task(
        photograph, given, view, scene, fixed, start, wishes, keeps_curve, is_guided, contact_phase, scale, priors,
        view_angle, noise,
    )  # fmt: skip


def priors_of_view(view: View, priors: Mapping, wishes: Mapping[str, bool], scene: Scene | None) -> dict:
    """Priors of the rings' stretch. Raises ValueError where something else says it."""
    if scene is not None:
        raise ValueError("a scene has its own view: turn its faces (lens_tilt), and leave view_angle out")
    if wishes.get("oblique_view") is False:
        raise ValueError("view_angle is that of oblique_view, which parts leaves out; leave one of them out")
    stretch = view.priors()
    if both := [name for name in stretch if name in priors]:
        raise ValueError(f"view_angle and a prior of {both[0]} both say how the rings are stretched; leave one out")
    return stretch


def _in_scene(wishes: dict[str, bool], scene: Scene | None) -> dict[str, bool]:
    """The wishes, and with a scene without the parts that it cannot have."""
    absent = () if scene is None else (part for part in PARTS if part not in SceneModel.parts)
    return wishes | dict.fromkeys(absent, False)


def _with_scale(arguments: dict[str, Any], scale: CameraScale | None) -> dict[str, Any]:
    """The arguments with the pixel size of a grid. Raises ValueError where it is given otherwise too."""
    if scale is None:
        return arguments
    if arguments["pixel_size"] is not None or arguments["pixel_size_sd"] is not None:
        raise ValueError("scale and pixel_size both give the pixel size; leave one out")
    return arguments | {"pixel_size": scale.pixel_size, "pixel_size_sd": scale.pixel_size_sd}


def _quantities(arguments: dict[str, Any], scene: Scene | None) -> Quantities:
    """What is given of the set-up; `view` and `free` are checked first."""
    if arguments["view"] is not None:
        require_choice("view", arguments["view"], ("reflected", "transmitted"))
    free = names_in("free", arguments["free"])
    values = {name: arguments[name] for name in ("radius", "wavelength", "pixel_size", "gap_index")}
    sd = {name: arguments[f"{name}_sd"] for name in values}
    if set(free) - set(values):
        raise ValueError(f"free is {shown(free)}; allowed: radius, wavelength, pixel_size or gap_index")
    if scene is None:
        values["gap_index"] = 1.0 if values["gap_index"] is None else values["gap_index"]
    else:
        curved_surface(scene)  # refuses what a fit cannot take before the image is read
        of_scene = {"wavelength": scene.wavelength, "gap_index": scene.media[required_gap(scene) + 1]}
        values |= {name: float(value) for name, value in of_scene.items() if values[name] is None}
    given = quantities(values, sd, free)
    if scene is not None and given.unknown is None:
        raise ValueError("with a scene, give the pixel size, or the radius to measure the pixel size by")
    if plate := checked_plate(arguments["plate_radius"], arguments["plate_radius_sd"]):
        if scene is not None or given.unknown != "radius":
            raise ValueError("plate_radius goes with wavelength and pixel_size, and no scene; leave it out")
        return replace(given, plate=plate)
    return given
