"""Files that the shell writes: whole, never over another one unasked, and readable as they were meant."""

import json
import os

import imageio.v3 as iio
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.parameters import output, png
from fitting.shell.cli import main


def test_files_are_replaced_only_when_asked(tmp_path):
    path = tmp_path / "answer.json"
    output.write(path, "first", force=False)
    with pytest.raises(FileExistsError, match="--force"):
        output.write(path, "second", force=False)
    assert path.read_text() == "first"
    output.write(path, "second", force=True)
    assert path.read_text() == "second"


@pytest.mark.parametrize(
    ("name", "content", "is_one"),
    [
        ("scale.json", '{"status": "refused", "message": "no ruler"}', True),
        ("scale.json", '{"status": "ok"}', False),
        ("scale.json", '["refused"]', False),
        ("scale.json", "refused", False),
        ("scale.txt", '{"status": "refused"}', False),
    ],
)
def test_the_json_of_a_refusal_is_told_from_other_files(tmp_path, name, content, is_one):
    (tmp_path / name).write_text(content)
    assert output.holds_refusal(tmp_path / name) is is_one
    assert not output.holds_refusal(tmp_path / "none.json")


def test_a_refused_scale_is_not_in_the_way_of_the_next_one(tmp_path):
    path = tmp_path / "scale.json"
    path.write_text('{"status": "refused", "message": "no ruler"}')
    points = ("scale", "--point", "10,10", "--point", "110,10", "--distance", "1mm", "--json", str(path))
    assert main(list(points)) == 0
    assert json.loads(path.read_text())["pixel_size_m"] == pytest.approx(1e-5)
    assert main(list(points)) == 2


def test_a_write_that_fails_leaves_nothing_behind(tmp_path, monkeypatch):
    def full(*_):
        raise OSError("no space left")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="no space"):
        output.write(tmp_path / "answer.json", "text", force=False)
    assert not list(tmp_path.iterdir())


def test_what_is_read_is_never_written_over(tmp_path):
    photo = tmp_path / "photo.png"
    photo.touch()
    with pytest.raises(ValueError, match="is what the command reads"):
        output.check_free([tmp_path / "." / "photo.png"], force=True, keep=(photo,))


def test_json_has_null_where_a_number_is_not_finite():
    text = output.json_text({"a": np.float64("nan"), "b": [float("inf"), 1], "c": np.arange(2), "d": None, "é": "λ"})
    assert json.loads(text) == {"a": None, "b": [None, 1], "c": [0, 1], "d": None, "é": "λ"}
    assert "λ" in text


@given(st.floats(0, 1))
def test_srgb_undoes_the_published_curve(linear):
    # IEC 61966-2-1, the decoding branch, written from the standard.
    value = float(png.to_srgb(np.asarray(linear)))
    back = value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
    assert back == pytest.approx(linear, abs=1e-7)  # the standard's own constants leave a step of 3e-8


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("shape", [(1, 1), (7, 5), (64, 1), (33, 48)])
def test_another_program_reads_back_the_codes_of_a_png(shape, bits):
    image = np.random.default_rng(0).uniform(-0.2, 1.2, shape)
    for picture in (image, np.asfortranarray(image)):
        assert np.array_equal(iio.imread(png.encode(picture, bits)), png.codes(image, bits))
