"""Memory of this process, and how to give it back: compiled code is most of it."""

import ctypes
import gc
import os
from pathlib import Path

import jax

# Compiled code takes 1 to 2 MB a program, in memory maps, of which Linux allows a process 65530. Far fewer than that:
# they are counted between modules, and no module compiles a thousand programs.
MOST_MAPS = 25_000


def resident() -> float:
    """Resident memory [GiB]; zero where the system does not say."""
    statm = Path("/proc/self/statm")
    return int(statm.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**30 if statm.exists() else 0.0


def memory_maps() -> int:
    """How many memory maps the process has; zero where the system does not say."""
    maps = Path("/proc/self/maps")
    return maps.read_bytes().count(b"\n") if maps.exists() else 0


def release(largest: float, most_maps: int | None = None) -> None:
    """Give memory back where the process has more than `largest` GiB or too many maps; compiled code too, if it must.

    What was compiled is loaded again from the cache on disk, but has to be traced again. To count ten thousand maps
    takes 10 ms, which is long for each test: None leaves them uncounted.
    """
    has_many_maps = most_maps is not None and memory_maps() > most_maps
    if resident() <= largest and not has_many_maps:
        return
    _trim()
    # Not just below: the next test would have to do it again.
    if resident() > 0.7 * largest or has_many_maps:
        jax.clear_caches()
        _trim()


def _trim() -> None:
    """The C library keeps what is freed, and gives it back to the system only when it is asked to."""
    gc.collect()
    try:
        ctypes.CDLL(None).malloc_trim(0)
    except (AttributeError, OSError):  # another C library than GNU's
        return
