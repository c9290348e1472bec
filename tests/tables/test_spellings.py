"""Tables as students write them: letters, squares, repeats, both sides, other languages; or a clear refusal."""

import numpy as np
import pytest

import fitting

WAVELENGTH = 589.3e-9
ORDERS = np.arange(1, 13)
# Diameters [mm] of a lens of 1 m, to a micrometre.
DIAMETERS = np.round(2e3 * np.sqrt(ORDERS * WAVELENGTH), 3)
LEFT, RIGHT = np.round(25 - DIAMETERS / 2, 4), np.round(25 + DIAMETERS / 2, 4)
SIGMA = np.full(12, 0.005)


def text_of(header, *columns, comma=False):
    sep = ";" if ";" in header else "\t" if "\t" in header else ","
    rows = [sep.join(f"{cell:g}" for cell in row) for row in zip(*columns, strict=True)]
    return "\n".join([header, *(row.replace(".", ",") if comma else row for row in rows)]) + "\n"


def measured(tmp_path, text, encoding="utf-8"):
    file = tmp_path / "table.csv"
    file.write_bytes(text.encode(encoding))
    return fitting.rings(file, wavelength=WAVELENGTH)


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        (text_of("m,D (mm)", ORDERS, DIAMETERS), "utf-8"),
        (text_of("k,r/mm", ORDERS, DIAMETERS / 2), "utf-8"),
        (text_of("m,d_m (mm),d_m^2 (mm^2)", ORDERS, DIAMETERS, DIAMETERS**2), "utf-8"),
        (text_of("Ordnung;Durchmesser [mm];Unsicherheit [mm]", ORDERS, DIAMETERS, SIGMA, comma=True), "cp1252"),
        (text_of("Ordre;Diamètre (mm);Incertitude (mm)", ORDERS, DIAMETERS, SIGMA, comma=True), "cp1252"),
        ("# TP\n" + text_of("Anneau;Rayon (mm)", ORDERS, DIAMETERS / 2, comma=True), "utf-8"),
        (text_of("n,x_left (mm),x_right (mm)", ORDERS, LEFT, RIGHT), "utf-8"),
        (text_of("环序,左读数/mm,右读数/mm,直径/mm", ORDERS, LEFT, RIGHT, DIAMETERS), "gb18030"),
        (text_of("级次,直径(毫米),标准差(毫米)", ORDERS, DIAMETERS, SIGMA), "utf-8"),
        (text_of("k;D^2 (mm^2)", ORDERS, DIAMETERS**2), "utf-8"),
        (text_of("n;D² / mm²", ORDERS, DIAMETERS**2), "utf-8"),
        (text_of("ring number,mean diameter (mm),std (mm)", ORDERS, DIAMETERS, SIGMA), "utf-8"),
        ("% by a program\n// x\n" + text_of("order;diameter", ORDERS, DIAMETERS).replace("\n", "\n;mm\n", 1), "utf-8"),
    ],
)  # fmt: skip
def test_the_sizes_are_found_however_they_are_called(tmp_path, text, encoding):
    result = measured(tmp_path, text, encoding)
    assert result.status == "ok"
    assert result.radius == pytest.approx(1.0, rel=3e-4)
    # With the stated 5 um of the diameters, or the rounding.
    assert result.radius_sd < 2e-3


@pytest.mark.parametrize(
    "names", [("D1", "D2", "D3"), ("D_1", "D_2", "D_3"), ("diameter 1", "diameter 2", "diameter 3")]
)
def test_several_diameters_of_a_ring_are_as_many_readings(tmp_path, names):
    rng = np.random.default_rng(0)
    readings = [DIAMETERS + 0.005 * rng.normal(size=12) for _ in names]
    header = "order," + ",".join(f"{name} (mm)" for name in names)
    result = measured(tmp_path, text_of(header + ",mean D (mm)", ORDERS, *readings, np.mean(readings, axis=0)))
    below = {"order": np.tile(ORDERS, 3), "diameter_mm": [float(f"{d:g}") for d in np.concatenate(readings)]}
    expected = fitting.rings(below, wavelength=WAVELENGTH)
    assert (result.radius, result.radius_sd) == pytest.approx((expected.radius, expected.radius_sd), rel=1e-9)
    columns = ", ".join(f"{name} (mm)" for name in names)
    assert result.warnings == [
        f"{columns} are readings of the same rings, each of which counts",
        f"mean D (mm) was not used: it is the mean of {columns}",
    ]


def test_both_sides_read_twice_are_two_readings(tmp_path):
    header = "n,left 1 (mm),left 2 (mm),right 1 (mm),right 2 (mm)"
    result = measured(tmp_path, text_of(header, ORDERS, LEFT, LEFT + 0.01, RIGHT, RIGHT + 0.01))
    assert len(result.rings) == 24
    assert result.radius == pytest.approx(1.0, rel=3e-4)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"PK\x03\x04" + bytes(100), r"is (a|no) workbook.*save its sheet as CSV"),
        (text_of("n,k,diameter_mm", ORDERS, ORDERS + 3, DIAMETERS).encode(), "no column 'order'"),
        (text_of("n,R (mm)", ORDERS, np.full(12, 1000.0)).encode(), "has no ring sizes"),
        (
            b"order,diameter_mm\n1,1,54\n2,2,17\n3,2,66\n",
            "line 2: its number of cells is not the header's 2; where commas",
        ),
    ],
)
def test_what_is_not_understood_is_refused_in_one_line(tmp_path, content, words):
    file = tmp_path / "table.csv"
    file.write_bytes(content)
    with pytest.raises(ValueError, match=words) as refusal:
        fitting.rings(file, wavelength=WAVELENGTH)
    assert "\n" not in str(refusal.value)
