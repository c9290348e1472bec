"""How much memory there is, and a refusal before more than that is asked for."""

import os
from pathlib import Path

# Below this nothing is looked up: an image of 2048 x 2048 pixels in float64.
_SMALL = 2**25
# cgroup files of version 2 and 1: limit, usage, and the part of the usage that the kernel gives back when asked.
_GROUPS = (
    ("/sys/fs/cgroup", "memory.max", "memory.current", "inactive_file"),
    ("/sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
)


def require_memory(what: str, needed: float | int, way_out: str = "") -> None:
    """Raise ValueError where `needed` bytes are more than the memory that this process may still have.

    Call it before anything is allocated: a process that asks for too much is killed without a word. `what` names what
    takes the memory, `way_out` says what to do instead. Where the system does not tell, nothing is refused.
    """
    if needed <= _SMALL:
        return
    free = available_memory()
    if free is not None and needed > free:
        advice = f"; {way_out}" if way_out else ""
        raise ValueError(f"{what} needs {_size(needed)} of memory, and {_size(free)} are available{advice}")


def image_memory(shape: tuple[int, int], per_pixel: int, what: str | None = None) -> None:
    """`require_memory` of an image that is computed in so many bytes a pixel."""
    rows, columns = shape
    require_memory(
        f"an image of {rows} x {columns} pixels" if what is None else what,
        float(rows) * columns * per_pixel,
        "allowed: a smaller shape; newtonjax.blocks gives an image some rows at a time, "
        "and `newtonjax render --output image.tif` writes it so",
    )


def available_memory(root: Path = Path("/")) -> int | None:
    """Bytes that this process may still take: the system's, or what its control groups leave; None if not known."""
    limits = [free for free in (_of_system(root), *_of_groups(root)) if free is not None]
    if limits:
        return max(min(limits), 0)
    try:
        names = os.sysconf_names
        pages = "SC_AVPHYS_PAGES" if "SC_AVPHYS_PAGES" in names else "SC_PHYS_PAGES"
        return os.sysconf(pages) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):  # no such function or name on this system
        return None


def _of_system(root: Path) -> int | None:
    return _named(root / "proc/meminfo", "MemAvailable:", 1024)


def _of_groups(root: Path) -> list[int]:
    """What is left in this process's control group and each that holds it."""
    remaining = []
    for mount, limit, usage, cache in _GROUPS:
        top = root / mount.lstrip("/")
        for folder in _folders(root, top):
            most, used = _number(folder / limit), _number(folder / usage)
            if most is not None and used is not None:
                remaining.append(most - used + (_named(folder / "memory.stat", cache, 1) or 0))
    return remaining


def _folders(root: Path, top: Path) -> list[Path]:
    """The process's folders below a mount of control groups; within a container the mount itself is its group."""
    folders = [top]
    for line in _text(root / "proc/self/cgroup").splitlines():
        _, controllers, path = [*line.split(":", 2), "", ""][:3]
        if controllers == ("memory" if top.name == "memory" else ""):
            inner = top / path.lstrip("/")
            folders += [folder for folder in (inner, *inner.parents) if top in folder.parents]
    return folders


def _named(file: Path, name: str, unit: int) -> int | None:
    """A number from a file of lines "name value …"."""
    for line in _text(file).splitlines():
        words = line.split()
        if words[:1] == [name] and words[1:2] and words[1].isdecimal():
            return int(words[1]) * unit
    return None


def _number(file: Path) -> int | None:
    text = _text(file).strip()
    return int(text) if text.isdecimal() else None  # "max" is no limit


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""


def _size(count: float | int) -> str:
    for unit, factor in (("PB", 1e15), ("TB", 1e12), ("GB", 1e9)):
        if count >= factor:
            return f"{count / factor:.3g} {unit}"
    return f"{count / 1e6:.3g} MB"
