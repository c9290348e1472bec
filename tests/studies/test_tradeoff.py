"""Speed against accuracy for a scene: the biases are the published ones, and the verb writes what it prints."""

import csv
import json

import pytest
from compilations import compilations
from shell import refusal

import newtonjax as nj
from fitting.shell.cli import main
from fitting.studies import tradeoff

CAMERA = nj.Camera((96, 96), 66e-6)
SCENE = """[newton_rings]
radius = 2.0
wavelength = 500e-9
view = "reflected"
screen = "gap"
[camera]
shape = [48, 48]
pixel_size = 100e-6
"""


@pytest.mark.parametrize(("view", "screen", "bias"), [("transmitted", 10e-3, 0.0066), ("reflected", 1e-3, -0.0087)])
def test_the_formula_is_biased_on_a_bare_screen_as_its_rays_say(view, screen, bias):
    """+0.66 % at 10 mm transmitted, -0.87 % at 1 mm reflected (R = 2 m), by image fits: `textbook.py`."""
    ways = {way.name: way for way in tradeoff(nj.newton_rings(2.0, 500e-9, view=view, screen=screen), CAMERA).timings}
    assert ways["ClosedForm"].radius_bias == pytest.approx(bias, rel=0.02)
    assert "screen" in ways["ClosedForm"].note
    nodes = ways["Chebyshev(17)"]
    assert abs(nodes.radius_bias) < 1e-9
    assert max(nodes.phase_error, nodes.intensity_error) < 1e-9
    assert 0 < nodes.seconds < ways["Traced"].seconds
    assert nodes.bytes >= 96 * 96 * 8


def test_another_scene_compiles_next_to_nothing():
    tradeoff(nj.newton_rings(2.0, 500e-9, screen=10e-3, view="transmitted"), CAMERA)
    with compilations() as compiled:
        tradeoff(nj.newton_rings(1.3, 600e-9, screen=2e-3, view="reflected"), CAMERA)
    assert compiled.count <= 2  # an image of another number of nodes


def test_a_scene_without_rings_has_no_bias():
    ways = tradeoff(nj.air_wedge(1e-3), nj.Camera((48, 48), 10e-6), splat=True).timings
    assert {way.radius_bias for way in ways} == {None}
    assert any(way.name == "Splat" for way in ways)


def test_the_verb_prints_a_table_and_writes_it_with_a_picture(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(SCENE)
    assert main(["tradeoff", str(tmp_path / "scene.toml"), "--output-dir", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "radius bias" in said
    ways = json.loads((tmp_path / "out" / "tradeoff.json").read_text())["timings"]
    with (tmp_path / "out" / "tradeoff.csv").open(newline="") as file:
        assert [row["name"] for row in csv.DictReader(file)] == [way["name"] for way in ways]
    assert (tmp_path / "out" / "tradeoff.png").read_bytes().startswith(b"\x89PNG")
    assert "is there already" in refusal(capsys, "tradeoff", tmp_path / "scene.toml", "--output-dir", tmp_path / "out")
