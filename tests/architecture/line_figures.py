"""Figures of lines: how many are comments, how long those of code are, comprehensions that nobody reads at once."""

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


class LineFigures(NamedTuple):
    """Of a package: lines; those that are comments alone; those of code, docstrings left out, and their characters.

    A comment at the end of a line counts as code. Characters include the indent, as in the figures of other projects.
    """

    lines: int
    comments: int
    code: int
    characters: int

    @property
    def comment_percent(self) -> float:
        """Comments among all lines but those of docstrings and blank ones."""
        return 100 * self.comments / (self.comments + self.code)

    @property
    def average(self) -> float:
        """Characters to a line of code."""
        return self.characters / self.code


def line_figures(root: Path, package: str) -> LineFigures:
    """The figures of all files of a package."""
    lines = comments = code = characters = 0
    for path in (root / package).rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        documented = set(_docstring_lines(ast.parse(text)))
        for number, line in enumerate(text.splitlines(), 1):
            lines += 1
            if not line.strip() or number in documented:
                continue
            if line.lstrip().startswith("#"):
                comments += 1
            else:
                code, characters = code + 1, characters + len(line)
    return LineFigures(lines, comments, code, characters)


def _docstring_lines(tree: ast.Module) -> Iterator[int]:
    for node in ast.walk(tree):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node) is not None:
            yield from range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1)


def deep_comprehensions(tree: ast.Module) -> list[int]:
    """Lines of comprehensions with three levels: in each other, or of as many loops."""
    every = [node for node in ast.walk(tree) if isinstance(node, COMPREHENSIONS)]
    return [node.lineno for node in every if len(node.generators) > 2 or _depth(node) > 2]


def _depth(node: ast.AST) -> int:
    inner = max(map(_depth, ast.iter_child_nodes(node)), default=0)
    return inner + isinstance(node, COMPREHENSIONS)


def raises(tree: ast.Module) -> int:
    """Statements that raise something of their own."""
    return sum(isinstance(node, ast.Raise) and node.exc is not None for node in ast.walk(tree))
