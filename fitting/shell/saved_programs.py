"""Compiled programs kept between runs as machine code, which a fresh process loads instead of tracing it anew.

JAX's own cache keeps what the compiler makes; tracing and lowering remain, and take a large program longer than all of
its later calls. A saved program is a pickle and machine code: it is read only from a folder that is the user's alone,
and only by the versions, sources and kind of processor that made it. Where anything is amiss the program is compiled.
"""

import contextlib
import hashlib
import os
import pickle
import platform
import secrets
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax
from jax.core import Tracer

import newtonjax
from fitting.shell.ownership import is_ours

_CPUINFO = Path("/proc/cpuinfo")


class SavedProgram:
    """A jitted function of arrays whose compiled form for each kind of arguments is kept in a folder.

    `options`: of the compiler, those that the function was jitted with. Whatever goes wrong takes the function itself,
    traced arguments what it was made of.
    """

    def __init__(self, function: Any, folder: Path, options: dict[str, Any] | None = None):
        self._function, self._folder, self._options = function, folder, options
        self._programs: dict[Any, Callable | None] = {}

    def __call__(self, *arguments: Any) -> Any:
        leaves, tree = jax.tree.flatten(arguments)
        if any(isinstance(leaf, Tracer) for leaf in leaves):
            return self._function.__wrapped__(*arguments)  # a program within another may have no options
        kind = (tree, tuple((leaf.shape, leaf.dtype.str) for leaf in leaves))
        if kind not in self._programs:
            self._programs[kind] = self._loaded(kind, arguments) or self._compiled(kind, arguments)
        program = self._programs[kind]
        if program is None:
            return self._function(*arguments)
        try:
            return jax.block_until_ready(program(*arguments))
        except Exception:  # what a stale program raises is not documented
            self._programs[kind] = None
            self._path(kind).unlink(missing_ok=True)
            return self._function(*arguments)

    def _path(self, kind: tuple) -> Path:
        name = (self._function.__module__, self._function.__qualname__)
        digest = hashlib.sha256(repr((_machine(), _sources(), name, self._options, kind)).encode())
        return self._folder / f"{digest.hexdigest()[:32]}.program"

    def _loaded(self, kind: tuple, arguments: tuple) -> Callable | None:
        from jax.experimental.serialize_executable import deserialize_and_load

        path = self._path(kind)
        try:
            if not is_ours(self._folder) or not is_ours(path):
                return None
            code, result = pickle.loads(path.read_bytes())  # noqa: S301 (a file of the user's own, see above)
            return deserialize_and_load(code, jax.tree.structure((arguments, {})), jax.tree.structure(result))
        except Exception:  # no such file, another layout, a program that this processor cannot run
            return None

    def _compiled(self, kind: tuple, arguments: tuple) -> Callable | None:
        """The program for these arguments, and its file, if one can be written that gives the same again."""
        from jax.experimental.serialize_executable import deserialize_and_load, serialize

        # Under a name of its own: one out of JAX's cache, which has lost a part, cannot be saved.
        name = f"{self._function.__name__}_{secrets.token_hex(8)}"
        fresh = _named(self._function.__wrapped__, name)  # JAX refuses options of a program within a program
        try:
            program = jax.jit(fresh, compiler_options=self._options).lower(*arguments).compile()
            code, in_tree, out_tree = serialize(program)
            result = jax.tree.unflatten(out_tree, range(out_tree.num_leaves))
            jax.block_until_ready(deserialize_and_load(code, in_tree, out_tree)(*arguments))
        except Exception:  # not every backend can
            return None
        with contextlib.suppress(OSError):
            self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            neighbour = self._folder / f".{os.getpid()}.{secrets.token_hex(8)}.part"
            neighbour.write_bytes(pickle.dumps((code, result)))
            neighbour.chmod(0o600)
            os.replace(neighbour, self._path(kind))
        return program


def _named(function: Any, name: str) -> Callable:
    def fresh(*arguments):
        return function(*arguments)

    fresh.__name__ = name
    return fresh


@cache
def _machine() -> tuple:
    """What a program was made by and for."""
    text = _CPUINFO.read_text(encoding="utf-8", errors="replace") if _CPUINFO.is_file() else platform.node()
    kinds = sorted({line for line in text.splitlines() if line.startswith(("model name", "flags", "Features", "CPU"))})
    flags = sorted(
        item for item in os.environ.items() if item[0].startswith(("XLA_", "JAX_")) and "CACHE" not in item[0]
    )
    made_by = (jax.__version__, version("jaxlib"), newtonjax.__version__, platform.python_version())
    return (*made_by, platform.machine(), os.cpu_count(), kinds or text, flags)


@cache
def _sources() -> str:
    """A digest of the simulator's source: a program of another text is another one."""
    digest = hashlib.sha256()
    for path in sorted(Path(newtonjax.__file__).parent.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()
