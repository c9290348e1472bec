"""Claim: radii and ratios under light of several lines are covered by their intervals, and another lamp is refused.

Pairs of lenses of 120 to 180 mm, seen by one camera in pictures of 256 x 336 pixels (`colour_pictures`): blur, shot and
read noise, Bayer mosaic. On the model the camera's curves are free and the codes linear; off the model each curve is
4 nm off, channels mix by 4 %, and every other pair is a JPEG of quality 90. Lamps: a mercury arc, whose close lines are
in a ratio of their own in each pair; and sodium, cadmium, an LED and white light, which are fitted as mercury and have
to be refused.

    python -m experiments.truth.colour_pairs [--pairs 200] [--quick]
"""

import argparse
import json
import sys
import time

import numpy as np

import fitting
from experiments import records
from experiments.truth.colour_pictures import Truth, arc, picture, random_truth, responses

SHAPE = (256, 336)
OTHERS = ("sodium", "cadmium", "led", "white")


def pair(seed: int, is_off: bool) -> dict:
    """Radius and ratio of a pair under a mercury arc: errors and standard deviations, relative."""
    rng = np.random.default_rng([seed, 23])
    curves = responses(rng.normal(0, 4, 3), 0.04) if is_off else responses()
    lamp = arc(rng)
    truths = [random_truth(rng, "mercury", SHAPE) for _ in range(2)]
    # One lens after the other before one camera.
    truths[1] = truths[1]._replace(blur=truths[0].blur)
    fits = [_fit(truth, rng, curves, lamp, is_jpeg=is_off and seed % 2 == 0) for truth in truths]
    if any(fit.status != "ok" for fit in fits):
        return {"seed": seed, "off": is_off, "refused": next(str(fit.message) for fit in fits if fit.status != "ok")}
    errors = [fit.radius / truth.radius - 1 for fit, truth in zip(fits, truths, strict=True)]
    sds = [fit.radius_sd / fit.radius for fit in fits]
    ratio_error = (1 + errors[1]) / (1 + errors[0]) - 1
    return {
        "seed": seed,
        "off": is_off,
        "error": errors[0],
        "sd": sds[0],
        "ratio_error": ratio_error,
        "ratio_sd": float(np.hypot(*sds)),
    }


def other_lamp(seed: int, lamp: str) -> dict:
    """What is answered of a picture under another lamp that is said to be mercury's."""
    rng = np.random.default_rng([seed, 29])
    truth = random_truth(rng, lamp, SHAPE)
    fit = _fit(truth, rng, responses(), None, is_jpeg=False)
    answer = {"seed": seed, "lamp": lamp, "status": fit.status, "message": str(fit.message)}
    if fit.status == "ok":
        answer |= {"error": fit.radius / truth.radius - 1, "sd": fit.radius_sd / fit.radius}
    return answer


def _fit(truth: Truth, rng: np.random.Generator, curves: np.ndarray, lamp, is_jpeg: bool) -> fitting.FitResult:
    image = picture(truth, rng, curves, SHAPE, is_jpeg, lamp)
    # The scale is exact: of its error nothing is asked.
    return fitting.fit(image, light="mercury", pixel_size=truth.pixel_size, pixel_size_sd=0.0, view="reflected")


def summary(lines: list[dict]) -> dict:
    """Coverage and widths, on the model and off it; and how many other lamps were refused."""
    table = {}
    for is_off, name in ((False, "on"), (True, "off")):
        answers = [line for line in lines if line.get("off") == is_off]
        measured = [line for line in answers if "error" in line]
        table[name] = {"pairs": len(answers), "refused": len(answers) - len(measured)}
        for number, prefix in (("radius", ""), ("ratio", "ratio_")):
            z = np.array([line[f"{prefix}error"] / line[f"{prefix}sd"] for line in measured])
            table[name][number] = {
                "covered": float(np.mean(np.abs(z) < 1.96)),
                "beyond_4_sd": int(np.sum(np.abs(z) > 4)),
                "rms_z": float(np.sqrt(np.mean(z**2))),
                "median_sd": float(np.median([line[f"{prefix}sd"] for line in measured])),
                "rms_error": float(np.sqrt(np.mean([line[f"{prefix}error"] ** 2 for line in measured]))),
            }
    lamps = [line for line in lines if "lamp" in line]
    table["other_lamps"] = {"pictures": len(lamps), "answered": sum(line["status"] != "refused" for line in lamps)}
    return table


def main() -> None:
    """Run the pairs and write the table: half on the model, half off it, and every fifth time another lamp."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=200)
    parser.add_argument("--quick", action="store_true", help="two pairs and a lamp, nothing written")
    options = parser.parse_args()
    count = 2 if options.quick else options.pairs
    began = time.process_time()
    lines = [pair(seed // 2, is_off=bool(seed % 2)) for seed in range(count)]
    lines += [other_lamp(seed, OTHERS[seed % len(OTHERS)]) for seed in range(max(1, count // 5))]
    table = summary(lines) | {"cpu_seconds": time.process_time() - began}
    print(json.dumps(table, indent=1))
    if options.quick:
        sys.exit(any(table[name][number]["beyond_4_sd"] for name in ("on", "off") for number in ("radius", "ratio")))
    (records.RESULTS / "colour_pairs.json").write_text(json.dumps({"summary": table, "lines": lines}, indent=1) + "\n")


if __name__ == "__main__":
    main()
