"""The numbers of a curved face that is no sphere, by name: conic constant, term in r⁴, second radius and axis."""

from collections.abc import Callable
from functools import cache
from typing import Any

import equinox as eqx
import numpy as np

from newtonjax.scene import Camera, Scene, corners

# Name, value, scale, and the move by so much of a scene and a camera.
_Entry = tuple[str, float, float, Callable[..., Any]]


def shape_entries(scene: Scene, camera: Camera, face: int) -> list[_Entry]:
    """Of what the face has, be it 0; the scale of the term in r⁴ is a wavelength of height at the image's corner."""
    surface, entries = scene.surfaces[face], []
    if surface.conic is not None:
        entries.append(("conic", float(surface.conic), 1.0, _conic(face)))
    if surface.asphere is not None:
        corner = float(np.hypot(*corners(camera).T).max())
        entries.append(("asphere", float(surface.asphere[0]), float(scene.wavelength) / corner**4, _asphere(face)))
    if surface.curvature_across is not None and float(surface.curvature_across):
        across = 1 / float(surface.curvature_across)
        axis = 0.0 if surface.axis is None else float(surface.axis)
        entries.append(("radius_across", across, abs(across), _radius_across(face)))
        entries.append(("astigmatism_axis", axis, 1.0, _axis(face)))
    return entries


@cache
def _conic(face: int):
    def move(scene, camera, by):
        return eqx.tree_at(lambda s: s.surfaces[face].conic, scene, scene.surfaces[face].conic + by), camera

    return move


@cache
def _asphere(face: int):
    def move(scene, camera, by):
        terms = scene.surfaces[face].asphere
        return eqx.tree_at(lambda s: s.surfaces[face].asphere, scene, terms + np.eye(len(terms))[0] * by), camera

    return move


@cache
def _radius_across(face: int):
    def move(scene, camera, by):
        radius = 1 / scene.surfaces[face].curvature_across
        return eqx.tree_at(lambda s: s.surfaces[face].curvature_across, scene, 1 / (radius + by)), camera

    return move


@cache
def _axis(face: int):
    def move(scene, camera, by):
        axis = 0.0 if scene.surfaces[face].axis is None else scene.surfaces[face].axis
        turned = eqx.tree_at(lambda s: s.surfaces[face].axis, scene, axis + by, is_leaf=lambda leaf: leaf is None)
        return turned, camera

    return move
