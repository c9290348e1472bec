"""Who may have written a file."""

import os
import stat
from pathlib import Path


def is_ours(path: Path) -> bool:
    """Whether nobody but the user may have written a file or folder; on a system without owners, always."""
    about = path.stat()
    if not hasattr(os, "getuid"):
        return True
    return about.st_uid == os.getuid() and not about.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
