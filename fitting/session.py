"""What a program of ours asks of JAX before its first use: float64, and compiled code kept between runs."""

import os


def prepare() -> None:
    """Switch JAX to float64 and to a compilation cache in the user's cache folder, whatever took how long to compile.

    `JAX_COMPILATION_CACHE_DIR` names another folder. Where none can be written, nothing is kept.
    """
    import jax
    import platformdirs

    jax.config.update("jax_enable_x64", True)
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    if "JAX_COMPILATION_CACHE_DIR" in os.environ:
        return
    folder = platformdirs.user_cache_path("newtonjax", appauthor=False) / "jax"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    if os.access(folder, os.W_OK):
        jax.config.update("jax_compilation_cache_dir", str(folder))
