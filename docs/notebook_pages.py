"""Pages of the manual out of its notebooks: each is run, and what its cells print and draw stands below them.

A notebook is a script whose cells begin with `# %%`, which Jupyter (by jupytext), VS Code and Spyder open as one. This
file writes docs/notebooks/*.md, with their pictures.
"""

import ast
import io
import re
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

NOTEBOOKS = Path(__file__).parent / "notebooks"
_CELL = re.compile(r"^# %%( \[markdown\])?\n", re.MULTILINE)


def cells_of(notebook: Path) -> list[tuple[str, str]]:
    """The kind ("markdown" or "code") and the text of each cell."""
    _, *parts = _CELL.split(notebook.read_text(encoding="utf-8"))
    pairs = zip(parts[::2], parts[1::2], strict=True)
    return [("markdown", re.sub(r"^# ?", "", text, flags=re.MULTILINE).strip()) if mark else ("code", text.strip())
            for mark, text in pairs]  # fmt: skip


def page_of(notebook: Path, folder: Path) -> str:
    """The notebook in Markdown; its pictures are written into the folder."""
    names: dict[str, Any] = {"__name__": "__main__"}
    lines = []
    for number, (kind, text) in enumerate(cells_of(notebook)):
        if kind == "markdown":
            lines.append(text)
            continue
        with redirect_stdout(io.StringIO()) as printed:
            shown = _run(text, names, notebook.name)
        lines.append(f"```python\n{text}\n```")
        if printed.getvalue():
            lines.append(f"```text\n{printed.getvalue().rstrip()}\n```")
        if hasattr(shown, "savefig"):
            picture = f"{notebook.stem}_{number}.png"
            shown.savefig(folder / picture, dpi=70)
            lines.append(f"![What the cell draws]({picture})")
    return "\n\n".join(lines) + f"\n\n[This notebook]({notebook.name}) as a script, which Jupyter opens by jupytext.\n"


def _run(cell: str, names: dict[str, Any], file: str) -> Any:
    """Run a cell; the value of its last line where that is an expression, as a notebook shows it."""
    *before, last = ast.parse(cell).body
    is_expression = isinstance(last, ast.Expr)
    exec(compile(ast.Module(before if is_expression else [*before, last], []), file, "exec"), names)  # noqa: S102
    return eval(compile(ast.Expression(last.value), file, "eval"), names) if is_expression else None  # noqa: S307


if __name__ == "__main__":
    import matplotlib as mpl

    mpl.use("agg")
    for path in sorted(NOTEBOOKS.glob("*.py")):
        path.with_suffix(".md").write_text(page_of(path, NOTEBOOKS), encoding="utf-8")
