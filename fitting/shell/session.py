"""What a program of ours asks of JAX before its first use: float64, and compiled code kept between runs."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import newtonjax as nj


# The variable of JAX that names another folder.
NAMED_BY = "JAX_COMPILATION_CACHE_DIR"


def cache_folder() -> Path:
    """The folder that compiled programs are kept in between runs, be it there or not."""
    if named := os.environ.get(NAMED_BY):
        return Path(named)
    import platformdirs

    return platformdirs.user_cache_path("newtonjax", appauthor=False) / "jax"


def prepare() -> None:
    """Switch JAX to float64 and keep compiled programs of any size in the user's cache folder.

    `JAX_COMPILATION_CACHE_DIR` names another folder. Where none can be written, nothing is kept.
    """
    import jax

    jax.config.update("jax_enable_x64", True)
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    if NAMED_BY in os.environ:
        return
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    if os.access(folder, os.W_OK):
        jax.config.update("jax_compilation_cache_dir", str(folder))


def keep_rays() -> None:
    """Have the program for the rays of every bench loaded from the compilation cache's folder, or left there.

    JAX's own cache would leave a second or two of tracing to every run.
    """
    import jax

    from fitting.shell.saved_programs import SavedProgram
    from newtonjax.fields import packed

    folder = jax.config.values["jax_compilation_cache_dir"]
    if folder and not isinstance(packed.rays, SavedProgram):
        packed.rays = SavedProgram(packed.rays, Path(folder) / "programs", packed.OPTIONS)


def scene_and_camera(
    path: Path, shape: tuple[int, int] | None = None, pixel_size: float | None = None
) -> "tuple[nj.Scene, nj.Camera, str]":
    """The scene of a file, its camera with what is given in place of its own, and a line that says which that is."""
    from dataclasses import replace

    import newtonjax as nj

    scene, camera = nj.load_scene(path)
    default = nj.Camera((1024, 1024), 5e-6) if camera is None else camera
    changed = replace(default, shape=shape or default.shape, pixel_size=pixel_size or default.pixel_size)
    assumed = " (the file has no camera)" if camera is None else ""
    rows, columns = changed.shape
    return scene, changed, f"camera: {rows} x {columns} pixels of {float(changed.pixel_size) * 1e6:.6g} um{assumed}"
