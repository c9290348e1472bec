"""Who may import whom, how long a file may be, and what the shell may load: read from the source."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("newtonjax", "fitting")
FILES = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]
SIMULATOR = {"equinox", "jax", "jaxtyping", "matplotlib", "msgspec", "newtonjax", "numpy", "tomli_w"}
HEAVY = ("equinox", "jax", "matplotlib", "numpy", "pint", "scipy", "skimage")
RARE = ("corner", "emcee", "h5py", "imageio", "matplotlib", "pint", "png", "rich", "skimage", "tifffile")


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


TREES = {module_name(path): ast.parse(path.read_text(encoding="utf-8")) for path in FILES}


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


def exports(package: str) -> dict[str, str]:
    """The lazy exports of a package: name to module, from its `_HOME` table."""
    for node in ast.walk(TREES.get(package, ast.Module([], []))):
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "_HOME" for t in node.targets):
            return {name: f"{package}.{home}" for name, home in ast.literal_eval(node.value).items()}
    return {}


def edges(package: str) -> dict[str, set[str]]:
    """Imports inside one package; a lazily exported name leads to the module that holds it."""
    home = {f"{package}.{name}": module for name, module in exports(package).items()}
    modules = {name for name in TREES if name == package or name.startswith(f"{package}.")}
    return {
        name: {target for found in imported(TREES[name]) if (target := home.get(found, found)) in modules - {package}}
        for name in modules
    }


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


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_inside_a_package_point_one_way(package):
    graph, done = edges(package), set()

    def visit(name, way):
        assert name not in way, f"imports in a circle: {' -> '.join((*way, name))}"
        if name not in done:
            for target in sorted(graph[name]):
                visit(target, (*way, name))
            done.add(name)

    for name in graph:
        visit(name, ())


@pytest.mark.parametrize("package", PACKAGES)
def test_what_a_package_exports_exists(package):
    for name, module in exports(package).items():
        assert module in TREES, f"{package} exports {name} from {module}, which is not there"
        names = {node.name for node in TREES[module].body if isinstance(node, ast.ClassDef | ast.FunctionDef)}
        targets = {
            target.id
            for node in TREES[module].body
            if isinstance(node, ast.Assign)
            for target in node.targets
            if isinstance(target, ast.Name)
        }
        assert name in names | targets, f"{package} exports {name} from {module}, which does not define it"


@pytest.mark.parametrize("path", FILES, ids=module_name)
def test_a_file_is_short_and_named_for_what_it_holds(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 300
    assert path.stem not in {"utils", "util", "helpers", "misc", "common"}


@pytest.mark.parametrize("name", sorted(TREES))
def test_no_package_asserts_where_it_should_refuse(name):
    assert not [node.lineno for node in ast.walk(TREES[name]) if isinstance(node, ast.Assert)]


def test_help_comes_without_the_heavy_imports():
    program = (
        "import sys; from fitting.cli import main; code = main(['--help']); "
        f"heavy = [name for name in {HEAVY!r} if name in sys.modules]; "
        "sys.exit(f'loaded {heavy}' if heavy else code)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert "fit" in done.stdout


@pytest.mark.parametrize("verb", ["fit_verb", "render_verb"])
def test_a_verb_is_ready_without_what_only_a_picture_or_a_chain_needs(verb):
    program = (
        f"import sys; from fitting import cli, {verb}, measure; cli.quantities.length('2um'); "
        f"rare = [name for name in {RARE!r} if name in sys.modules]; sys.exit(f'loaded {{rare}}' if rare else 0)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", "experiments/README.md"])
def test_every_file_that_a_page_links_to_is_there(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in link]
    assert not [link for link in links if not (ROOT / page).parent.joinpath(link).exists()]
