"""Claim: radii and ratios under light of several lines are covered by their intervals, and another lamp is refused.

Five lenses of 120 to 180 mm before each camera, in pictures of 256 x 336 pixels (`colour_pictures`): blur, shot and
read noise, Bayer mosaic, under a mercury arc whose lines have powers of their own. On the model codes are linear; off
it each curve of the camera is 4 nm off, channels mix by 4 %, and every other camera writes JPEGs of quality 90.
Pictures under sodium, cadmium, a white LED and white light are fitted as mercury's, and have to be refused.

    python -m experiments.truth.colour_pairs [--cameras 40] [--quick]
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
LENSES, OTHERS = 5, ("sodium", "cadmium", "led", "white")


def camera(seed: int, is_off: bool) -> list[dict]:
    """Lenses under one mercury arc and camera, and their ratios to the first: relative errors and deviations."""
    rng = np.random.default_rng([seed, 23])
    curves = responses(rng.normal(0, 4, 3), 0.04) if is_off else responses()
    lamp, blur, lines = arc(rng), rng.uniform(0.7, 1.6), []
    for lens in range(LENSES):
        truth = random_truth(rng, "mercury", SHAPE)._replace(blur=blur)
        fit = _fit(truth, rng, curves, lamp, is_jpeg=is_off and seed % 2 == 0)
        line = {"seed": seed, "off": is_off, "lens": lens, "status": fit.status, "message": str(fit.message)}
        if fit.status == "ok":
            line |= {"error": fit.radius / truth.radius - 1, "sd": fit.radius_sd / fit.radius}
        lines.append(line)
    first = lines[0]
    for line in lines[1:]:
        if "error" in line and "error" in first:
            line["ratio_error"] = (1 + line["error"]) / (1 + first["error"]) - 1
            line["ratio_sd"] = float(np.hypot(line["sd"], first["sd"]))
    return lines


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
    table: dict = {}
    for is_off, name in ((False, "on"), (True, "off")):
        pictures = [line for line in lines if line.get("off") == is_off]
        table[name] = {"pictures": len(pictures), "refused": sum("error" not in line for line in pictures)}
        for number, prefix in (("radius", ""), ("ratio", "ratio_")):
            pairs = [(line[f"{prefix}error"], line[f"{prefix}sd"]) for line in pictures if f"{prefix}error" in line]
            errors, sds = np.array(pairs).T
            z = errors / sds
            table[name][number] = {
                "count": len(z),
                "covered": float(np.mean(np.abs(z) < 1.96)),
                "beyond_4_sd": int(np.sum(np.abs(z) > 4)),
                "rms_z": float(np.sqrt(np.mean(z**2))),
                "median_sd": float(np.median(sds)),
                "rms_error": float(np.sqrt(np.mean(errors**2))),
            }
    lamps = [line for line in lines if "lamp" in line]
    table["other_lamps"] = {"pictures": len(lamps), "answered": sum(line["status"] != "refused" for line in lamps)}
    return table


def main() -> None:
    """Run the cameras and the other lamps, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cameras", type=int, default=40)
    parser.add_argument("--quick", action="store_true", help="two cameras and a lamp, nothing written")
    options = parser.parse_args()
    count = 2 if options.quick else options.cameras
    began, lines = time.process_time(), []
    for seed in range(count):
        lines += camera(seed // 2, is_off=bool(seed % 2))
    lines += [other_lamp(seed, OTHERS[seed % len(OTHERS)]) for seed in range(1 if options.quick else count)]
    table = summary(lines) | {"cpu_seconds": time.process_time() - began}
    print(json.dumps(table, indent=1))
    if options.quick:
        beyond = [table[name][number]["beyond_4_sd"] for name in ("on", "off") for number in ("radius", "ratio")]
        sys.exit(any(beyond) or table["other_lamps"]["answered"])
    (records.RESULTS / "colour_pairs.json").write_text(json.dumps({"summary": table, "lines": lines}, indent=1) + "\n")


if __name__ == "__main__":
    main()
