"""Claim: the angle of a wedge lies within its interval in photographs of its fringes, on the model and off it.

Pictures rendered by the bench `air_wedge`: fringes of 7 to 40 pixels at any angle, blurred, behind a radial distortion
of up to 3 %, under a vignette, with 1 to 10 % of noise. Off the model each has two of eight faults: a bent plate, a
slant, a second distortion, dust, a camera's curve, JPEG, a shadow's edge, a cross-hair.

    python -m experiments.truth.wedges [--pictures 400] [--quick]
"""

import argparse

import numpy as np

import fitting
from experiments import records
from experiments.truth.wedge_pictures import PIXEL, WAVELENGTH, wedge_picture

# Pictures on the model and off it, by the number of their faults; the least share that must be covered, and the most.
CASES = {"on the model": (0, 0.93, 0.97), "off the model": (2, 0.90, 1.0)}


def deviation(seed: int, fault_count: int) -> float | None:
    """By how many standard deviations the angle is off; None where it is refused."""
    picture = wedge_picture(seed, fault_count)
    result = fitting.wedge_photo(picture.image, wavelength=WAVELENGTH, pixel_size=PIXEL)
    if result.wedge_angle is None:
        return None
    return (result.wedge_angle - picture.angle) / result.wedge_angle_sd


def main() -> None:
    """Count how often the interval covers, print and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", type=int, default=400, help="of each kind")
    parser.add_argument("--quick", action="store_true", help="20 of each kind, nothing written")
    options = parser.parse_args()
    count, record, missed = 20 if options.quick else options.pictures, {}, []
    for case, (fault_count, least, most) in CASES.items():
        deviations = [deviation(seed, fault_count) for seed in range(count)]
        answered = np.array([value for value in deviations if value is not None])
        covered = float(np.mean(np.abs(answered) < 1.96))
        record[case] = {"pictures": count, "refused": count - len(answered), "covered": covered}
        record[case]["largest deviation"] = float(np.abs(answered).max())
        print(case, record[case], flush=True)
        missed += [] if least <= covered <= most else [f"{case}: {covered:.1%} covered"]
    if options.quick:
        return
    records.save("wedges", record)
    if missed:
        raise SystemExit("; ".join(missed))


if __name__ == "__main__":
    main()
