"""float64 where it is needed: as a context around eager calls, as an error inside the user's own transformations."""

import os
from contextlib import contextmanager

import jax
import numpy as np
from jax.core import eval_context

from newtonjax.numerics.quantities import is_concrete

# The process in which JAX's programs were first run from here.
_first_process: int | None = None


@contextmanager
def x64(runs_programs: bool = True):
    """A context for what has only concrete values: JAX computes it in float64 and at once.

    The user's configuration is left alone. Within a transformation of the user's the result is a constant. Raises
    RuntimeError in a process that was forked from one where programs were run, unless none are run here.
    """
    if runs_programs:
        refuse_after_fork()
    # Not `ensure_compile_time_eval`: that also evaluates the constants of a program that is being traced, by a small
    # program each.
    with jax.enable_x64(True), eval_context():
        yield


def refuse_after_fork() -> None:
    """Raise RuntimeError where JAX would wait for ever: for threads that a fork did not take along."""
    global _first_process
    if _first_process is None:
        _first_process = os.getpid()
    if _first_process != os.getpid():
        raise RuntimeError(
            "this process was forked from one that had used JAX, whose threads a fork leaves behind: it would hang; "
            'make the pool by multiprocessing.get_context("spawn"), or before the first call; fits without a scene '
            "run in forked processes too"
        )


def afresh(*trees):
    """The trees with copies of their NumPy arrays.

    JAX 0.10 and 0.12 remember what they made of an array, and a float32 program that used it as a constant would leave
    that to a float64 one ("expected parameter of size 16 but got 8").
    """
    return jax.tree.map(lambda leaf: leaf.copy() if isinstance(leaf, np.ndarray) else leaf, trees)


def require_x64(what: str) -> None:
    """Raise RuntimeError inside a transformation that would round optical paths to float32."""
    if not jax.config.read("jax_enable_x64"):
        raise RuntimeError(
            f"{what} needs float64: a path of metres in float32 errs by a radian. "
            'Add jax.config.update("jax_enable_x64", True) before the first JAX call'
        )


def require_concrete(what: str, *trees) -> None:
    """Raise ValueError where a transformation hides the numbers that a choice needs."""
    if not is_concrete(*trees):
        raise ValueError(
            f"{what} needs numbers, but the scene or the camera is being traced by a JAX transformation; "
            "call it outside of jit, grad and vmap"
        )
