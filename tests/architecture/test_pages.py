"""The pages: links that lead somewhere, and Python that runs as it stands."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from skimage.io import imsave

ROOT = Path(__file__).resolve().parents[2]
DOCS = sorted(f"docs/{page.name}" for page in ROOT.glob("docs/*.md"))
PAGES = ["README.md", "CONTRIBUTING.md", "experiments/README.md", *DOCS]
# What a reader sees before anything else stays short.
LONGEST_README = 200


@pytest.mark.parametrize("page", PAGES)
def test_every_file_that_a_page_links_to_is_there(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in link]
    assert not [link for link in links if not (ROOT / page).parent.joinpath(link).exists()]


def test_the_readme_stays_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= LONGEST_README


@pytest.fixture(scope="module")
def photographs(tmp_path_factory) -> Path:
    """A folder with the files that the pages name."""
    folder = tmp_path_factory.mktemp("pages")
    sample = ROOT / "fitting/data/sample.png"
    shutil.copy(sample, folder / "rings.jpg")
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


def _codes(image: np.ndarray) -> np.ndarray:
    noise = np.random.default_rng(1).normal(0, 0.01, image.shape)
    return np.clip(np.round(255 * (image + noise)), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("page", ["README.md", "docs/usage.md"])
def test_the_python_of_a_page_runs_as_it_stands(page, photographs, monkeypatch, capsys):
    monkeypatch.chdir(photographs)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), flags=re.S)
    assert blocks
    names = {"__name__": "__main__"}
    for block in blocks:
        exec(compile(block, page, "exec"), names)  # noqa: S102  # the pages are our own
    assert capsys.readouterr().out
