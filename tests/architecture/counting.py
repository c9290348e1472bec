"""Figures of the source: rooms and the arrows between them, vague names, numbers by position, the way of a photograph.

    python tests/architecture/counting.py [ROOT] [--way PHOTOGRAPH]

Nothing of the project is imported, but for the way, which one run of the verb `fit` in this process takes.
"""

import argparse
import ast
import os
import sys
from collections import defaultdict
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

from line_figures import deep_comprehensions, line_figures, raises

PACKAGES = ("newtonjax", "fitting")
SHORT = frozenset(("found", "told", "left", "made", "known", "kept", "given"))
LONG = SHORT.union(
    ("one", "other", "others", "here", "there", "whole", "away", "both", "own", "seen", "rest", "wrong"),
    ("far", "moved", "full", "more", "good", "alone", "lost", "said", "drawn", "shown", "tried", "wanted"),
    ("taken", "off"),
)
# Names of vectors and matrices whose places are numbers of the fit.
VECTORS = frozenset(("free", "numbers", "covariance", "jacobian"))
# The one file that may know their order.
VECTOR_FILE = "fitting.parameters.vector"


class Source:
    """The modules of both packages, and what their doors export: name to the module that holds it."""

    def __init__(self, root: Path):
        self.trees: dict[str, ast.Module] = {}
        self.doors: dict[str, dict[str, str]] = {}
        for path in (path for package in PACKAGES for path in sorted((root / package).rglob("*.py"))):
            parts = path.relative_to(root).with_suffix("").parts
            tree = ast.parse(path.read_text(encoding="utf-8"))
            if parts[-1] != "__init__":
                self.trees[".".join(parts)] = tree
                continue
            self.doors[".".join(parts[:-1])] = _exports(".".join(parts[:-1]), path, tree)

    def module_of(self, module: str, name: str) -> str | None:
        """The module that `from module import name` ends at, through doors; None outside of the packages."""
        if module in self.trees:
            return module
        target = self.doors.get(module, {}).get(name)
        if target == module or f"{module}.{name}" in self.trees:
            return f"{module}.{name}"
        return None if target is None else self.module_of(target, name)

    @cached_property
    def arrows(self) -> set[tuple[str, str]]:
        """(importer, imported) modules, each pair once, imports in functions and lazily exported attributes too."""
        pairs = set()
        for module, tree in self.trees.items():
            aliases = {}
            for node in ast.walk(tree):
                if isinstance(node, ast.ImportFrom):
                    pairs |= {(module, self.module_of(str(node.module), alias.name)) for alias in node.names}
                elif isinstance(node, ast.Import):
                    aliases |= {alias.asname or alias.name: alias.name for alias in node.names}
            for node in ast.walk(tree):
                if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in aliases:
                    pairs.add((module, self.module_of(aliases[node.value.id], node.attr)))
        return {(one, other) for one, other in pairs if other and one != other}

    def room_arrows(self, package: str) -> set[tuple[str, str]]:
        """(importer, imported) rooms of one package, each pair once."""
        pairs, rooms = {tuple(map(room_of, pair)) for pair in self.arrows}, self.rooms(package)
        return {
            (importer, imported)
            for importer, imported in pairs
            if importer != imported and {importer, imported} <= rooms
        }

    def rooms(self, package: str) -> set[str]:
        """The rooms of a package."""
        return {door for door in self.doors if door.startswith(f"{package}.")}

    def past_doors(self) -> list[str]:
        """Imports of a room's inside, or of what its door does not let through, from without.

        A file that stands in no room has no door.
        """
        reaches = []
        for module, node in self._imports():
            for alias in node.names:
                target = self.module_of(str(node.module), alias.name)
                if target is None or room_of(target) in (room_of(module), target):
                    continue
                listed = node.module in self.doors and alias.name in self.doors[node.module]
                if not listed or alias.name.startswith("_"):
                    reaches.append(f"{module}:{node.lineno} from {node.module} import {alias.name}")
        return reaches

    def own_doors(self) -> list[str]:
        """Names that a file takes through the door of its own room or package: a circle at import."""
        return [
            f"{module}:{node.lineno} from {node.module} import {alias.name}"
            for module, node in self._imports()
            for alias in node.names
            if node.module in (room_of(module), module.split(".")[0])
            and f"{node.module}.{alias.name}" not in self.trees
            and not alias.name.startswith("__")
        ]

    def shadows(self) -> list[str]:
        """Names of a door that are also files or rooms behind it: the second access would return the module."""
        inside = {*self.trees, *self.doors}
        return [
            f"{door}.{name}"
            for door, names in self.doors.items()
            for name, target in names.items()
            if f"{door}.{name}" in inside and target != door
        ]

    def _imports(self) -> Iterator[tuple[str, ast.ImportFrom]]:
        for module, tree in self.trees.items():
            for node in ast.walk(tree):
                if isinstance(node, ast.ImportFrom) and str(node.module).split(".")[0] in PACKAGES:
                    yield module, node

    def functions(self, package: str) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
        """Every function of a package, methods and nested ones too."""
        for module, tree in self.trees.items():
            if module.startswith(f"{package}."):
                yield from (x for x in ast.walk(tree) if isinstance(x, ast.FunctionDef | ast.AsyncFunctionDef))

    def vague(self, package: str, words: frozenset[str] = LONG, parameters: bool = True) -> tuple[int, int]:
        """Functions that bind a vague name, locals or parameters, and all functions."""
        bound = [_bound(function, parameters) for function in self.functions(package)]
        return sum(bool(names & words) for names in bound), len(bound)

    def positions(self) -> list[str]:
        """Lines that address a number of the fit by a literal place."""
        return [
            f"{module}:{node.lineno} {ast.unparse(node)}"
            for module, tree in self.trees.items()
            if module.startswith("fitting.") and module != VECTOR_FILE
            for node in ast.walk(tree)
            if isinstance(node, ast.Subscript) and _is_vector(node.value) and _has_place(node.slice)
        ]


def _exports(door: str, path: Path, tree: ast.Module) -> dict[str, str]:
    """Of the stub beside a door's file; of its table `_HOME` where there is no stub."""
    stub = path.with_suffix(".pyi")
    if stub.is_file():
        body = ast.parse(stub.read_text(encoding="utf-8")).body
        return {name.name: str(node.module) for node in body if isinstance(node, ast.ImportFrom) for name in node.names}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and any(isinstance(x, ast.Name) and x.id == "_HOME" for x in node.targets):
            return {name: f"{door}.{home}" for name, home in ast.literal_eval(node.value).items()}
    return {}


def room_of(module: str) -> str:
    """The package and the room of a module."""
    return ".".join(module.split(".")[:2])


def circle(pairs: set[tuple[str, str]]) -> list[str]:
    """A way that ends where it began, empty if there is none."""
    graph, done = defaultdict(set), set()
    for one, other in pairs:
        graph[one].add(other)

    def visit(name: str, way: tuple[str, ...]) -> list[str]:
        if name in way:
            return [*way[way.index(name) :], name]
        if name not in done:
            done.add(name)
            for target in sorted(graph[name]):
                if closed := visit(target, (*way, name)):
                    return closed
        return []

    return next((closed for name in sorted(graph) if (closed := visit(name, ()))), [])


def _bound(function: ast.FunctionDef | ast.AsyncFunctionDef, parameters: bool) -> set[str]:
    """Names that a function binds, those of nested functions apart."""
    names, waiting = set(), list(function.body)
    if parameters:
        taken = function.args
        every = (*taken.posonlyargs, *taken.args, *taken.kwonlyargs, taken.vararg, taken.kwarg)
        names |= {argument.arg for argument in every if argument}
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            continue
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        waiting += ast.iter_child_nodes(node)
    return names


def _is_vector(node: ast.expr) -> bool:
    if isinstance(node, ast.Attribute) and node.attr == "at":
        return _is_vector(node.value)
    name = node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""
    return name in VECTORS or (isinstance(node, ast.Attribute) and ast.unparse(node) == "unknowns.model")


def _has_place(node: ast.expr) -> bool:
    if isinstance(node, ast.Tuple):
        return any(map(_has_place, node.elts))
    if isinstance(node, ast.Slice):
        return any(map(_has_place, filter(None, (node.lower, node.upper))))
    if isinstance(node, ast.UnaryOp):
        return _has_place(node.operand)
    return isinstance(node, ast.Constant) and isinstance(node.value, int)


def way_of(root: Path, photograph: Path) -> list[tuple[str, str]]:
    """(file, function) in the order of first calls while the verb `fit` measures a photograph, in this thread.

    Wants a fresh process: what JAX has traced before is not called again. Class bodies, lambdas and comprehensions are
    left out.
    """
    sys.path.insert(0, str(root))
    rooms = (root / "fitting" / "shell").is_dir()
    main = __import__("fitting.shell.cli" if rooms else "fitting.cli", fromlist=["main"]).main
    order: dict[tuple[str, str], None] = {}
    classes: dict[str, set[str]] = {}
    # Kept, so that no other code comes to bear a number of theirs.
    visited: dict[int, object] = {}

    def classes_of(file: str) -> set[str]:
        if file not in classes:
            tree = ast.parse(Path(root, file).read_text(encoding="utf-8"))
            classes[file] = {node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}
        return classes[file]

    def record(frame, event, _):
        if event != "call" or id(frame.f_code) in visited:
            return
        visited[id(frame.f_code)] = frame.f_code
        file, name = os.path.relpath(frame.f_code.co_filename, root), frame.f_code.co_qualname
        if (
            not file.startswith(("fitting/", "newtonjax/"))
            or file.endswith("__init__.py")
            or "<" in name.split(".")[-1]
        ):
            return
        if "<lambda>" not in name and "<genexpr>" not in name and name.split(".")[-1] not in classes_of(file):
            order.setdefault((file, name))

    sys.setprofile(record)
    try:
        main(["fit", str(photograph), "--wavelength", "sodium", "--pixel-size", "12.75um"])
    finally:
        sys.setprofile(None)
    return list(order)


def stops_and_returns(way: list[tuple[str, str]]) -> tuple[int, int]:
    """How often the next function stands in another file, and how often in one that was visited before."""
    files = [file for file, _ in way if file != "newtonjax/doors.py"]
    changes = [place for place in range(1, len(files)) if files[place] != files[place - 1]]
    return len(changes), sum(files[place] in files[:place] for place in changes)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).resolve().parents[2])
    parser.add_argument("--way", type=Path, help="the photograph to follow")
    options = parser.parse_args()
    source = Source(options.root.resolve())
    arrows = source.arrows
    for package in PACKAGES:
        inside = {pair for pair in arrows if all(name.startswith(f"{package}.") for name in pair)}
        modules = sum(name.startswith(f"{package}.") for name in source.trees)
        print(f"{package}: {modules} modules, {len(inside)} arrows; {len(source.rooms(package))} rooms, ", end="")
        between = len(source.room_arrows(package)) if source.rooms(package) else 0
        print(f"{between} arrows; circles: {circle(inside) or 'none'}")
        for name, words, parameters in (
            ("short list", SHORT, False), ("short list, parameters too", SHORT, True),
            ("long list", LONG, False), ("long list, parameters too", LONG, True),
        ):  # fmt: skip
            vague, functions = source.vague(package, words, parameters)
            print(f"  vague names, {name}: {vague} of {functions} functions, {100 * vague / functions:.1f} %")
        trees = [tree for name, tree in source.trees.items() if name.startswith(f"{package}.")]
        figures, raising = line_figures(options.root.resolve(), package), [n for n in map(raises, trees) if n]
        print(f"  {figures.lines} lines, {figures.comment_percent:.1f} % comments, ", end="")
        print(f"{figures.average:.1f} characters to a line of code")
        print(f"  {sum(raising)} raises in {len(raising)} files; ", end="")
        print(f"{sum(len(deep_comprehensions(tree)) for tree in trees)} comprehensions of three levels")
    crossing = {(room_of(one), room_of(other)) for one, other in arrows if one[0] == "f" and other[0] == "n"}
    print(f"fitting to newtonjax: {len(crossing)} arrows")
    past, own, shadows = source.past_doors(), source.own_doors(), source.shadows()
    print(f"past doors: {len(past)}, own doors: {len(own)}, shadows: {len(shadows)}")
    places = source.positions()
    print(f"numbers by position: {len(places)} in {len({place.split(':')[0] for place in places})} files")
    if options.way:
        way = way_of(options.root.resolve(), options.way)
        stops, returns = stops_and_returns(way)
        print(f"way: {len(way)} functions, {len({file for file, _ in way})} files, {stops} stops, {returns} returns")


if __name__ == "__main__":
    main()
