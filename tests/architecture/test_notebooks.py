"""The notebooks of the manual: each runs as a script, and becomes a page with what its cells print and draw."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "docs/notebooks").glob("*.py"))
sys.path.insert(0, str(ROOT / "docs"))

from notebook_pages import cells_of, page_of  # noqa: E402


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])
def test_a_notebook_runs_and_becomes_a_page(notebook, tmp_path):
    text = page_of(notebook, tmp_path)
    assert text.startswith("# ")
    assert text.count("```python") == sum(kind == "code" for kind, _ in cells_of(notebook))
    assert "```text" in text
    pictures = list(tmp_path.glob("*.png"))
    assert pictures
    assert all(f"]({path.name})" in text for path in pictures)
    assert text.splitlines()[-1]


def test_each_notebook_is_in_the_manual():
    manual = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert len(NOTEBOOKS) == 4
    assert all(f"notebooks/{path.stem}.md" in manual for path in NOTEBOOKS)
