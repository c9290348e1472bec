"""The shared files that went wrong, or that must stay right: how each is measured, and what its outcome must be."""

from typing import NamedTuple

_SODIUM = 589.3e-9
_MERCURY = 546.1e-9
_EYE = 0.02  # relative standard deviation of a scale that was read off by eye


class Row(NamedTuple):
    """One file: verb and options that measure it, the outcome before, and what is right.

    `statuses` that are right; `value` that is known, with `value_sd`, and the number of standard deviations within
    which the answer may lie; `words` of which one must stand in message or warnings.
    """

    file: str
    verb: str
    options: dict
    before: str
    right: str
    statuses: tuple[str, ...]
    value: float | None = None
    value_sd: float = 0.0
    words: tuple[str, ...] = ()
    reach: float = 2.5


_ANSWERS = ("ok", "no-scale")
_ANY = (*_ANSWERS, "refused")


def _photo(name: str, before: str, scale: float | None = None, light: float = _SODIUM) -> Row:
    """A photograph of `photos` without a pixel size, whose fringe scale [1/px²] was read off by eye where stated."""
    right = "the fringe scale" if scale is None else f"fringe scale {scale:.3g} per px2"
    options = {"wavelength": light}
    sd = 0.0 if scale is None else _EYE * scale * 3
    return Row(f"photos/{name}", "fit", options, before, right, ("no-scale",), scale, sd)


PICTURES = (
    Row(
        "trials/white_light_154.5mm.tif",
        "fit",
        {"wavelength": 546.1e-9, "pixel_size": 5.461e-6, "pixel_size_sd": 0.01e-6},
        "one channel, one wavelength: 0.5 % stated, 2 % off its sister; channels disagree by 8 %",
        "one radius for all channels, an interval that covers 154.5 mm +- 1 %",
        ("ok",),
        0.1545,
        0.001545,
    ),
    Row(
        "trials/white_light_oblique.jpg",
        "fit",
        {},
        "refused: explains 0.0 %",
        "refused with the reason, or the fringe scale; fast",
        ("refused", "no-scale"),
    ),
    Row(
        "trials/fabry_perot_cadmium.tif",
        "fit",
        {"wavelength": 643.8e-9},
        "accepted as Newton's rings (explains 77 %)",
        "refused or plainly warned: many beams",
        ("refused",),
        words=("many beams", "beams"),
    ),
    Row(
        "trials/michelson_overlay.jpg",
        "fit",
        {"wavelength": 632.8e-9},
        "refused after 25 s",
        "refused, fast",
        ("refused",),
    ),
    Row(
        "trials/hologram_of_a_bead.jpg",
        "fit",
        {"wavelength": 660e-9, "pixel_size": 0.0851e-6},
        "refused after 20 s",
        "refused, fast",
        ("refused",),
    ),
    Row(
        "trials/air_film_not_a_sphere.tif",
        "fit",
        {"wavelength": _MERCURY, "pixel_size": 5.305e-6},
        "refused after 20 s",
        "refused, fast",
        ("refused",),
    ),
    Row(
        "trials/slightly_bent_fringes.bmp",
        "fit",
        {"wavelength": 632.8e-9},
        "did not converge",
        "a refusal that says why, or an honest interval",
        ("refused",),
        words=("no sphere",),
    ),
    Row(
        "trials/slightly_bent_fringes.bmp",
        "form",
        {},
        "no such verb",
        "20.4 fringes",
        ("ok",),
        20.4,
        0.25,
    ),
    Row(
        "trials/arcs_60_fringes.png",
        "fit",
        {"wavelength": 632.8e-9},
        "refused: explains 3.9 %, 49 s",
        "found (ellipse allowed), or refused fast",
        _ANY,
    ),
    Row(
        "trials/arcs_60_fringes.png",
        "form",
        {"pupil": (790.0, 778.0, 770.0), "pupil_sd": 4.0},
        "no such verb",
        "156 fringes",
        ("ok",),
        156.0,
        0.5,
    ),
    Row(
        "trials/lens_850mm_sodium.jpg",
        "fit",
        {"wavelength": _SODIUM, "pixel_size": 12.745e-6},
        "0.8667 +- 0.0014 m",
        "0.8646 m, independently with a Hertz contact and no distortion",
        ("ok",),
        0.8646,
        0.0017,
    ),
    Row(
        "trials/lens_850mm_sodium.jpg",
        "fit",
        {"wavelength": _SODIUM, "scale": True},
        "0.8667 +- 0.0014 m",
        "0.8646 m, distortion from the reticle",
        ("ok",),
        0.8646,
        0.0017,
    ),
    Row(
        "trials/eyepiece_dust_crosshair.jpg",
        "fit",
        {"wavelength": _SODIUM},
        "refused: 0.9 of a fringe, 104 s on a loaded machine",
        "locked: 8.4e-4 per px2 by eye, of the field; 13 % more on the axis",
        ("no-scale",),
        8.8e-4,
        0.4e-4,
    ),
    Row(
        "trials/synthetic_rings_salt_noise.jpg",
        "fit",
        {"wavelength": _SODIUM},
        "refused: phase and contact change the image alike",
        "4.110e-4 per px2",
        ("no-scale",),
        4.110e-4,
        0.008e-4,
    ),
    Row(
        "trials/synthetic_rings_salt_noise_control.jpg",
        "fit",
        {"wavelength": _SODIUM},
        "right",
        "the same",
        ("no-scale",),
        4.2038e-4,
        0.008e-4,
    ),
    Row(
        "trials/straight_fringes_a.jpg",
        "fit",
        {"wavelength": _SODIUM},
        "refused with a wrong reason (no rings, 0.0 %)",
        "refused because the fringes are straight",
        ("refused",),
        words=("straight",),
    ),
    Row(
        "trials/stepped_stack.tif",
        "fit",
        {"wavelength": _SODIUM, "pixel_size": 12e-6},
        "the first page is measured, without a word",
        "says that there are others",
        ("ok",),
        0.3,
        0.0003,
        ("page 1 of 4",),
    ),
    Row(
        "trials/stepped_stack.tif",
        "fit_stack",
        {"wavelength": _SODIUM, "pixel_size": 12e-6},
        "the first page is measured, without a word",
        "0.3 m on all pages",
        ("ok",),
        0.3,
        0.0003,
    ),
    *(
        Row(
            f"trials/stepped_{k}.jpg",
            "form",
            {"wavelength": 632.8e-9},
            "over 6 GB and minutes a frame",
            "read at the cost of the lit part",
            _ANY,
        )
        for k in range(1, 6)
    ),
    Row(
        "photos/lens_1000mm_sodium.jpg",
        "fit",
        {"wavelength": _SODIUM, "pixel_size": 12.745e-6},
        "1.0186 +- 0.0007 m",
        "1.0173 m, independently with a Hertz contact and no distortion",
        ("ok",),
        1.0173,
        0.002,
    ),
    Row(
        "photos/lens_1000mm_sodium.jpg",
        "fit",
        {"wavelength": _SODIUM, "scale": True},
        "1.0186 +- 0.0007 m",
        "1.0173 m, distortion from the reticle",
        ("ok",),
        1.0173,
        0.002,
    ),
    Row(
        "photos/reticle_0.2mm.jpg",
        "scale",
        {"division": 0.2e-3},
        "12.745 +- 0.008 um; 12.721 along x and 12.769 along y, without a word",
        "12.745 um, the two axes' difference said and carried",
        ("ok",),
        12.745e-6,
        0.008e-6,
        ("along",),
    ),
    Row(
        "photos/surface_10mm_laser.png",
        "fit",
        {"wavelength": 635e-9, "pixel_size": 1.3612e-6, "pixel_size_sd": 0.005 * 1.3612e-6},
        "9.9123 +- 0.0021 mm",
        "10.02 mm nominal",
        ("ok",),
        10.02e-3,
        0.05e-3,
    ),
    _photo("phone_1m_crosshair_a.jpg", "2.434e-5 per px2", 2.43e-5),
    _photo("phone_1m_crosshair_b.jpg", "2.473e-5 per px2"),
    _photo("phone_1m_dark.jpg", "3.445e-5 per px2"),
    _photo("phone_flat_contact.jpg", "9.099e-5 per px2", 9.1e-5),
    _photo("phone_blurred_cropped.jpg", "2.707e-5 per px2"),
    _photo("eyepiece_off_centre.jpg", "2.342e-5 per px2", 2.37e-5),
    _photo("eyepiece_centre_at_rim.jpg", "2.771e-5 per px2"),
    _photo("eyepiece_arcs.jpg", "5.828e-5 per px2"),
    _photo("eyepiece_centre_outside.jpg", "6.506e-5 per px2", 6.5e-5),
    _photo("led_red_scale_overlay.jpg", "4.805e-4 per px2", light=625e-9),
    Row(
        "photos/wedge_straight_fringes.jpg",
        "fit",
        {"wavelength": _SODIUM},
        "refused",
        "refused because the fringes are straight",
        ("refused",),
        words=("straight",),
    ),
)


def _table(name: str, options: dict, before: str, right: str, value=None, sd=0.0, words=(), statuses=("ok",)) -> Row:
    """A table of rings: its radius [m] must lie within half a deviation of what is right."""
    return Row(name, "rings", options, before, right, statuses, value, sd, words, reach=0.5)


_SODIUM_TABLE = {"wavelength": _SODIUM}

TABLES = (
    _table(
        "trials/miscounted_between_groups.csv",
        _SODIUM_TABLE,
        "988.6 +- 6.4 mm, no word of it",
        "flagged: two or three rings missed; the groups say 871 +- 14 mm",
        0.871,
        0.014,
        ("rings were missed",),
    ),
    _table(
        "trials/wedge_not_rings.csv",
        _SODIUM_TABLE,
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
        _SODIUM_TABLE,
        "884.6 +- 3.1 mm: series taken as one",
        "spread between series in the budget",
        0.8846,
        0.006,
        ("series", "readings of one ring"),
    ),
    _table("trials/lens_890mm.csv", _SODIUM_TABLE, "886.5 +- 10 mm", "the same", 0.8865, 0.010),
    _table(
        "trials/radii_with_ring_zero.csv",
        _SODIUM_TABLE,
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
        {"wavelength": _SODIUM, "length": 42.65e-3},
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
        {"wavelength": _SODIUM, "pixel_size": 1e-3 / 77.28},
        "1076 mm by students",
        "1000 mm nominal; 1076 mm by students at 77.28 px/mm",
        1.076,
        0.02,
    ),
    _table("tables/repeats_rings_1_11.csv", _SODIUM_TABLE, "1062.4 +- 6.4 mm", "1062.4 +- 6.4 mm", 1.0624, 0.0064),
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
        {"wavelength": _SODIUM, "pixel_size": 0.0333e-3, "pixel_size_sd": 0.003e-3, "expected_radius": 0.47},
        "no word of the factor of four",
        "470 +- 40 mm by spherometer: warned of the factor of four",
        words=("look like diameters",),
    ),
    _table(
        "tables/misread.csv",
        _SODIUM_TABLE,
        "848 +- 481 mm; interval -5.3 to 7.0 m, status ok",
        "flagged, no interval below zero",
        statuses=("refused",),
    ),
)
