"""Claim: rulers, discs and rings give the pixel size within its interval.

The pictures are those of `scale_pictures`, of seeds that nothing was set on. A tilted disc's standard deviation holds
half of its stretch, and covers more than 95 %. The brightest of the clipped discs lie 60 % above the largest code.

    python -m experiments.truth.scales [--pictures 300] [--quick]
"""

import argparse

import numpy as np

import fitting
from experiments import records
from experiments.truth.scale_pictures import SIZE, disc, ruler

KINDS = "ruler", "disc", "disc, tilted", "disc, clipped", "ring"
_FIRST_SEED = 10_000
# Covered at least, at most where the model is right, largest deviation of a hundred, refused at most.
_LEAST, _MOST, _LARGEST, _REFUSED = 0.93, 0.97, 4.0, 0.05


def deviation(kind: str, seed: int) -> float | None:
    """By how many standard deviations the pixel size is off; None where it is refused."""
    if kind == "ruler":
        image, division = ruler(seed)
        result = fitting.scale(image, ruler=division, transfer="linear")
    else:
        image, diameter = disc(seed, kind)
        result = fitting.scale(image, disc_diameter=diameter, transfer="linear")
    size, size_sd = result.pixel_size, result.pixel_size_sd
    return None if size is None or size_sd is None else (size - SIZE) / size_sd


def row_of(deviations: list[float | None]) -> dict[str, float]:
    """Counts and shares of one kind of picture."""
    answered = np.array([value for value in deviations if value is not None] or [0.0])
    return {
        "pictures": len(deviations),
        "refused": sum(value is None for value in deviations),
        "covered": float(np.mean(np.abs(answered) < 1.96)),
        "rms": float(np.sqrt(np.mean(answered**2))),
        "beyond four": int(np.sum(np.abs(answered) > _LARGEST)),
        "largest": float(np.abs(answered).max()),
    }


def misses(kind: str, row: dict[str, float]) -> list[str]:
    """What a row does not keep; chance is allowed two standard deviations of the share."""
    chance = 2 * np.sqrt(0.95 * 0.05 / max(row["pictures"], 1))
    limits = {
        "covered": row["covered"] < min(_LEAST, 0.95 - chance),
        "covers too much": kind != "disc, tilted" and row["covered"] > max(_MOST, 0.95 + chance),
        "beyond four": row["beyond four"] > row["pictures"] / 100,
        "refused": row["refused"] > _REFUSED * row["pictures"] + 1,
    }
    return [f"{kind}: {name}" for name, is_missed in limits.items() if is_missed]


def main() -> None:
    """Count how often the interval covers, print and write; exits with 1 where a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", type=int, default=300, help="of each kind")
    parser.add_argument("--quick", action="store_true", help="12 of each kind, nothing written")
    options = parser.parse_args()
    count, record, missed = 12 if options.quick else options.pictures, {}, []
    for kind in KINDS:
        record[kind] = row_of([deviation(kind, _FIRST_SEED + number) for number in range(count)])
        missed += misses(kind, record[kind])
        print(kind, record[kind], flush=True)
    if not options.quick:
        records.save("scales", record)
    if missed:
        raise SystemExit("missed: " + "; ".join(missed))


if __name__ == "__main__":
    main()
