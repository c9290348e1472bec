"""Doors: what a package lets others use, each name imported when somebody asks for it.

A door's names stand once, in the `__init__.pyi` beside its `__init__.py`, where type checkers read them:
`from newtonjax.scene.surfaces import Surface as Surface`, or `from newtonjax.numerics import chebyshev as chebyshev`
for a whole module. So the shell answers `--help` without JAX, and a room's files may import each other.

Of the library only what every process has loaded is imported before a name is asked for: until the command has its
own, Python's handler answers Ctrl-C with a traceback (`fitting/shell/entry.py`).
"""

from __future__ import annotations

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

# The module that each name of a package comes from, by package; the package itself where the name is a module.
_homes: dict[str, dict[str, str]] = {}


def door(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package that is being imported; the first gives `__all__` too."""

    def get(name: str) -> Any:
        home = _home(package)
        if name == "__all__":
            return sorted(home)
        if name not in home:
            raise AttributeError(f"module {package!r} has no attribute {name!r}; it has {', '.join(sorted(home))}")
        from importlib import import_module

        if home[name] == package:
            return import_module(f"{package}.{name}")
        return getattr(import_module(home[name]), name)

    return get, lambda: sorted({*vars(sys.modules[package]), *_home(package)})


def _home(package: str) -> dict[str, str]:
    if package not in _homes:
        import ast
        from pathlib import Path

        stub = Path(str(sys.modules[package].__file__)).with_suffix(".pyi")
        _homes[package] = {
            name.name: str(statement.module)
            for statement in ast.parse(stub.read_text(encoding="utf-8")).body
            if isinstance(statement, ast.ImportFrom)
            for name in statement.names
        }
    return _homes[package]
