"""Tables as spreadsheets write them: delimiters, decimal commas, encodings."""

import numpy as np
import pytest

import fitting
from fitting.tables.columns import columns_of

WAVELENGTH = 589.3e-9
ORDERS = np.arange(1, 9)
DIAMETERS = 2e3 * np.sqrt(ORDERS * WAVELENGTH)  # [mm], of a lens of 1 m


def _written(tmp_path, header, delimiter, cell, *, first="", encoding="utf-8"):
    rows = [delimiter.join((str(order), cell(size))) for order, size in zip(ORDERS, DIAMETERS, strict=True)]
    path = tmp_path / "table.csv"
    path.write_bytes("\r\n".join([*filter(None, [first]), header, *rows, ""]).encode(encoding))
    return path


def _comma(size):
    return f"{size:.4f}".replace(".", ",")


@pytest.mark.parametrize(
    ("header", "delimiter", "cell", "first"),
    [
        ("order;Diameter, mm", ";", _comma, ""),
        ("order\tDiameter, mm", "\t", _comma, ""),
        ('order,"Diameter; mm"', ",", "{:.4f}".format, ""),
        ("order,diameter_mm", ",", lambda size: f'"{_comma(size)}"', ""),
        ("order|diameter_mm", "|", _comma, "sep=|"),
        ("order\tdiameter_mm", "\t", _comma, "sep=\t"),
        ("order;diameter_mm", ";", _comma, '"sep=;"'),
    ],
)
def test_delimiters_and_decimal_commas_are_read(tmp_path, header, delimiter, cell, first):
    result = fitting.rings(_written(tmp_path, header, delimiter, cell, first=first), wavelength=WAVELENGTH)
    assert result.radius == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8", "utf-8-sig", "utf-16"])
def test_encodings_of_windows_are_read(tmp_path, encoding):
    path = _written(tmp_path, "order;diameter (µm)", ";", lambda size: f"{1e3 * size:.1f}", encoding=encoding)
    assert fitting.rings(path, wavelength=WAVELENGTH).radius == pytest.approx(1.0, rel=1e-3)


def test_what_may_be_thousands_is_no_number(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text('order,diameter_um\n1,767\n2,"1,086"\n3,"1,330"\n')
    with pytest.raises(ValueError, match="'1,086' is not a number"):
        fitting.rings(path, wavelength=WAVELENGTH)


@pytest.mark.parametrize("content", [bytes(range(256)), b"\x89PNG\r\n\x1a\n\x00\x00", b"\xff\xfea"])
def test_what_is_no_text_is_refused(tmp_path, content):
    path = tmp_path / "table.csv"
    path.write_bytes(content)
    with pytest.raises(ValueError, match="is no text"):
        columns_of(path)
