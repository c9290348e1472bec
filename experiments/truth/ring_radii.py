"""Claim: `rings` fed by the ring radii of a fitted photograph finds the photograph's radius again.

The photographs under $NEWTONJAX_SHARED/photos that show rings. Most have no scale: 10 um a pixel stands for it, which
multiplies all radii alike. Each table of dark and of bright rings is measured by `rings`; and beside it the radii as
the picture shows them, with the pressed disc and what a microscope adds, which `rings` has no law for.

    python -m experiments.truth.ring_radii
"""

import argparse
import os
from pathlib import Path

import fitting
from experiments import records

SODIUM = {"wavelength": 589.3e-9, "pixel_size": 10e-6, "view": "reflected"}
PHOTOGRAPHS = {
    "lens_1000mm_sodium.jpg": SODIUM | {"pixel_size": 12.75e-6},
    "surface_10mm_laser.png": SODIUM | {"wavelength": 635e-9, "pixel_size": 1.3612e-6},
    "led_red_scale_overlay.jpg": SODIUM | {"wavelength": 625e-9},
    **dict.fromkeys(
        [
            *("phone_1m_crosshair_a.jpg", "phone_1m_crosshair_b.jpg", "phone_1m_dark.jpg", "phone_flat_contact.jpg"),
            *(
                "eyepiece_off_centre.jpg",
                "eyepiece_centre_at_rim.jpg",
                "eyepiece_arcs.jpg",
                "eyepiece_centre_outside.jpg",
            ),
        ],
        SODIUM,
    ),
}


def row_of(result: fitting.FitResult, wavelength: float) -> dict:
    """By kind, how far the radius of `rings` is from the fit's, in the fit's deviations."""
    row: dict = {"radius_m": result.radius, "radius_sd_m": result.radius_sd, "rings": len(result.rings)}
    if result.radius is None or result.radius_sd is None:
        return row
    for kind in ("dark", "bright"):
        table = result.ring_table(kind)
        as_seen = {"order": table["order"], "radius_mm": table["seen_mm"]}
        for name, readings in ((kind, table), (f"{kind} as seen", as_seen)):
            again = fitting.rings(readings, wavelength=wavelength, bright=kind == "bright")
            row[name] = None if again.radius is None else (again.radius - result.radius) / result.radius_sd
    return row


def main() -> None:
    """Measure, print and write."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    folder = Path(os.environ.get("NEWTONJAX_SHARED", "../shared")) / "photos"
    rows = {}
    for name, given in PHOTOGRAPHS.items():
        rows[name] = row_of(fitting.fit(folder / name, **given), given["wavelength"])
        print(name, rows[name])
    distances = [row.get(kind) for row in rows.values() for kind in ("dark", "bright")]
    records.save("ring_radii", rows)
    if any(distance is None or abs(distance) > 0.1 for distance in distances):
        raise SystemExit("a radius is not found again")


if __name__ == "__main__":
    main()
