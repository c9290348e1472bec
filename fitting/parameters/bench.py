"""The numbers of a scene and its camera by name, and how each of them is moved."""

from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from fitting.parameters.light_numbers import light_entries
from fitting.parameters.shape_numbers import shape_entries
from fitting.parameters.table import TABLE, ParameterSpec
from newtonjax.numerics import names_in, shown
from newtonjax.scene import Camera, Scene, dot, frame, gap_height, middle, require_bench, required_gap

Bench = tuple[Scene, Camera]


@dataclass(frozen=True)
class Knob:
    """A number of a scene or its camera.

    - `value`: as it stands [`unit`]; `scale`: a step that matters [`unit`], its size where it has one.
    - `move`: (scene, camera), and by how much [`unit`], to (scene, camera); differentiable.
    """

    spec: ParameterSpec
    value: float
    scale: float
    move: Callable[[Scene, Camera, Any], Bench]

    @property
    def name(self) -> str:
        return self.spec.name

    @property
    def unit(self) -> str:
        return self.spec.unit

    @property
    def positive(self) -> bool:
        """Whether only its ratios mean something."""
        return self.spec.positive


def knobs(scene: Scene, camera: Camera) -> dict[str, Knob]:
    """What can be moved by name: what every bench of a gap has; the radius where one face of it is curved, the wedge
    angle where both are plane and not parallel; of that face conic constant, the term in r⁴ ("asphere"), second radius
    and axis where it has them, be they 0 (`shape_numbers`); and the numbers of a light that is more than one line, a
    source of a size, blur and aperture (`light_numbers`).

    "screen" is its distance from the face that light leaves through. "plate_tilt_x" and "plate_tilt_y" turn all
    faces below the gap as one, about the vertex of the uppermost; so does
    "wedge_angle", about the wedge's edge. "stray" is light that adds to the image [incident
    irradiance], "contrast" that of the fringes over the scene's own: they belong to the image, and move neither
    scene nor camera.
    """
    require_bench(scene, camera)
    upper = required_gap(scene)
    centre = middle(camera.shape) if camera.centre_px is None else tuple(map(float, camera.centre_px))
    present = [
        _knob("wavelength", float(scene.wavelength), _wavelength),
        _knob("gap", gap_height(scene), _gap, float(scene.wavelength)),
        _knob("pixel_size", float(camera.pixel_size), _pixel_size),
        _knob("centre_x", centre[0], _centre(0), 1.0),
        _knob("centre_y", centre[1], _centre(1), 1.0),
        _index("lens_index", scene, upper),
        _index("gap_index", scene, upper + 1),
        _index("plate_index", scene, upper + 2),
        _distance(scene),
        _knob("exposure", float(camera.exposure), _exposure),
        _knob("stray", 0.0, still, 1.0),
        _knob("contrast", 1.0, still, 1.0),
    ]
    lower = upper + 1
    for axis, name in enumerate("xy"):
        present += [
            _knob(f"light_tilt_{name}", float(scene.light.tilt[axis]), _light(axis), 1e-3),
            _knob(f"plate_tilt_{name}", float(scene.surfaces[lower].tilt[axis]), _plate(lower, *np.eye(2)[axis]), 1e-3),
        ]
    present += _wedge_angle(scene, upper)
    present += [_knob(name, value, move, scale) for name, value, scale, move in light_entries(scene, camera)]
    try:
        face = curved_surface(scene)
    except ValueError:
        return {knob.name: knob for knob in present}
    radius = 1 / float(scene.surfaces[face].curvature)
    present.insert(0, _knob("radius", radius, _radius(face), abs(radius)))
    present += [_knob(name, value, move, scale) for name, value, scale, move in shape_entries(scene, camera, face)]
    return {knob.name: knob for knob in present}


def _knob(name: str, value: float, move, scale: float | None = None) -> Knob:
    return Knob(TABLE[name], value, value if scale is None else scale, move)


def chosen(present: dict[str, Knob], names: tuple[str, ...]) -> dict[str, Knob]:
    """Some of `knobs`, in the order of their names. Raises ValueError for what is not there, and for none."""
    names = names_in("numbers", names)
    if absent := [name for name in names if name not in present]:
        why = " (no face of its gap is curved)" if "radius" in absent and "radius" not in present else ""
        near = get_close_matches(absent[0], present, 1)
        meant = f", perhaps {near[0]}" if near else ""
        raise ValueError(f"{shown(absent[0])} is not a number of this scene{why}; allowed: {', '.join(present)}{meant}")
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"{twice[0]} is named twice; give each number at most once")
    if not names:
        raise ValueError(f"no number is named; allowed: {', '.join(present)}")
    return {name: present[name] for name in names}


def still(scene: Scene, camera: Camera, by) -> Bench:
    """The move of a number that is of the image alone."""
    del by
    return scene, camera


@cache
def _radius(face: int):
    def move(scene, camera, by):
        radius = 1 / scene.surfaces[face].curvature
        return eqx.tree_at(lambda s: s.surfaces[face].curvature, scene, 1 / (radius + by)), camera

    return move


def _wavelength(scene, camera, by):
    return eqx.tree_at(lambda s: s.light.wavelength, scene, scene.wavelength + by), camera


def _gap(scene, camera, by):
    return raise_lens(scene, by), camera


def _pixel_size(scene, camera, by):
    return scene, eqx.tree_at(lambda c: c.pixel_size, camera, camera.pixel_size + by)


@cache
def _centre(axis: int):
    def move(scene, camera, by):
        at = middle(camera.shape) if camera.centre_px is None else camera.centre_px
        centre = (np.asarray(at, float) if isinstance(at, tuple) else at) + np.eye(2)[axis] * by
        return scene, eqx.tree_at(lambda c: c.centre_px, camera, centre, is_leaf=lambda leaf: leaf is None)

    return move


def _index(name: str, scene: Scene, at: int) -> Knob:
    return _knob(name, float(scene.media[at]), _medium(at))


@cache
def _medium(at: int):
    def move(scene, camera, by):
        return eqx.tree_at(lambda s: s.media, scene, scene.media + np.eye(len(scene.media))[at] * by), camera

    return move


def _distance(scene: Scene) -> Knob:
    """Of the screen from the face that light leaves through; negative where it lies before it, as in the gap."""
    down = scene.view == "transmitted"
    face = scene.surfaces[-1 if down else 0]
    value = float(scene.screen.vertex[2] - face.vertex[2]) * (-1 if down else 1)
    return _knob("screen", value, _screen(-1.0 if down else 1.0), abs(value) or 1e-3)


@cache
def _screen(sign: float):
    def move(scene, camera, by):
        return eqx.tree_at(lambda s: s.screen.vertex, scene, scene.screen.vertex + np.array([0, 0, sign]) * by), camera

    return move


def _exposure(scene, camera, by):
    return scene, eqx.tree_at(lambda c: c.exposure, camera, camera.exposure + by)


@cache
def _light(axis: int):
    def move(scene, camera, by):
        return eqx.tree_at(lambda s: s.light.tilt, scene, scene.light.tilt + np.eye(2)[axis] * by), camera

    return move


def _wedge_angle(scene: Scene, upper: int) -> list[Knob]:
    """The angle between the plane faces of a gap; none where a face is curved, or they are parallel."""
    faces = scene.surfaces[upper : upper + 2]
    x, y = (float(below - above) for above, below in zip(faces[0].tilt, faces[1].tilt, strict=True))
    angle = float(np.hypot(x, y))
    if not angle or any(float(face.curvature) for face in faces):
        return []
    return [_knob("wedge_angle", angle, _plate(upper + 1, x / angle, y / angle))]


@cache
def _plate(lower: int, along_x: float, along_y: float):
    """Turn everything below a gap about an axis of these parts along x and y."""

    def move(scene, camera, by):
        pivot = scene.surfaces[lower].vertex
        changed = []
        for surface in scene.surfaces[lower:]:
            tilt, offset = surface.tilt + np.array([along_x, along_y]) * by, surface.vertex - pivot
            turned = [new * dot(old, offset) for new, old in zip(frame(tilt), frame(surface.tilt), strict=True)]
            changed += [pivot + turned[0] + turned[1] + turned[2], tilt]
        return eqx.tree_at(_below, scene, changed), camera

    def _below(scene):
        return [part for surface in scene.surfaces[lower:] for part in (surface.vertex, surface.tilt)]

    return move


def curved_surface(scene: Scene) -> int:
    """Index of the one curved face of the gap. Raises ValueError where there is none, or more than one."""
    upper = required_gap(scene)
    curved = [k for k in (upper, upper + 1) if float(scene.surfaces[k].curvature) != 0]
    if len(curved) != 1:
        raise ValueError(f"{len(curved)} faces of the gap are curved; a fit of the radius takes one")
    return curved[0]


def quantities_of(scene: Scene, face: int) -> dict[str, float]:
    """The bench's own radius and wavelength [m], and the gap's index."""
    return {
        "radius": abs(1 / float(scene.surfaces[face].curvature)),
        "wavelength": float(scene.wavelength),
        "gap_index": float(scene.media[required_gap(scene) + 1]),
    }


def change(scene: Scene, quantity: str, factor, face: int) -> Scene:
    """The scene with a quantity multiplied: a face's radius, the wavelength, or the gap's index."""
    if quantity == "wavelength":
        return eqx.tree_at(lambda s: s.light.wavelength, scene, scene.wavelength * factor)
    if quantity == "gap_index":
        at = required_gap(scene) + 1
        media = jnp.asarray(scene.media)
        return eqx.tree_at(lambda s: s.media, scene, media.at[at].multiply(factor))
    return eqx.tree_at(lambda s: s.surfaces[face].curvature, scene, scene.surfaces[face].curvature / factor)


def raise_lens(scene: Scene, height) -> Scene:
    """The scene with everything above its gap raised [m]: screen, shield and collecting lens too if they are there."""
    up = np.array([0.0, 0.0, 1.0]) * height
    upper = required_gap(scene)

    def raised(s: Scene):
        parts = [s.surfaces[k].vertex for k in range(upper + 1)]
        if s.view == "transmitted":
            return parts
        return [*parts, s.screen.vertex, *(part.vertex for part in (s.shield, s.collecting_lens) if part is not None)]

    return eqx.tree_at(raised, scene, [vertex + up for vertex in raised(scene)])
