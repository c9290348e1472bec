"""What is handed out: the wheel has both packages whole and nothing else, the sdist is lean, the wheel stands alone."""

import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("newtonjax", "fitting")


@pytest.fixture(scope="module")
def packed(tmp_path_factory) -> Path:
    """A folder with both archives."""
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "hatchling", "build", "-d", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def wheel(packed) -> zipfile.ZipFile:
    with zipfile.ZipFile(next(packed.glob("*.whl"))) as archive:
        yield archive


def sources(folder: str) -> set[str]:
    """The files of a folder that are no compiled code."""
    paths = (path for path in (ROOT / folder).rglob("*") if path.is_file())
    return {path.relative_to(ROOT).as_posix() for path in paths if path.suffix != ".pyc"}


def test_the_wheel_has_both_packages_whole_and_nothing_else(wheel):
    names = {name for name in wheel.namelist() if ".dist-info/" not in name and ".data/" not in name}
    assert names == sources("newtonjax") | sources("fitting")
    assert {f"{package}/py.typed" for package in PACKAGES} < names


def test_the_wheel_installs_the_manual_page_where_man_looks_for_it(wheel):
    (name,) = (name for name in wheel.namelist() if ".data/" in name)
    assert name.split(".data/")[1] == "data/share/man/man1/newtonjax.1"
    assert wheel.read(name) == (ROOT / "man/newtonjax.1").read_bytes()


def test_version_and_date_of_the_release_are_the_same_everywhere(wheel):
    version, date = re.findall(r"^## (\S+) \((\d{4}-\d\d-\d\d)\)$", read("CHANGELOG.md"), re.M)[0]
    assert f"newtonjax-{version}-" in Path(str(wheel.filename)).name
    assert f"\nversion: {version}\ndate-released: {date}\n" in read("CITATION.cff")


def read(name: str) -> str:
    """A file of the project."""
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_wheel_says_its_licence_and_its_command(wheel):
    texts = {name.split("/", 1)[1]: wheel.read(name).decode() for name in wheel.namelist() if ".dist-info/" in name}
    assert texts["licenses/LICENSE"] == (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert "newtonjax = fitting.shell.entry:main" in texts["entry_points.txt"]
    assert "Provides-Extra: cluster" in texts["METADATA"]


def test_the_sdist_has_what_builds_and_tests_it_without_the_results_of_experiments(packed):
    path = next(packed.glob("*.tar.gz"))
    with tarfile.open(path) as archive:
        names = {name.split("/", 1)[1] for name in archive.getnames()}
    results = {name for name in names if name.startswith("experiments/results/")}
    remaining = {Path(name).suffix or Path(name).name for name in results if "_before" not in name}
    assert remaining == {".md", ".gitignore"}
    assert "experiments/results/answer_before.json" in results
    needed = {
        "pyproject.toml",
        "Makefile",
        "Dockerfile",
        "man/newtonjax.1",
        "requirements.lock",
        "CITATION.cff",
        "LICENSE",
        "mkdocs.yml",
    }
    assert needed | sources("newtonjax") | sources("fitting") <= names
    assert {name for name in sources("tests") if name.endswith(".py")} <= names
    assert path.stat().st_size < 3e6


def test_the_command_runs_from_the_wheel_without_the_source_beside_it(wheel, tmp_path):
    site = tmp_path / "site"
    wheel.extractall(site)  # noqa: S202 (it was just made)
    program = (
        "import fitting, newtonjax; from fitting.shell.cli import main; "
        "print(fitting.__file__, newtonjax.__file__); raise SystemExit(main(['--help']))"
    )
    environment = os.environ | {"PYTHONPATH": str(site)}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path, env=environment)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0].count(str(site)) == 2
    assert "demo" in done.stdout
