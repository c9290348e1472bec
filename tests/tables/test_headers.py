"""Names of columns: units and deviations in the spellings that people use, and columns that mislead."""

import numpy as np
import pytest

import fitting
from fitting.tables.columns import columns_of
from fitting.tables.headers import canonical

WAVELENGTH = 589.3e-9
ORDERS = np.arange(1.0, 9.0)
DIAMETERS = 2e3 * np.sqrt(ORDERS * WAVELENGTH)  # [mm], of a lens of 1 m


@pytest.mark.parametrize(
    ("header", "name"),
    [
        ("diameter (cm)", "diameter_cm"), ("Diameter [mm]", "diameter_mm"), ("Ring diameter, mm", "diameter_mm"),
        ("radius_µm", "radius_um"), ("radius / μm", "radius_um"), ("Radius in", ""), ("left (mm)", "left_mm"),
        ("right reading [mm]", "right_mm"), ("diameter px", "diameter_px"), ("diameter (pixels)", "diameter_px"),
        ("Order", "order"), ("order m", "order"), ("ring order", "order"), ("series", "series"), ("Run", "series"),
        ("sigma", "sd"), ("error (mm)", "sd_mm"), ("uncertainty [um]", "sd_um"), ("sd_mm", "sd_mm"),
        ("σ / mm", "sd_mm"), ("standard deviation, mm", "sd_mm"),
        ("diameter error (mm)", "sd_diameter_mm"), ("sd radius", "sd_radius"),
        ("radius_mm_reported", ""), ("x_left_mm", "left_mm"), ("D (cm)", ""),
        ("temperature", ""), ("diameter", "diameter"),
    ],
)  # fmt: skip
def test_a_header_says_kind_and_unit(header, name):
    assert canonical(header) == name


@pytest.mark.parametrize(
    "header", ["D (cm)", "D [cm]", "D, cm", "D/cm", "D_cm", "D  cm", "D (centimetres)", "d_n / cm"]
)
def test_a_column_in_centimetres_is_a_hundred_times_no_other(header):
    rows = {"order": ORDERS, header: DIAMETERS / 10}
    result = fitting.rings(rows, wavelength=WAVELENGTH)
    assert result.radius == pytest.approx(1.0, rel=1e-5)
    assert (
        f"{header} was taken for diameter_cm; if it is not, name the column with columns or --column" in result.warnings
    )
    for name in ("diameter_cm", "diameter"):
        result = fitting.rings(rows, wavelength=WAVELENGTH, columns={name: header})
        assert result.radius == pytest.approx(1.0, rel=1e-5)
        assert not result.warnings
    with pytest.raises(ValueError, match="the header says cm; name it diameter_cm="):
        fitting.rings(rows, wavelength=WAVELENGTH, columns={"diameter_mm": header})


@pytest.mark.parametrize(("unit", "factor"), [("cm", 0.1), ("mm", 1), ("um", 1e3), ("µm", 1e3), ("m", 1e-3)])
def test_units_in_headers_are_read(unit, factor):
    rows = {"order": ORDERS, f"Diameter ({unit})": factor * DIAMETERS, f"sigma ({unit})": np.full(8, factor * 0.01)}
    result = fitting.rings(rows, wavelength=WAVELENGTH)
    assert result.radius == pytest.approx(1.0, rel=1e-4)
    assert result.radius_sd == pytest.approx(result_with_sd_mm().radius_sd, rel=1e-9)
    assert not any("was not used" in text for text in result.warnings)


def result_with_sd_mm():
    return fitting.rings({"order": ORDERS, "diameter_mm": DIAMETERS, "sd_mm": np.full(8, 0.01)}, wavelength=WAVELENGTH)


@pytest.mark.parametrize("header", ["sigma", "error", "sd", "uncertainty", "Error", "std"])
def test_a_column_of_deviations_is_used(header):
    rows = {"order": ORDERS, "diameter_mm": DIAMETERS, header: np.full(8, 0.01)}
    result = fitting.rings(rows, wavelength=WAVELENGTH)
    assert result.radius_sd == pytest.approx(result_with_sd_mm().radius_sd, rel=1e-9)
    assert f"{header} has no unit: taken in mm, as diameter_mm" in result.warnings


@pytest.mark.parametrize("header", ["error of temperature", "sd_px", "radius error (mm)"])
def test_a_column_of_deviations_that_is_not_used_is_named(header):
    rows = {"order": ORDERS, "diameter_mm": DIAMETERS, header: np.full(8, 0.01)}
    result = fitting.rings(rows, wavelength=WAVELENGTH)
    assert f"{header} was not used: the sizes are those of diameter_mm" in result.warnings


def test_a_column_of_deviations_may_be_named():
    rows = {"order": ORDERS, "diameter_mm": DIAMETERS, "error": np.full(8, 10.0)}
    result = fitting.rings(rows, wavelength=WAVELENGTH, columns={"sd_um": "error"})
    assert result.radius_sd == pytest.approx(result_with_sd_mm().radius_sd, rel=1e-9)
    assert not any("error" in text for text in result.warnings)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({}, "no columns"),
        ({"order": [1, [2, 3]], "radius_mm": [1, 2]}, "column 'order' is ragged"),
        ({"order": [[1, 2]], "radius_mm": [[1, 2]]}, r"has the shape \(1, 2\); give one number for each row"),
        ({"order": [1, 2, 3], "radius_mm": [1, 2]}, r"different lengths \(order 3, radius_mm 2\)"),
        ({"order": [1, 2], "radius_mm": [1, 2j]}, "is not a number"),
        ({"order": [1, 2], "radius_mm": [True, False]}, "'True' is not a number"),
        ({"order": [1, 2], "radius_mm": [1, np.inf]}, "is not finite"),
        ({"order": [1, 2], "radius_mm": [np.nan, np.nan]}, "no row of the table is complete"),
        ({"order": [1, 2], "radius_mm": [1, -2]}, "negative size; allowed: zero or more"),
        ({"order": [0, 0], "radius_mm": [0, 0]}, "holds no ring"),
        ({"order": [1, 2], "radius_mm": [1e-9, 2]}, "beyond all rings"),
        ({"order": [1, 2], "radius_mm": [1, 2], "sd_mm": [0, 1]}, "above zero"),
        ({"order": [1, 2], "radius": [1, 2]}, "column 'radius' has no unit; call it radius_mm"),
        ({"order": [1, 2], "radius_mm": [1, 2], "Radius (mm)": [1, 2]}, "two columns of the table are radius_mm"),
        ({"m": [1, 2], "n": [3, 4], "radius_mm": [1, 2]}, "name one with order=m"),
        ({"m": [1, 1], "radius_mm": [1, 2]}, "name one with order=m"),
        ({"m": [1.2, 2.3], "radius_mm": [1, 2]}, "name one with order=m"),
        ({"n": [1, 2], "R (mm)": [900, 901]}, "the table has no ring sizes; it has order, R"),
        ({"n": [1, 2], "d_m": [1, 2]}, "the table has no ring sizes"),
        ({"n": [1, 2], "D^2 (mm^2)": [1, -2]}, "holds a negative square"),
        ({"order": [], "radius_mm": []}, "no row of the table is complete"),
    ],
)
def test_what_is_no_table_is_refused_in_one_line(table, words):
    with pytest.raises(ValueError, match=words) as refusal:
        fitting.rings(table, wavelength=WAVELENGTH)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("table", [None, 3, [[1, 2], [3, 4]], b"readings.csv", np.eye(2)])
def test_what_is_neither_file_nor_columns_says_what_it_is(table):
    with pytest.raises(ValueError, match=f"is of type {type(table).__name__}; give the path of a CSV file"):
        columns_of(table)


@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"wavelength": WAVELENGTH, "radius": 1.0, "gap_index": 1.33},
        {"wavelength": WAVELENGTH, "radius": 1.0, "gap_index_sd": 0.01},
        {"radius": 1.0, "expected_radius": 1.0},
        {"wavelength": WAVELENGTH, "radius_sd": 0.1},
    ],
)
def test_arguments_that_contradict_are_refused_in_one_line(arguments):
    with pytest.raises(ValueError, match=r"give|allowed|leave") as refusal:
        fitting.rings({"order": ORDERS, "diameter_mm": DIAMETERS}, **arguments)
    assert "\n" not in str(refusal.value)


def test_a_canonical_name_does_not_displace_another_spelling():
    radii = np.sqrt(np.arange(1.0, 7) * 589.3e-9)
    columns = {"order": np.arange(1, 7), "diameter (mm)": 2e3 * radii, "diameter_mm": 2.5e3 * radii}
    with pytest.raises(ValueError, match="two columns of the table are diameter_mm"):
        fitting.rings(columns, wavelength=589.3e-9)
    chosen = fitting.rings(columns, wavelength=589.3e-9, columns={"diameter_mm": "diameter (mm)"})
    assert chosen.radius == pytest.approx(1.0, rel=1e-5)


@pytest.mark.parametrize("labels", [("run", "observer"), ("run", "series")])
def test_of_several_columns_of_series_one_is_taken(labels):
    radii = np.tile(np.sqrt(np.arange(1.0, 7) * 589.3e-9), 2)
    columns = {"order": np.tile(np.arange(1, 7), 2), "radius_m": radii}
    columns |= {labels[0]: [1] * 6 + [2] * 6, labels[1]: [3] * 6 + [4] * 6}
    result = fitting.rings(columns, wavelength=589.3e-9)
    first, second = labels if "series" not in labels else labels[::-1]
    assert any(f"the series are those of {first}; not of {second}" in text for text in result.warnings)
    assert ("1: 1" if first == "run" else "3: 1") in result.model["series"]
    chosen = fitting.rings(columns, wavelength=589.3e-9, columns={"series": second})
    assert chosen.warnings == []
