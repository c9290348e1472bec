"""What a call takes: a scene and a camera; anything else is refused in one line."""

from newtonjax.numerics import shown
from newtonjax.scene.camera import Camera
from newtonjax.scene.scene import Scene


def require_bench(scene, camera) -> None:
    """Raise ValueError for what is no scene or no camera."""
    require_scene(scene)
    require_camera(camera)


def require_scene(scene) -> None:
    """Raise ValueError for what is no scene."""
    if not isinstance(scene, Scene):
        raise ValueError(f"scene is {shown(scene)}; allowed: a Scene, such as newton_rings(1.0)")


def require_camera(camera) -> None:
    """Raise ValueError for what is no camera."""
    if not isinstance(camera, Camera):
        hint = " (a scene file without [camera] has none)" if camera is None else ""
        raise ValueError(f"camera is {shown(camera)}{hint}; allowed: a Camera, such as Camera((512, 512), 5e-6)")
