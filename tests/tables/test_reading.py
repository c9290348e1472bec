"""What is read of a table, which of its columns, and what is refused in one line."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ring_tables import RINGS, WAVELENGTH, table, written

import fitting


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ({"x": [1, 2], "diameter_mm": [1, 2]}, "no column 'order'"),
        ({"order": [1, 2], "size": [1, 2]}, "no ring sizes"),
        ({"order": [1, 2], "diameter_mm": [1, "x"]}, "'x' is not a number"),
        ({"order": [1, 2], "diameter_mm": [1, -2]}, "negative"),
        ({"order": [1, 2], "diameter_mm": [1, 2], "sd_mm": [0, 1]}, "above zero"),
        ({"order": [1, 2], "diameter_mm": [1]}, "different lengths"),
        ({"order": ["", ""], "diameter_mm": [1, 2]}, "complete"),
    ],
)
def test_tables_that_cannot_be_read_say_why(rows, words):
    with pytest.raises(ValueError, match=words):
        fitting.rings(rows, wavelength=WAVELENGTH)


@pytest.mark.parametrize(
    "wrong",
    [{"wavelength": 0.0}, {"wavelength": 589.3}, {"pixel_size_sd": 1e-7},
     {"view": "side"}, {"view_angle": 2.0}, {"gap_index": -1.0}, {"wavelength_sd": -1.0},
     {"columns": {"diameter_mm": "D"}}, {"gap_index": 0.1, "view_angle": 0.5}],
)  # fmt: skip
def test_arguments_out_of_range_are_refused(wrong):
    with pytest.raises(ValueError, match=r"allowed|index|column|without"):
        fitting.rings(table(), **{"wavelength": WAVELENGTH, **wrong})


def test_files_with_semicolons_commas_comments_and_gaps_are_read(tmp_path):
    file = tmp_path / "readings.csv"
    file.write_text("\ufeff# microscope 2\norder;left_mm;right_mm\n1;10,0;12,0\n\n2;9,6;\n3;9,0;13,0\n4;8,7;13,3\n")
    result = fitting.rings(file, wavelength=WAVELENGTH)
    assert [ring.radius for ring in result.rings] == pytest.approx([1e-3, 2e-3, 2.3e-3])
    assert any("empty cell" in text for text in result.warnings)


def test_columns_that_disagree_are_noted(tmp_path):
    rows = table()
    rows["left_mm"], rows["right_mm"] = 10 - rows["diameter_mm"] / 2, 10 + rows["diameter_mm"] / 2
    assert not fitting.rings(rows, wavelength=WAVELENGTH).warnings
    rows["diameter_mm"] = rows["diameter_mm"] * 1.05
    assert any("disagree by up to 5.0%" in text for text in fitting.rings(rows, wavelength=WAVELENGTH).warnings)


@given(st.lists(st.tuples(st.integers(0, 30), st.floats(0, 1e3)), min_size=2, max_size=12))
def test_any_table_of_numbers_gives_an_answer_or_a_reason(readings):
    order, diameter = zip(*readings, strict=True)
    try:
        result = fitting.rings({"order": order, "diameter_mm": diameter}, wavelength=WAVELENGTH)
    except ValueError:
        return
    assert result.status in ("ok", "refused")
    assert result.radius_interval is None or 0 < result.radius_interval[0] <= result.radius <= result.radius_interval[1]
    assert all(np.isfinite(ring.residual) for ring in result.rings)
    json.dumps(result.to_dict(), allow_nan=False)
    assert result.report()


def test_the_column_that_is_named_is_the_one_that_counts(tmp_path):
    path = written(tmp_path, "sep=,\n # read twice\nOrder,diameter_mm\n" + RINGS)
    plain = fitting.rings(path, wavelength=589.3e-9)
    named = fitting.rings(path, wavelength=589.3e-9, columns={"radius_mm": "diameter_mm"})
    assert named.radius == pytest.approx(4 * plain.radius, rel=1e-5)  # the sag differs by (r/R)²


def test_standard_deviations_in_another_unit_count(tmp_path):
    rows = "".join(f"{row},5\n" for row in RINGS.split())
    um = fitting.rings(written(tmp_path, "order,diameter_mm,sd_um\n" + rows), wavelength=589.3e-9)
    rows = "".join(f"{row},0.005\n" for row in RINGS.split())
    mm = fitting.rings(written(tmp_path, "order,diameter_mm,sd_mm\n" + rows), wavelength=589.3e-9)
    assert um.radius_sd == pytest.approx(mm.radius_sd)
    rows = "".join(f"{row},5\n" for row in RINGS.split())
    odd = fitting.rings(written(tmp_path, "order,diameter_mm,sd_px\n" + rows), wavelength=589.3e-9)
    assert any("sd_px was not used" in text for text in odd.warnings)


@pytest.mark.parametrize(
    ("text", "columns", "message"),
    [
        ("order,diameter_mm\n" + RINGS, {"foo": "diameter_mm"}, "cannot be named 'foo'"),
        ("order,diameter_mm\n" + RINGS, {"left_mm": "diameter_mm"}, "needs its partner"),
        ("order,diameter_mm\n1,1_54\n2,3\n", None, "is not a number"),
        ("order,radius_m\n1,1e200\n2,2e200\n", None, "beyond all rings"),
        ("order,radius_mm,sd_mm\n1,1,1e-300\n2,2,1\n3,3,1\n", None, "of one size"),
        ("order,radius_mm\n1e16,1\n1e17,2\n", None, "beyond all rings"),
    ],
)
def test_a_table_that_misleads_is_refused(tmp_path, text, columns, message):
    with pytest.raises(ValueError, match=message):
        fitting.rings(written(tmp_path, text), wavelength=589.3e-9, columns=columns)
