"""What goes with a verb while it runs: one thread for matrix products, which are small, and word of its progress."""

import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import lru_cache

from newtonjax.numerics import shown

# True for a bar on stderr; or a function of the steps done and their number.
Progress = bool | Callable[[int, int], None] | None


def one_blas_thread():
    """A context in which every BLAS that is loaded has one thread.

    One with threads of its own spins on the cores after each product, and the products here are small: a fit takes ten
    times as long. NumPy and SciPy bring one each, and SciPy's is loaded with the first of its modules that needs it.
    """
    return _libraries(sum(name.startswith("scipy.") for name in sys.modules)).limit(limits=1, user_api="blas")


@lru_cache(maxsize=1)
def _libraries(_modules: int):
    """Those that are loaded. To look for them takes as long as a frame of a stack: only when SciPy has new modules."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


@contextmanager
def progress_of(progress: Progress, task: str) -> Generator[Callable[[int, int], None], None, None]:
    """What a verb calls with the steps done and their number: a bar on a terminal, a function, or nothing.

    Raises ValueError for anything else.
    """
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise ValueError(f"progress is {shown(progress)}; allowed: True, a function of (steps done, steps), or None")
    if callable(progress):
        yield progress
    elif not progress:
        yield lambda *_: None
    else:
        from rich.console import Console
        from rich.progress import Progress as Bar

        console = Console(stderr=True)
        with Bar(console=console, transient=True, disable=not console.is_terminal) as bar:
            line = bar.add_task(task, total=None)
            yield lambda done, total: bar.update(line, completed=done, total=total)
