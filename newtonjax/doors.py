"""Doors: what a package lets others use, each name imported when somebody asks for it.

A door's names stand once, in the `__init__.pyi` beside its `__init__.py`, where type checkers read them:
`from newtonjax.scene.surfaces import Surface as Surface`, or `from newtonjax.numerics import chebyshev as chebyshev`
for a whole module. So the shell answers `--help` without JAX, and a room's files may import each other.
"""

import ast
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any


def door(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a package that is being imported."""
    home = homes(Path(str(sys.modules[package].__file__)).with_suffix(".pyi"))
    names = sorted(home)

    def get(name: str) -> Any:
        if name not in home:
            raise AttributeError(f"module {package!r} has no attribute {name!r}; it has {', '.join(names)}")
        if home[name] == package:
            return import_module(f"{package}.{name}")
        return getattr(import_module(home[name]), name)

    return get, lambda: sorted({*vars(sys.modules[package]), *names}), names


@cache
def homes(stub: Path) -> dict[str, str]:
    """The module that each name of a stub comes from; the package itself where the name is a module."""
    statements = ast.parse(stub.read_text(encoding="utf-8")).body
    return {
        name.name: str(statement.module)
        for statement in statements
        if isinstance(statement, ast.ImportFrom)
        for name in statement.names
    }
