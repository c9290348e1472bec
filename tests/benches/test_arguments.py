"""The table of bench arguments: Python's signatures, TOML, the shell and docs/scene.toml say what it says."""

import inspect
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
import typer
from typer.testing import CliRunner

import newtonjax as nj
from fitting.shell.bench_options import option_name, with_bench_options
from newtonjax.benches.arguments import ARGUMENTS, BENCHES, arguments_of

SCENE_FILE = Path(__file__).resolve().parents[2] / "docs" / "scene.toml"


@pytest.mark.parametrize("bench", BENCHES)
def test_the_signature_has_the_names_order_and_defaults_of_the_table(bench):
    signature = inspect.signature(getattr(nj, bench))
    assert [(item.name, item.default) for item in arguments_of(bench)] == [
        (name, parameter.default) for name, parameter in signature.parameters.items()
    ]


@pytest.mark.parametrize("bench", BENCHES)
def test_the_docstring_names_every_argument(bench):
    text = getattr(nj, bench).__doc__
    if bench == "air_wedge":  # it refers to the other one for what they share
        text += nj.newton_rings.__doc__
    assert not [item.name for item in arguments_of(bench) if not re.search(rf"\b{item.name}\b", text)]


@pytest.mark.parametrize("bench", BENCHES)
def test_an_empty_table_in_a_file_is_the_bench_of_the_defaults(bench, tmp_path):
    (tmp_path / "a.toml").write_text(f"[{bench}]\n")
    scene, _ = nj.load_scene(tmp_path / "a.toml")
    for one, other in zip(jax.tree.leaves(scene), jax.tree.leaves(getattr(nj, bench)()), strict=True):
        np.testing.assert_array_equal(one, other)


def test_the_scene_file_of_the_docs_explains_every_argument_as_the_table_does(tmp_path):
    bench = SCENE_FILE.read_text(encoding="utf-8").split("[camera]")[0]
    section = re.findall(r"^(?:# )?(\w+) = .*?# (.*)$", bench, re.MULTILINE)
    assert section == [(item.name, item.help) for item in arguments_of("newton_rings")]
    # With what is commented out it is still a scene, but for a shield and a lens on so near a screen.
    text = re.sub(r"^# (?=polarization|beams)", "", SCENE_FILE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    (tmp_path / "scene.toml").write_text(text)
    assert len(nj.load_scene(tmp_path / "scene.toml")[0].beams) == 3


def options_of(arguments):
    """What the options of a verb with bench arguments make of a command line."""
    app, seen = typer.Typer(), []

    @app.command()
    @with_bench_options
    def verb(shape: int = 0, last: int = 1, **bench: Any) -> int:
        """A verb."""
        assert shape == 0
        seen.append(({name: value for name, value in bench.items() if value is not None}, last))
        return 0

    result = CliRunner().invoke(app, arguments)
    return seen[0] if seen else result.output


@pytest.mark.parametrize("argument", ARGUMENTS, ids=lambda item: f"{item.name} of {item.benches[0]}")
def test_an_option_reads_the_default_that_its_help_shows(argument):
    if argument.kind == "view" or argument.shown in ("none", "unpolarized", "the gap's two", "1 with a polarization"):
        return
    bench, _ = options_of([option_name(argument.name), argument.shown])
    (value,) = bench.values()
    expected = "gap" if argument.default == "gap" else pytest.approx(argument.default, rel=1e-12)
    assert getattr(value, "given", value) == expected


def test_options_are_what_was_given_in_si():
    text = "--lens-tilt 1mrad,-2deg --ambient-index 1.33 --beams R1,R2 --polarization-degree 0.5 --last 3"
    bench, last = options_of(text.split())
    expected = {"lens_tilt": (1e-3, -2 * np.pi / 180), "ambient_index": 1.33, "beams": ("R1", "R2")}
    assert bench == expected | {"polarization_degree": 0.5}
    assert last == 3
    assert "give two angles" in options_of(["--lens-tilt", "1mrad"])
    assert "water" in options_of(["--ambient-index", "wet"])
    assert "above zero" in options_of(["--plate-thickness", "0mm"])


def test_the_defaults_are_those_of_a_microscope():
    scene = nj.newton_rings()
    assert scene.view == nj.air_wedge().view == "reflected"
    assert scene.screen.vertex[2] == nj.newton_rings(1.0, 589.3e-9, 0.0, "reflected", screen="gap").screen.vertex[2]


def test_the_table_comes_without_jax():
    program = "import sys; from newtonjax.benches import ARGUMENTS; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


@pytest.mark.parametrize(
    ("bench", "names"), [("newton_rings", "lens_index now"), ("air_wedge", "lens_index and plate_index")]
)
def test_an_argument_by_its_old_name_is_refused_with_the_new_one(bench, names, tmp_path):
    with pytest.raises(ValueError, match=f"index of {bench} is called {names}"):
        getattr(nj, bench)(index=1.6)
    (tmp_path / "old.toml").write_text(f"[{bench}]\nindex = 1.6\n")
    with pytest.raises(ValueError, match=rf"old\.toml: index of {bench} is called {names}"):
        nj.load_scene(tmp_path / "old.toml")
