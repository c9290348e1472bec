"""The photographs of `photos`, and the outcome that each must have."""

from experiments.truth.trial_rows import SODIUM, Row

# Relative standard deviation of a scale that was read off by eye.
_EYE = 0.02


def _photo(name: str, before: str, scale: float | None = None, light: float = SODIUM) -> Row:
    """A photograph of `photos` without a pixel size, whose fringe scale [1/px²] was read off by eye where stated."""
    right = "the fringe scale" if scale is None else f"fringe scale {scale:.3g} per px2"
    options = {"wavelength": light}
    sd = 0.0 if scale is None else _EYE * scale * 3
    return Row(f"photos/{name}", "fit", options, before, right, ("no-scale",), scale, sd)


PHOTOS = (
    Row(
        "photos/lens_1000mm_sodium.jpg",
        "fit",
        {"wavelength": SODIUM, "pixel_size": 12.745e-6},
        "1.0186 +- 0.0007 m",
        "1.0173 m, independently with a Hertz contact and no distortion",
        ("ok",),
        1.0173,
        0.002,
    ),
    Row(
        "photos/lens_1000mm_sodium.jpg",
        "fit",
        {"wavelength": SODIUM, "scale": True},
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
    Row(
        "photos/phone_blurred_cropped.jpg",
        "fit",
        {"wavelength": SODIUM},
        "2.707e-5 per px2",
        "refused because rings in weak light are not where the others put them",
        ("refused",),
        words=("contradict",),
    ),
    _photo("eyepiece_off_centre.jpg", "2.342e-5 per px2", 2.37e-5),
    _photo("eyepiece_centre_at_rim.jpg", "2.771e-5 per px2"),
    _photo("eyepiece_arcs.jpg", "5.828e-5 per px2"),
    _photo("eyepiece_centre_outside.jpg", "6.506e-5 per px2", 6.5e-5),
    _photo("led_red_scale_overlay.jpg", "4.805e-4 per px2", light=625e-9),
    Row(
        "photos/wedge_straight_fringes.jpg",
        "fit",
        {"wavelength": SODIUM},
        "refused",
        "refused because the fringes are straight",
        ("refused",),
        words=("straight",),
    ),
)
