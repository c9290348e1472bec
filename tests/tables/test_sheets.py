"""Tables in the forms in which people keep them: each is read right, or refused with columns that would do."""

import shlex
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from ring_tables import WAVELENGTH, written

import fitting
from experiments.truth.further_sheets import FURTHER
from experiments.truth.hostile_sheets import HOSTILE
from experiments.truth.random_sheets import SHEETS
from experiments.truth.sheet_forms import FORMS, RADIUS, Form, text
from experiments.truth.workbooks import xlsx
from fitting.shell.cli import main
from fitting.tables.table import readings

EVERY = (*FORMS, *FURTHER, *HOSTILE)
PLAIN = "n\tD (mm)\n1\t1.54\n2\t2.17\n3\t2.66\n4\t3.07\n"


def table_of(form: Form, tmp_path):
    if not form.suffix:
        return form.content.decode()
    if form.suffix in (".xlsx", ".ods"):
        pytest.importorskip("python_calamine", reason="the extra newtonjax[sheets] is not installed")
    path = tmp_path / f"table{form.suffix}"
    path.write_bytes(form.content)
    return path


def test_there_are_as_many_forms_as_were_asked_for():
    assert len({form.name for form in EVERY}) == len(EVERY) >= 200


@pytest.mark.parametrize("form", [form for form in EVERY if form.readings], ids=lambda form: form.name)
def test_a_table_is_read_right(form, tmp_path):
    result = fitting.rings(table_of(form, tmp_path), wavelength=WAVELENGTH, **dict(form.options))
    assert result.status == "ok"
    assert abs(result.radius - RADIUS) < 4 * result.radius_sd
    assert len(result.rings) == form.readings
    assert result.model["table"].count("\n") == 0


@pytest.mark.parametrize("form", [form for form in EVERY if not form.readings], ids=lambda form: form.name)
def test_a_table_that_cannot_be_read_is_refused_with_what_would_do(form, tmp_path):
    path = table_of(form, tmp_path)
    with pytest.raises(ValueError, match=r"give|put|would do|name one") as refusal:
        fitting.rings(path, wavelength=WAVELENGTH, **dict(form.options))
    if columns := getattr(refusal.value, "suggestion", None):
        assert fitting.rings(path, wavelength=WAVELENGTH, columns=columns).radius is not None


@pytest.mark.parametrize(
    ("header", "column"), [("n;D", "diameter_mm=D"), ("x;radius of it", "order=x"), ("a;b", "diameter_mm=b")]
)
def test_the_command_that_a_refusal_names_reads_the_table(tmp_path, capsys, header, column):
    path = tmp_path / "my rings.csv"
    path.write_text(text(header, [(1, 1.54), (2, 2.17), (3, 2.66)], ";"))
    assert main(["rings", str(path), "--wavelength", "589.3nm", "--column", "diameter_cm=c"]) == 2
    assert "has no column 'c'" in capsys.readouterr().err
    assert main(["rings", str(path), "--wavelength", "589.3nm"]) == 2
    command = capsys.readouterr().err.partition("rightly: ")[2]
    assert column in shlex.split(command)
    assert main(shlex.split(command)[1:]) == 0
    assert "radius = " in capsys.readouterr().out


def test_what_was_understood_is_said_in_one_line(tmp_path):
    rows = "mean of group 3\nn;D [mm]\n1;1,54\n2;2,17\n3;-\n4;3,07\nMittel;2,3\n"
    line = fitting.rings(written(tmp_path, rows), wavelength=WAVELENGTH).model["table"]
    assert line == (
        "semicolons, decimal commas; order from 'n', diameter [mm] from 'D [mm]'; left out: line 7 ('Mittel'), "
        "1 with an empty cell"
    )


def test_a_row_without_an_order_between_readings_is_said(tmp_path):
    result = fitting.rings(written(tmp_path, PLAIN.replace("\n3\t", "\n3?\t")), wavelength=WAVELENGTH)
    assert "line 4 ('3?'): the order is no number; left out" in result.warnings
    assert len(result.rings) == 3


def test_pasted_text_is_a_table_and_says_its_origin():
    result = fitting.rings(PLAIN, wavelength=WAVELENGTH)
    assert len(result.rings) == 4
    assert result.origin.file is None
    assert result.origin.sha256 != fitting.rings(PLAIN + "5\t3.43\n", wavelength=WAVELENGTH).origin.sha256


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"separator": "dot"}, "separator is 'dot'; allowed: comma, semicolon"),
        ({"encoding": "klingon"}, "encoding is 'klingon'; give one such as"),
        ({"encoding": "ascii"}, "is not in ascii"),
        ({"vernier": 1.0}, "vernier is 1.0; allowed"),
    ],
)
def test_overruling_arguments_out_of_range_are_refused(tmp_path, arguments, words):
    path = written(tmp_path, "n;Ø (mm)\n1;1.54\n2;2.17\n")
    with pytest.raises(ValueError, match=words):
        fitting.rings(path, wavelength=WAVELENGTH, **arguments)


def test_separator_and_encoding_overrule_what_is_found(tmp_path):
    path = written(tmp_path, "order;diameter_mm;note,1\n1;1.54;a\n2;2.17;b\n3;2.66;c\n")
    assert fitting.rings(path, wavelength=WAVELENGTH, separator="semicolon").status == "ok"
    with pytest.raises(ValueError, match="has no column 'order'; it has column 1, column 2"):
        fitting.rings(path, wavelength=WAVELENGTH, separator="comma")
    path.write_bytes("номер;диаметр, мм\n1;1.54\n2;2.17\n3;2.66\n".encode("koi8-r"))
    assert fitting.rings(path, wavelength=WAVELENGTH, encoding="koi8-r").status == "ok"


def test_a_workbook_needs_its_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "python_calamine", None)
    path = tmp_path / "rings.xlsx"
    path.write_bytes(xlsx([["n", "D (mm)"], [1, 1.54], [2, 2.17]]))
    with pytest.raises(ValueError, match=r"needs|which the extra newtonjax\[sheets\] reads"):
        fitting.rings(path, wavelength=WAVELENGTH)


@settings(max_examples=150)
@given(SHEETS)
def test_no_file_ends_in_an_error_from_inside(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(content)
    try:
        read = readings(path)
    except ValueError:
        return
    assert np.all(np.isfinite(read.order))
    assert np.all(np.isfinite(read.radius))
