"""Where the pages send who extends the project: the files and names of code there exist."""

import ast
import builtins
import re
from functools import cache
from importlib import import_module
from operator import attrgetter
from pathlib import Path

import pytest
from counting import PACKAGES
from test_architecture import NO_ROOM, ROOT

CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
EXTENDING = (ROOT / "docs/extending.md").read_text(encoding="utf-8")
TO_ADD = CONTRIBUTING.split("**To add something**")[1].split("\n\n**")[0]
# Rows of tables one by one, and paragraphs; blocks of code run in a test of their own.
PROSE = re.sub(r"```.*?```", "", EXTENDING, flags=re.S).replace("\n|", "\n\n|")
LINES = [
    " ".join(text.split()) for text in (TO_ADD.replace("\n|", "\n\n|") + "\n\n" + PROSE).split("\n\n") if "`" in text
]
# Words in backticks that are no names of ours: of the page, and of Python.
OUTSIDE = {"accept", "gettext", *dir(builtins)}
FILES = [path for folder in (*PACKAGES, "tests", "experiments") for path in sorted((ROOT / folder).rglob("*.py"))]


@cache
def names_in(path: Path) -> frozenset[str]:
    """What a file defines: classes, functions, their arguments, and all that is assigned; members after a dot."""
    tree, names = ast.parse(path.read_text(encoding="utf-8")), set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            names |= {f"{node.name}.{member}" for statement in node.body for member in assigned_or_defined(statement)}
        if isinstance(node, ast.arg):
            names.add(node.arg)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
    return frozenset(names)


def assigned_or_defined(statement: ast.stmt) -> set[str]:
    if isinstance(statement, ast.FunctionDef):
        return {statement.name}
    return {node.id for node in ast.walk(statement) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}


def places_in(line: str) -> list[tuple[str, list[Path]]]:
    """Each file or folder that a line names, and where it may be: bare names are of folders that the line names."""
    quoted = re.findall(r"`([^`]+)`", line)
    paths = [text for text in quoted if re.fullmatch(r"[\w/]+/[\w.]+|[\w/]+\.\w+", text) and "NAME" not in text]
    paths = [text for text in paths if "/" in text or re.search(r"\.(py|pyi|toml|md)$", text)]
    folders = {ROOT / text if (ROOT / text).is_dir() else (ROOT / text).parent for text in quoted if "/" in text}
    return [(text, [(folder / text) for folder in ({ROOT} if "/" in text else folders)]) for text in paths]


def exists(name: str) -> bool:
    """Whether code of ours defines a name; one that ends with an underscore begins others."""
    package, _, attribute = name.partition(".")
    if package in PACKAGES:
        return attrgetter(attribute)(import_module(package)) is not None if attribute else True
    if name.endswith("_"):
        return any(defined.startswith(name) for path in FILES for defined in names_in(path))
    return name in OUTSIDE or any(name in names_in(path) or name == path.stem for path in FILES)


@pytest.mark.parametrize("line", LINES, ids=lambda line: line[:30])
def test_a_page_for_who_extends_names_files_that_exist(line):
    assert not [text for text, paths in places_in(line) if not any(path.exists() for path in paths)]


@pytest.mark.parametrize("line", LINES, ids=lambda line: line[:30])
def test_a_page_for_who_extends_names_code_that_exists(line):
    quoted = [re.sub(r"\(.*\)$", "", text) for text in re.findall(r"`([^`]+)`", line)]
    names = [text for text in quoted if re.fullmatch(r"[A-Za-z_][\w.]*", text) and not re.search(r"\.\w{2,4}$", text)]
    names += [text for text in quoted if re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w+)+", text)]
    is_file = {text for text, _ in places_in(line)} | {text for text in quoted if "NAME" in text}
    assert not [name for name in names if name not in is_file and not exists(name)]


@pytest.mark.parametrize("line", LINES, ids=lambda line: line[:30])
def test_a_name_is_in_the_file_that_a_page_says(line):
    places = dict(places_in(line))
    pairs = re.findall(r"`([A-Za-z_]\w+)` (?:in |of |\()`([\w/]+\.py)`", line)
    for name, file in pairs:
        assert any(path.exists() and name in names_in(path) for path in places[file]), f"{name} in {file}"


def test_the_contributors_page_names_the_files_that_stand_in_no_room():
    rooms = CONTRIBUTING.split("**Rooms.**")[1].split("| `newtonjax`")[0]
    assert not [module for module in NO_ROOM if f"{module.rpartition('.')[2]}.py`" not in rooms]
