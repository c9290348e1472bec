"""Claim: radii and ratios under lines, or under given curves, are covered by their intervals; other light is refused.

Five lenses of 120 to 180 mm before each camera, in pictures of 256 x 336 pixels (`colour_pictures`): blur, shot and
read noise, Bayer mosaic, under a mercury arc whose lines have powers of their own. On the model codes are linear; off
it each curve of the camera is 4 nm off, channels mix by 4 %, and every other camera writes JPEGs of quality 90.
Pictures under sodium, cadmium, a white LED and white light are fitted as mercury's, and have to be refused.

Three lenses before each camera under light of bands (`banded_light`) are fitted with the curves of lamp and camera
given. On the model these are right but for tilts, curvatures and a common error of all wavelengths out of their
priors; off it each response is 4 nm off, channels mix by 4 % and the lamp is tilted by 15 % over 50 nm. Another lamp
or a camera of another kind is to be refused, or stated with what it costs.

Two lenses before each camera are fitted with nothing given of the light (`unknown_camera`), under lamps of bands and a
mercury arc: the ratio, and the fringe scales of the mean wave. Off the model curves are off as above, and every other
camera writes JPEGs. A second picture under another lamp is to be refused.

    python -m experiments.truth.colour_pairs [--cameras 40] [--light lines bands unknown] [--quick]
"""

import argparse
import json
import sys
import time

import numpy as np

import fitting
from experiments import records
from experiments.truth.colour_pictures import (
    WAVELENGTHS,
    Truth,
    arc,
    banded_light,
    changed,
    overlapping_responses,
    picture,
    random_truth,
    responses,
)
from newtonjax.scene import Response, sampled_spectrum

SHAPE = (256, 336)
LENSES, OTHERS = 5, ("sodium", "cadmium", "led", "white")
# Files of the records, by kind of light.
RECORDS = {
    "lines": "colour_pairs.json",
    "bands": "colour_pairs_bands.json",
    "unknown": "colour_pairs_unknown.json",
}
UNKNOWN = ("white", "led", "mercury", "halogen", "filtered")
BANDED, BANDED_LENSES = ("led", "white", "halogen", "filtered"), 3


def camera(seed: int, is_off: bool) -> list[dict]:
    """Lenses under one mercury arc and camera, and their ratios to the first: relative errors and deviations."""
    rng = np.random.default_rng([seed, 23])
    curves = responses(rng.normal(0, 4, 3), 0.04) if is_off else responses()
    lamp, blur, lines = arc(rng), rng.uniform(0.7, 1.6), []
    for lens in range(LENSES):
        truth = random_truth(rng, "mercury", SHAPE)._replace(blur=blur)
        fit = _fit(truth, rng, curves, lamp, is_jpeg=is_off and seed % 2 == 0)
        lines.append({"seed": seed, "off": is_off, "lens": lens} | _answer(fit, truth))
    return _with_ratios(lines)


def _answer(fit: fitting.FitResult, truth: Truth) -> dict:
    """Status and message, and of an answer its relative error, deviation, and what of it is that of given curves."""
    answer: dict = {"status": fit.status, "message": str(fit.message)}
    if fit.radius and fit.radius_sd:
        answer |= {"error": fit.radius / truth.radius - 1, "sd": fit.radius_sd / fit.radius}
        answer["curves_sd"] = dict(fit.budget).get("lamp and camera curves", 0.0) / fit.radius
    return answer


def _with_ratios(lines: list[dict]) -> list[dict]:
    """The lenses of a camera, with the errors and deviations of their ratios to the first."""
    first = lines[0]
    for line in lines[1:]:
        if "error" in line and "error" in first:
            line["ratio_error"] = (1 + line["error"]) / (1 + first["error"]) - 1
            # Of given curves a ratio has nothing.
            own = [max(lens["sd"] ** 2 - lens["curves_sd"] ** 2, 0.0) for lens in (line, first)]
            line["ratio_sd"] = float(np.sqrt(sum(own)))
    return lines


def banded_camera(seed: int, is_off: bool) -> list[dict]:
    """As `camera`, under a lamp of bands; the curves that are given are those of the catalogue."""
    rng, lamp = np.random.default_rng([seed, 37]), BANDED[seed // 2 % len(BANDED)]
    powers, common = banded_light(lamp), 0.0
    if is_off:
        curves = responses(rng.normal(0, 4, 3), 0.04)
        powers = powers * np.exp(0.15 * rng.normal() * (WAVELENGTHS - 560e-9) / 50e-9)
    else:
        curves, common = changed(responses(), powers, rng), 0.008 * rng.normal()
    blur, lines = rng.uniform(0.7, 1.6), []
    for lens in range(BANDED_LENSES):
        truth = random_truth(rng, lamp, SHAPE)._replace(blur=blur)
        line = {"seed": seed, "off": is_off, "lens": lens, "banded": lamp}
        lines.append(line | _banded(truth, rng, curves, powers, lamp, common))
    return _with_ratios(lines)


def other_curves(seed: int) -> dict:
    """What is answered under given curves that are another lamp's, or of a camera whose channels overlap."""
    rng = np.random.default_rng([seed, 41])
    lamp, given = BANDED[seed // 2 % 4], BANDED[(seed // 2 + 1 + seed // 8 % 3) % 4] if seed % 2 else None
    truth = random_truth(rng, lamp, SHAPE)
    curves = responses() if given else overlapping_responses()
    answer = _banded(truth, rng, curves, banded_light(lamp), given or lamp)
    return {"seed": seed, "given": given or "another camera", "of": lamp} | answer


def _banded(
    truth: Truth, rng: np.random.Generator, curves: np.ndarray, powers: np.ndarray, given: str, common: float = 0.0
) -> dict:
    """The answer under the curves of the lamp `given`; `common`: relative error of all wavelengths of the truth's."""
    shifted = np.stack([np.interp(WAVELENGTHS / (1 + common), WAVELENGTHS, row) for row in curves])
    image = picture(truth, rng, shifted, SHAPE, light=(WAVELENGTHS * (1 + common), powers))
    fit = fitting.fit(
        image,
        light=sampled_spectrum(WAVELENGTHS, banded_light(given)),
        response=Response(WAVELENGTHS, responses()),
        pixel_size=truth.pixel_size,
        pixel_size_sd=0.0,
        view="reflected",
    )
    return _answer(fit, truth)


def unknown_camera(seed: int, is_off: bool) -> list[dict]:
    """Errors and deviations of the ratio of two lenses, and of their fringe scales, of which no light is given."""
    rng, lamp = np.random.default_rng([seed, 67]), UNKNOWN[seed // 2 % len(UNKNOWN)]
    curves = responses(rng.normal(0, 4, 3), 0.04) if is_off else responses()
    light, blur = _light_of(lamp, rng), rng.uniform(0.7, 1.6)
    truths = [random_truth(rng, lamp, SHAPE)._replace(blur=blur) for _ in range(2)]
    is_jpeg = is_off and seed // 2 % 2 == 0
    pair = _unknown([picture(truth, rng, curves, SHAPE, is_jpeg, light) for truth in truths])
    line = {"seed": seed, "off": is_off, "jpeg": is_jpeg, "unknown": lamp, "status": pair.status}
    line |= {"message": str(pair.message)}
    if not (pair.ratio and pair.ratio_sd):
        return [line]
    true = truths[1].radius / truths[0].radius
    line |= {"ratio_error": pair.ratio / true - 1, "ratio_sd": pair.ratio_sd / pair.ratio}
    wavenumber, lines = _mean_wave(light, curves), []
    for member, truth in zip(pair.members, truths, strict=True):
        scale = wavenumber * truth.pixel_size**2 / truth.radius
        lines.append(line | {"error": member.value / scale - 1, "sd": member.sd / member.value})
        # The ratio counts once.
        line = {name: value for name, value in line.items() if not name.startswith("ratio_")}
    return lines


def _light_of(lamp: str, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    return arc(rng) if lamp == "mercury" else (WAVELENGTHS, banded_light(lamp))


def _unknown(images: list[np.ndarray]) -> fitting.Together:
    return fitting.ratio(*images, light="unknown", view="reflected")


def _mean_wave(light: tuple[np.ndarray, np.ndarray], curves: np.ndarray) -> float:
    """The middle one of the channels' mean wavenumbers [1/m]."""
    wavelengths, powers = light
    products = [powers * np.interp(wavelengths, WAVELENGTHS, curve) for curve in curves]
    return float(np.median([(product / wavelengths).sum() / product.sum() for product in products]))


def other_lights(seed: int) -> dict:
    """What is answered of two pictures of which the second is under another lamp."""
    rng = np.random.default_rng([seed, 71])
    lamps = [UNKNOWN[(seed + step) % len(UNKNOWN)] for step in (0, 1 + seed // len(UNKNOWN) % 4)]
    truths = [random_truth(rng, lamp, SHAPE)._replace(blur=1.1) for lamp in lamps]
    lights = [_light_of(lamp, rng) for lamp in lamps]
    images = [picture(truth, rng, responses(), SHAPE, light=light) for truth, light in zip(truths, lights, strict=True)]
    pair, true = _unknown(images), truths[1].radius / truths[0].radius
    line = {"seed": seed, "lamps": lamps, "status": pair.status, "message": str(pair.message)}
    if pair.ratio and pair.ratio_sd:
        line |= {"error": pair.ratio / true - 1, "sd": pair.ratio_sd / pair.ratio}
    return line


def other_lamp(seed: int, lamp: str) -> dict:
    """What is answered of a picture under another lamp that is said to be mercury's."""
    rng = np.random.default_rng([seed, 29])
    truth = random_truth(rng, lamp, SHAPE)
    fit = _fit(truth, rng, responses(), None, is_jpeg=False)
    return {"seed": seed, "lamp": lamp} | _answer(fit, truth)


def _fit(truth: Truth, rng: np.random.Generator, curves: np.ndarray, lamp, is_jpeg: bool) -> fitting.FitResult:
    image = picture(truth, rng, curves, SHAPE, is_jpeg, lamp)
    # The scale is exact: of its error nothing is asked.
    return fitting.fit(image, light="mercury", pixel_size=truth.pixel_size, pixel_size_sd=0.0, view="reflected")


def summary(lines: list[dict]) -> dict:
    """Coverage and widths, on the model and off it; and what was answered under other light."""
    table: dict = {}
    for is_off, name in ((False, "on"), (True, "off")):
        pictures = [line for line in lines if line.get("off") == is_off]
        table[name] = {"pictures": len(pictures), "refused": sum("error" not in line for line in pictures)}
        first = "fringe_scale" if any("unknown" in line for line in lines) else "radius"
        for number, prefix in ((first, ""), ("ratio", "ratio_")):
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
    others = [line for line in lines if "off" not in line]
    answered = [line for line in others if "error" in line]
    table["other_light"] = {
        "pictures": len(others),
        "refused": sum(line["status"] == "refused" for line in others),
        "largest_error": max((abs(line["error"]) for line in answered), default=0.0),
        "covered": sum(abs(line["error"]) < 1.96 * line["sd"] for line in answered),
        "beyond_4_sd": sum(abs(line["error"]) > 4 * line["sd"] for line in answered),
    }
    return table


def _numbers(part: dict) -> list[dict]:
    """The rows of coverage in one part of a summary."""
    return [row for row in part.values() if isinstance(row, dict)]


def pictures_under(light: str, count: int, others: int) -> list[dict]:
    """So many cameras under "lines", "bands" or "unknown" light, and so many pictures under other light."""
    lines: list[dict] = []
    for seed in range(count):
        is_off = bool(seed % 2)
        if light == "lines":
            lines += camera(seed // 2, is_off)
        else:
            lines += banded_camera(seed, is_off) if light == "bands" else unknown_camera(seed, is_off)
    if light == "lines":
        return lines + [other_lamp(seed, OTHERS[seed % len(OTHERS)]) for seed in range(others)]
    return lines + [(other_curves if light == "bands" else other_lights)(seed) for seed in range(others)]


def main() -> None:
    """Run the cameras and the other light, and write a table for each kind of light."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cameras", type=int, default=40)
    parser.add_argument("--light", choices=RECORDS, nargs="+", default=list(RECORDS))
    parser.add_argument("--quick", action="store_true", help="two cameras and another light of each kind, none written")
    options = parser.parse_args()
    failures = 0
    for light in options.light:
        began = time.process_time()
        others = options.cameras // 4 if light == "unknown" else options.cameras
        lines = pictures_under(light, *((2, 1) if options.quick else (options.cameras, others)))
        table: dict = {**summary(lines), "cpu_seconds": time.process_time() - began}
        print(light, json.dumps(table, indent=1))
        failures += sum(row["beyond_4_sd"] for name in ("on", "off") for row in _numbers(table[name]))
        others = table["other_light"]
        failures += others["beyond_4_sd"] if light == "bands" else others["pictures"] - others["refused"]
        if not options.quick:
            record = json.dumps({"summary": table, "lines": lines}, indent=1)
            (records.RESULTS / RECORDS[light]).write_text(record + "\n")
    sys.exit(options.quick and failures > 0)


if __name__ == "__main__":
    main()
