"""The folder of compiled programs: where it is, and who may have written into it."""

import os
import stat
from pathlib import Path

# The variable of JAX that names another folder.
NAMED_BY = "JAX_COMPILATION_CACHE_DIR"


def cache_folder() -> Path:
    """The folder that compiled programs are kept in between runs, be it there or not."""
    if named := os.environ.get(NAMED_BY):
        return Path(named)
    import platformdirs

    return platformdirs.user_cache_path("newtonjax", appauthor=False) / "jax"


def is_ours(path: Path) -> bool:
    """Whether nobody but the user may have written a file or folder; on a system without owners, always."""
    about = path.stat()
    if not hasattr(os, "getuid"):
        return True
    return about.st_uid == os.getuid() and not about.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
