"""What symmetry spares: the second polarization component of unpolarized light."""

from dataclasses import replace

import numpy as np

from newtonjax.light import Light, launch_frame
from newtonjax.quantities import is_concrete
from newtonjax.scene import Scene
from newtonjax.surfaces import frame


def spare_component(scene: Scene) -> Scene:
    """The scene with one circularly polarized component in place of unpolarized light, where both give one image.

    So they do where every ray stays in one plane with the normals of all that it meets: there s and p keep apart, and
    circular light is half of each, as unpolarized light is. Traced values leave the scene as it is.
    """
    light = scene.light
    if light.polarization is not None or not _stays_in_planes(scene):
        return scene
    return replace(scene, light=Light(light.wavelength, light.tilt, 0.0, np.pi / 4))


def _stays_in_planes(scene: Scene) -> bool:
    """True for surfaces centred on one line along the light, and for planes all normal to one plane with the light."""
    shapes = [(s.curvature, s.tilt, s.vertex) for s in scene.surfaces]
    if not is_concrete(shapes, scene.light.tilt):
        return False
    along = np.asarray(launch_frame(scene.light)[2])
    normals = np.array([frame(s.tilt)[2] for s in scene.surfaces])
    curved = np.array([np.any(np.asarray(s.curvature) != 0) for s in scene.surfaces])
    if not curved.any():
        return bool(np.linalg.matrix_rank(np.vstack([along, normals]), tol=1e-12) <= 2)
    if np.any(np.cross(normals[~curved], along)):
        return False
    # A sphere's tilt turns it about its vertex: what must lie on one line is its centre.
    centres = np.array(
        [s.vertex + n / s.curvature for s, n, c in zip(scene.surfaces, normals, curved, strict=True) if c]
    )
    return not np.any(np.cross(centres - centres[0], along))
