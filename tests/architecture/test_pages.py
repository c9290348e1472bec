"""The pages: links that lead somewhere, and Python that runs as it stands."""

import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
from skimage.io import imread, imsave
from typer.main import get_command

from fitting.shell.cli import _one_by_one, app, main

ROOT = Path(__file__).resolve().parents[2]
# Pages of notebooks are made by `make docs`, and tested where the notebooks are (`test_notebooks.py`).
DOCS = sorted(
    page.relative_to(ROOT).as_posix() for page in ROOT.glob("docs/**/*.md") if page.parent.name != "notebooks"
)
PAGES = ["README.md", "CONTRIBUTING.md", "experiments/README.md", *DOCS]
# What a reader sees before anything else stays short.
LONGEST_README = 200


def text_of(page: str) -> str:
    """A page as it stands."""
    return (ROOT / page).read_text(encoding="utf-8")


def blocks_of(page: str, language: str) -> list[str]:
    """The code of a page that is marked as of a language."""
    return re.findall(rf"```{language}\n(.*?)```", text_of(page), flags=re.S)


def commands_of(page: str) -> list[list[str]]:
    """The arguments of each command of ours on a page."""
    lines = [line for line in text_of(page).splitlines() if line.lstrip().startswith("newtonjax ")]
    return [shlex.split(line, comments=True)[1:] for line in lines]


WITH_PYTHON = [page for page in ["README.md", *DOCS] if blocks_of(page, "python")]
WITH_SHELL = [page for page in DOCS if blocks_of(page, "sh")]


@pytest.mark.parametrize("page", PAGES)
def test_every_file_that_a_page_links_to_is_there(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in link]
    paths = [(ROOT / page).parent / link for link in links]
    sources = [path.with_suffix(".py") if path.parent.name == "notebooks" else path for path in paths]
    assert not [path for path in sources if not path.exists()]


def test_the_readme_stays_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= LONGEST_README


@pytest.fixture(scope="module")
def photographs(tmp_path_factory) -> Path:
    """A folder with the files that the pages name."""
    folder = tmp_path_factory.mktemp("pages")
    sample = ROOT / "fitting/data/sample.png"
    shutil.copy(sample, folder / "rings.jpg")
    imsave(folder / "rings_b.jpg", imread(sample)[::-1], check_contrast=False)
    y, x = np.mgrid[:300, :400]
    lines = [np.cos(2 * np.pi * (x * np.cos(t) + y * np.sin(t)) / 15.7) for t in (0.17, 0.17 + np.pi / 2)]
    imsave(folder / "reticle.jpg", _codes(0.5 + 0.2 * sum(np.tanh(5 * (line - 0.8)) for line in lines)))
    squared = ((x - 200.0) ** 2 + (y - 150.0) ** 2) * 3e-4
    frames = [_codes(0.5 - 0.3 * np.cos(2 * np.pi * (squared + turns))) for turns in (0.0, 0.1)]
    (folder / "photos").mkdir()
    for name in ("first.png", "second.png"):
        shutil.copy(sample, folder / "photos" / name)
    imsave(folder / "film.tif", np.stack(frames), check_contrast=False)
    return folder


@pytest.fixture
def desk(photographs, tmp_path, monkeypatch) -> Path:
    """A copy of these files for one page, which is where its code runs."""
    folder = shutil.copytree(photographs, tmp_path / "desk")
    monkeypatch.chdir(folder)
    return folder


def _codes(image: np.ndarray) -> np.ndarray:
    noise = np.random.default_rng(1).normal(0, 0.01, image.shape)
    return np.clip(np.round(255 * (image + noise)), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("page", WITH_PYTHON)
@pytest.mark.usefixtures("desk")
def test_the_python_of_a_page_runs_as_it_stands(page, capsys):
    blocks = blocks_of(page, "python")
    names = {"__name__": "__main__"}
    for block in blocks:
        exec(compile(block, page, "exec"), names)  # noqa: S102  # the pages are our own
    assert capsys.readouterr().out


@pytest.mark.parametrize("page", WITH_SHELL)
@pytest.mark.usefixtures("desk")
def test_the_commands_of_a_page_run_as_they_stand(page, capsys):
    for block in blocks_of(page, "sh"):
        for line in block.splitlines():
            name, *arguments = shlex.split(line, comments=True)
            assert (name, main(arguments)) == ("newtonjax", 0), line
    assert capsys.readouterr().out


@pytest.mark.parametrize("page", [page for page in PAGES if commands_of(page)])
def test_every_command_of_a_page_is_one_that_the_shell_takes(page):
    verbs = get_command(app).commands
    for verb, *arguments in commands_of(page):
        separated = _one_by_one(arguments)
        assert verbs[verb].make_context(verb, separated).params


def test_the_manual_has_every_page_once():
    manual = text_of("mkdocs.yml")
    assert not [page for page in DOCS if manual.count(f" {page.removeprefix('docs/')}\n") != 1]
