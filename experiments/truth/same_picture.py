"""Claim: what does not change the rings does not change the answer by more than the stated deviation.

Every photograph of rings in the shared folder, and variants of it: turned, mirrored, means over 2 x 2, cut to 70 % of
its width or height from each side, each colour, saved as JPEG 80, brighter, darker, with 1 % of noise, and with or
without a pixel size. Each variant's fringe scale is compared with that of the picture itself, in units of the larger
of both standard deviations. Nobody knows the true radii: this is a test of honesty, not of accuracy.

Of 170 pairs that answer 98 % lie within 2 deviations, of the cuts 96 %; one lies beyond 3.5, a cut. Turned and mirrored
pictures agree within 0.14.

    python -m experiments.truth.same_picture [--names NAME ...] [--quick]
"""

import argparse
import os
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np

from experiments import records

SHARED = Path(os.environ.get("NEWTONJAX_SHARED", "../shared"))
SODIUM = {"wavelength": 589.3e-9}
GIVEN = {
    "photos/lens_1000mm_sodium.jpg": {**SODIUM, "pixel_size": 12.745e-6},
    "photos/surface_10mm_laser.png": {"wavelength": 635e-9, "pixel_size": 1.3612e-6},
    "photos/phone_1m_crosshair_a.jpg": SODIUM,
    "photos/phone_1m_crosshair_b.jpg": SODIUM,
    "photos/phone_1m_dark.jpg": SODIUM,
    "photos/phone_flat_contact.jpg": SODIUM,
    "photos/phone_blurred_cropped.jpg": SODIUM,
    "photos/eyepiece_off_centre.jpg": SODIUM,
    "photos/eyepiece_centre_at_rim.jpg": SODIUM,
    "photos/eyepiece_arcs.jpg": SODIUM,
    "photos/eyepiece_centre_outside.jpg": SODIUM,
    "photos/led_red_scale_overlay.jpg": {"wavelength": 625e-9},
    "trials/lens_850mm_sodium.jpg": {**SODIUM, "pixel_size": 12.745e-6},
}
# A pixel size for those that have none: every answer may then be a radius.
MADE_UP = 10e-6
CUT = 0.7
# Deviations by which a picture and its mirror may differ: rounding, and where blocks of pixels begin.
SAME = 0.1


def _binned(image: np.ndarray) -> np.ndarray:
    rows, columns = (n // 2 * 2 for n in image.shape[:2])
    blocks = image[:rows, :columns].reshape(rows // 2, 2, columns // 2, 2, -1).astype(float).mean(axis=(1, 3))
    return np.round(blocks.reshape(rows // 2, columns // 2, *image.shape[2:])).astype(image.dtype)


def _saved(image: np.ndarray) -> np.ndarray:
    import imageio.v3 as iio

    file = BytesIO(iio.imwrite("<bytes>", image, extension=".jpg", quality=80))
    return np.asarray(iio.imread(file, extension=".jpg"))


def _scaled(image: np.ndarray, factor: float) -> np.ndarray:
    return np.clip(np.round(image * factor), 0, np.iinfo(image.dtype).max).astype(image.dtype)


def _noisy(image: np.ndarray) -> np.ndarray:
    noise = 0.01 * np.iinfo(image.dtype).max * np.random.default_rng(0).normal(size=image.shape)
    return np.clip(np.round(image + noise), 0, np.iinfo(image.dtype).max).astype(image.dtype)


def _cut(image: np.ndarray, side: str) -> np.ndarray:
    rows, columns = (round(CUT * n) for n in image.shape[:2])
    return {
        "left": image[:, :columns],
        "right": image[:, -columns:],
        "top": image[:rows],
        "bottom": image[-rows:],
    }[side]


VARIANTS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "rotated": np.rot90,
    "mirrored": np.fliplr,
    "binned": _binned,
    **{f"cut, {side} kept": lambda image, side=side: _cut(image, side) for side in ("left", "right", "top", "bottom")},
    **{name: lambda image, k=k: image[..., k] for k, name in enumerate(("red", "green", "blue"))},
    "JPEG 80": _saved,
    "darker": lambda image: _scaled(image, 0.8),
    "brighter": lambda image: _scaled(image, 1.1),
    "noisy": _noisy,
    "scale": lambda image: image,
}


def measured(image: np.ndarray, given: dict) -> dict:
    """The answer's fringe scale and deviation, and what it was made with."""
    import fitting

    result = fitting.fit(np.ascontiguousarray(image), **given)
    evidence = result.evidence
    return {
        "status": result.status,
        "message": result.message,
        "scale": result.fringe_scale_per_px2,
        "sd": result.fringe_scale_sd,
        "parts": [] if evidence is None else list(evidence.found.parts),
        "transfer": result.model.get("channel"),
        "explained": result.explained_variance,
        "seconds": result.seconds,
    }


def pairs(name: str, variants: tuple[str, ...] = tuple(VARIANTS)) -> list[dict]:
    """A photograph's variants, each next to the photograph itself."""
    import imageio.v3 as iio

    image, given = np.asarray(iio.imread(SHARED / name)), GIVEN[name]
    whole, rows = measured(image, given), []
    for variant in variants:
        if image.ndim == 2 and variant in ("red", "green", "blue"):
            continue
        changed, binning = dict(given), 2 if variant == "binned" else 1
        if "pixel_size" in changed:
            changed["pixel_size"] *= binning
        if variant == "scale" and changed.pop("pixel_size", None) is None:
            changed["pixel_size"] = MADE_UP
        row = {"name": name, "variant": variant, "whole": whole}
        row |= {"variant_answer": (answer := measured(VARIANTS[variant](image), changed))}
        if answer["scale"] and whole["scale"] and answer["status"] in ("ok", "no-scale"):
            scale, sd = (answer[key] / binning**2 for key in ("scale", "sd"))
            row["difference"] = scale / whole["scale"] - 1
            row["apart"] = (scale - whole["scale"]) / max(sd, whole["sd"])
        rows.append(row)
    return rows


def _line(row: dict) -> str:
    answer = row["variant_answer"]
    if "apart" not in row:
        return f"{row['name'][7:]:32} {row['variant']:18} {answer['status']}: {answer['message'][:70]}"
    relative = [100 * part["sd"] / part["scale"] for part in (row["whole"], answer)]
    parts = " ".join("".join(word[0] for word in part.split("_")) for part in answer["parts"])
    transfer = answer["transfer"].split("exponent")[1][:6] if "exponent" in answer["transfer"] else ""
    return (
        f"{row['name'][7:]:32} {row['variant']:18} {row['apart']:+7.2f} sd {100 * row['difference']:+8.3f} %"
        f"  sd {relative[0]:.3f} {relative[1]:.3f} %  {parts:12} {transfer}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--names", nargs="*", default=list(GIVEN), choices=list(GIVEN))
    parser.add_argument("--quick", action="store_true", help="three variants of two photographs, nothing written")
    options = parser.parse_args()
    if not (SHARED / "photos").is_dir():
        print(f"no photographs in {SHARED} (NEWTONJAX_SHARED): nothing to compare")
        return
    names, variants = options.names, tuple(VARIANTS)
    if options.quick:
        names, variants = names[1:3], ("rotated", "mirrored", "binned")
    rows = []
    for name in names:
        for row in pairs(name, variants):
            print(_line(row), flush=True)
            rows.append(row)
    table = summary(rows)
    for key, value in table.items():
        print(f"{key}: {value}")
    if options.quick:
        same = [row for row in rows if row["variant"] in ("rotated", "mirrored")]
        assert all(abs(row["apart"]) < SAME for row in same), "a picture that is turned has another answer"
    elif names == list(GIVEN):
        records.save("same_picture", {"summary": table, "pairs": rows})


def summary(rows: list[dict]) -> dict:
    """Shares of the pairs that answer, within and beyond deviations."""
    apart = np.array([abs(row["apart"]) for row in rows if "apart" in row])
    wholes = {row["name"]: row["whole"] for row in rows}.values()
    cuts = np.array([abs(row["apart"]) for row in rows if "apart" in row and row["variant"].startswith("cut")])
    return {
        "pairs": len(rows),
        "answered": len(apart),
        "within 2": float(np.mean(apart <= 2)),
        "cuts within 2": float(np.mean(cuts <= 2)) if len(cuts) else None,
        "beyond 3.5": int(np.sum(apart > 3.5)),
        "largest": float(apart.max()),
        "median sd": float(np.median([one["sd"] / one["scale"] for one in wholes if one["scale"]])),
    }


if __name__ == "__main__":
    main()
