"""The tables of `trials` and `tables`, and the outcome that each must have."""

from experiments.truth.trial_rows import SODIUM, Row


def _table(name: str, options: dict, before: str, right: str, value=None, sd=0.0, words=(), statuses=("ok",)) -> Row:
    """A table of rings: its radius [m] must lie within half a deviation of what is right."""
    return Row(name, "rings", options, before, right, statuses, value, sd, words, reach=0.5)


_TABLE_LIGHT = {"wavelength": SODIUM}

TABLES = (
    _table(
        "trials/miscounted_between_groups.csv",
        _TABLE_LIGHT,
        "988.6 +- 6.4 mm, no word of it",
        "flagged: two or three rings missed; the groups say 871 +- 14 mm",
        0.871,
        0.014,
        ("rings were missed",),
    ),
    _table(
        "trials/wedge_not_rings.csv",
        _TABLE_LIGHT,
        "67.4 +- 0.9 mm",
        "refused: not a straight line",
        words=("curvature",),
        statuses=("refused",),
    ),
    _table(
        "trials/coarse_diameters_465nm.csv",
        {"wavelength": 465e-9, "expected_radius": 0.35},
        "79 +- 11 mm",
        "the same, and 350 mm raises the factor of four",
        0.0792,
        0.011,
        ("look like radii",),
    ),
    _table(
        "trials/half_divisions_590nm.csv",
        {"wavelength": 590e-9},
        "249 +- 34 mm: the stated sd is far above the scatter",
        "says so, and offers the scatter's",
        0.2486,
        0.034,
        ("by their scatter",),
    ),
    _table(
        "trials/three_series.csv",
        _TABLE_LIGHT,
        "884.6 +- 3.1 mm: series taken as one",
        "spread between series in the budget",
        0.8846,
        0.006,
        ("series", "readings of one ring"),
    ),
    _table("trials/lens_890mm.csv", _TABLE_LIGHT, "886.5 +- 10 mm", "the same", 0.8865, 0.010),
    _table(
        "trials/radii_with_ring_zero.csv",
        _TABLE_LIGHT,
        "residual -1.4e293; 51 of 56 orders relabelled; 0.5447 m",
        "0.5397 +- 0.0090 m, r = 0 left out with a line",
        0.5397,
        0.0090,
        ("the centre, no ring",),
    ),
    _table(
        "trials/two_rings_known_radius.csv",
        {"radius": 0.67241, "radius_sd": 2e-3},
        "no --radius",
        "558.5 nm",
        558.5e-9,
        0.5e-9,
    ),
    Row(
        "trials/wedge_hair.csv",
        "wedge",
        {"wavelength": SODIUM, "length": 42.65e-3},
        "refused: no ring sizes",
        "a hair of 92.8 +- 0.2 um",
        ("ok",),
        92.8e-6,
        0.2e-6,
        reach=0.5,
    ),
    _table(
        "trials/four_series_one_misread.csv",
        {"wavelength": 547e-9, "view_angle": 0.383972},
        "right, but one of four called all, and one side of two",
        "1.1607 +- 0.0067 m, and the words",
        1.1607,
        0.0067,
        ("1 of 4 of order 3",),
    ),
    _table("tables/lens_1550mm.csv", {"wavelength": 589e-9}, "1541.3 +- 4.4 mm", "1541.3 +- 4.4 mm", 1.5413, 0.0044),
    _table(
        "tables/oblique_22deg.csv",
        {"wavelength": 547e-9, "view_angle": 0.383972, "view_angle_sd": 0.0087266},
        "1150 mm",
        "1150 mm; 1147 +- 10 mm by its author",
        1.150,
        0.010,
    ),
    _table(
        "tables/lens_1000mm.csv",
        {"wavelength": SODIUM, "pixel_size": 1e-3 / 77.28},
        "1076 mm by students",
        "1000 mm nominal; 1076 mm by students at 77.28 px/mm",
        1.076,
        0.02,
    ),
    _table("tables/repeats_rings_1_11.csv", _TABLE_LIGHT, "1062.4 +- 6.4 mm", "1062.4 +- 6.4 mm", 1.0624, 0.0064),
    _table(
        "tables/coarse_microscope.csv",
        {"wavelength": 590e-9},
        "113 +- 7 mm",
        "113 +- 7 mm: a finite radius and sd",
        0.113,
        0.007,
    ),
    _table(
        "tables/radii_in_pixels.csv",
        {"wavelength": SODIUM, "pixel_size": 0.0333e-3, "pixel_size_sd": 0.003e-3, "expected_radius": 0.47},
        "no word of the factor of four",
        "470 +- 40 mm by spherometer: warned of the factor of four",
        words=("look like diameters",),
    ),
    _table(
        "tables/misread.csv",
        _TABLE_LIGHT,
        "848 +- 481 mm; interval -5.3 to 7.0 m, status ok",
        "flagged, no interval below zero",
        statuses=("refused",),
    ),
)
