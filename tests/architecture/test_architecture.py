"""Rooms and their doors, who may import whom, how long a file may be, what the shell may load: read from the source."""

import ast
import subprocess
import sys
from importlib import import_module
from operator import attrgetter
from pathlib import Path

import pytest
from counting import PACKAGES, Source, circle, room_of, stops_and_returns
from line_figures import deep_comprehensions, line_figures

ROOT = Path(__file__).resolve().parents[2]
SOURCE = Source(ROOT)
TREES, DOORS = SOURCE.trees, SOURCE.doors
FILES = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]
# The simulator's packages; imageio is of a photograph's JPEG alone.
SIMULATOR = {"equinox", "imageio", "jax", "jaxtyping", "matplotlib", "msgspec", "newtonjax", "numpy", "tomli_w"}
HEAVY = ("equinox", "jax", "matplotlib", "numpy", "pint", "scipy", "skimage")
RARE = ("corner", "emcee", "h5py", "imageio", "matplotlib", "pint", "png", "rich", "skimage", "tifffile")
# Rooms and arrows between them, and the longest chain of rooms: no more than these.
ROOMS = {"newtonjax": 8, "fitting": 13}
ARROWS = {"newtonjax": 21, "fitting": 29}
# Outside of all rooms stand only what the doors themselves are made of, and the tables of the texts that every room
# may state: they hold no code, and count for no arrow.
NO_ROOM = {
    "newtonjax.doors",
    "fitting.reasons",
    "fitting.sheet_reasons",
    "fitting.plate_reasons",
    "fitting.pieces",
    "fitting.wordings",
}


def imported(tree: ast.AST) -> set[str]:
    """Every module named by an import statement at any depth; `from a import b` gives a and a.b."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports name their package in full"
            names |= {node.module or ""} | {f"{node.module}.{alias.name}" for alias in node.names}
    return names


@pytest.mark.parametrize("package", PACKAGES)
def test_rooms_and_the_arrows_between_them_are_few(package):
    assert len(SOURCE.rooms(package)) <= ROOMS[package]
    assert len(SOURCE.room_arrows(package)) <= ARROWS[package]


@pytest.mark.parametrize("package", PACKAGES)
def test_the_contributors_page_shows_the_rooms_and_their_arrows(package):
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = text.split(f"| `{package}` | holds | imports |\n|---|---|---|\n")[1].split("\n\n")[0]
    rows = [[cell.strip() for cell in row.strip("|").split("|")] for row in table.splitlines()]
    assert {f"{package}.{name.strip('`')}" for name, _, _ in rows} == SOURCE.rooms(package)
    shown = {(name.strip("`"), other) for name, _, others in rows for other in others.split(", ") if other}
    assert shown == {(one.split(".")[1], other.split(".")[1]) for one, other in SOURCE.room_arrows(package)}


def test_every_file_stands_in_a_room():
    # A folder in a room belongs to the room, and has no door.
    assert {module for module in TREES if module.count(".") < 2} == NO_ROOM
    assert {door for door in DOORS if door.count(".") > 1} == set()


def test_nobody_reaches_past_a_door():
    assert SOURCE.past_doors() == []


def test_no_file_goes_through_the_door_of_its_own_room():
    assert SOURCE.own_doors() == []


def test_no_room_or_file_bears_a_name_that_its_door_exports():
    assert SOURCE.shadows() == []


@pytest.mark.parametrize("package", PACKAGES)
def test_neither_rooms_nor_files_import_each_other_in_a_circle(package):
    assert circle(SOURCE.room_arrows(package)) == []
    assert circle(SOURCE.arrows) == []


@pytest.fixture(scope="module")
def imports_of_doors():
    """For each door (room of the importer, name) of every import through it."""
    imports = {door: set() for door in DOORS}
    for importer, tree in TREES.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module in imports:
                imports[node.module] |= {(room_of(importer), alias.name) for alias in node.names}
    return imports


@pytest.mark.parametrize("door", sorted(DOORS))
def test_a_door_exports_what_is_there_and_what_others_use(door, imports_of_doors):
    names = DOORS[door]
    module = import_module(door)
    assert sorted(names) == module.__all__
    assert all(getattr(module, name) is not None for name in names)
    if door not in PACKAGES:
        used = {name for room, name in imports_of_doors[door] if room != door}
        public = {name for name, home in DOORS[door.split(".")[0]].items() if home == door}
        assert set(names) == used | public


def test_a_door_names_what_it_has_where_a_name_is_not_there():
    with pytest.raises(AttributeError, match=r"module 'newtonjax' has no attribute 'rendr'; it has .*render"):
        attrgetter("rendr")(import_module("newtonjax"))
    assert "render" in dir(import_module("newtonjax"))


@pytest.mark.parametrize("name", [name for name in TREES if name.split(".")[0] == "newtonjax"])
def test_the_simulator_imports_only_its_own_few_packages(name):
    outside = {target.split(".")[0] for target in imported(TREES[name])} - set(sys.stdlib_module_names)
    assert outside <= SIMULATOR


@pytest.mark.parametrize("name", sorted(TREES))
def test_nobody_imports_the_experiments_or_the_tests(name):
    assert not {target.split(".")[0] for target in imported(TREES[name])} & {"experiments", "tests"}


def test_the_fitting_layer_stands_on_the_simulator():
    fitting = {target for name, tree in TREES.items() if name.split(".")[0] == "fitting" for target in imported(tree)}
    assert any(target.split(".")[0] == "newtonjax" for target in fitting)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_file_is_short_and_named_for_what_it_holds(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 300
    assert path.stem not in {"utils", "util", "helpers", "misc", "common"}


@pytest.mark.parametrize("name", sorted(TREES))
def test_no_package_asserts_where_it_should_refuse(name):
    assert not [node.lineno for node in ast.walk(TREES[name]) if isinstance(node, ast.Assert)]


# Still to be brought down, so these may only fall. Functions with names that say how a value came about, parameters
# too, in percent (wanted: 8 in both); lines that address a number of the fit by its place (wanted: none).
VAGUE = {"newtonjax": 0.2, "fitting": 6.1}
POSITIONS = 0


@pytest.mark.parametrize("package", PACKAGES)
def test_vague_names_do_not_become_more(package):
    vague, functions = SOURCE.vague(package)
    assert 100 * vague / functions <= VAGUE[package]


def test_numbers_by_position_do_not_become_more():
    assert len(SOURCE.positions()) <= POSITIONS


# Percent of comments among lines of code and comments, at least, and characters to a line of code, at most. Other
# projects of this kind have 2.4 to 4.9 % and 38 to 45.
COMMENTS = {"newtonjax": 2.2, "fitting": 3.0}
CHARACTERS = {"newtonjax": 50.0, "fitting": 50.0}


@pytest.mark.parametrize("package", PACKAGES)
def test_comments_become_no_fewer_and_lines_no_longer(package):
    figures = line_figures(ROOT, package)
    assert round(figures.comment_percent, 1) >= COMMENTS[package]
    assert figures.average <= CHARACTERS[package]


@pytest.mark.parametrize("name", sorted(TREES))
def test_no_comprehension_has_three_levels(name):
    assert deep_comprehensions(TREES[name]) == []


# As far as it has come: docs/extending.md says what the limit is. Wanted were 45 and 20, for half the functions.
# 142 and 72 before the answer became a mean over sets of parts: priors, averages, clusters and starts on the phase are
# stations of their own; and 173 before the further lines of a lamp were one.
STOPS, RETURNS = 125, 46
FOLLOW = "import sys; sys.path.insert(0, sys.argv[1]); import counting, pathlib; "


def test_the_way_of_a_photograph_becomes_no_longer(shared):
    program = f"{FOLLOW}print(counting.way_of(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])))"
    photograph = shared / "photos" / "lens_1000mm_sodium.jpg"
    command = [sys.executable, "-c", program, str(Path(__file__).parent), str(ROOT), str(photograph)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    stops, returns = stops_and_returns(ast.literal_eval(done.stdout.splitlines()[-1]))
    assert 0 < returns <= RETURNS
    assert stops <= STOPS


def test_help_comes_without_the_heavy_imports():
    program = (
        "import sys; from fitting.shell.cli import main; code = main(['--help']); "
        f"heavy = [name for name in {HEAVY!r} if name in sys.modules]; "
        "sys.exit(f'loaded {heavy}' if heavy else code)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert "fit" in done.stdout


@pytest.mark.parametrize("verb", ["fit_verb", "render_verb"])
def test_a_verb_is_ready_without_what_only_a_picture_or_a_chain_needs(verb):
    program = (
        f"import sys; from fitting.photograph import measure; from fitting.shell import cli, quantities, {verb}; "
        f"quantities.length('2um'); "
        f"rare = [name for name in {RARE!r} if name in sys.modules]; sys.exit(f'loaded {{rare}}' if rare else 0)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
