"""Claim: the index of a liquid by rings in air and in it lies within its interval, whatever the scale is.

Pairs of made tables of one lens, in air and in a liquid: 5 to 20 rings, diameters read with one sd, to a micrometre.
The scale is off by 2 % and the wavelength by 1 %, the same in both tables of a pair: they cancel.

    python -m experiments.truth.liquids [--pairs 500] [--quick]
"""

import argparse

import numpy as np

import fitting
from experiments import records

WAVELENGTH = 589.3e-9


def pair(seed: int, index: float) -> list[dict[str, np.ndarray]]:
    """Tables in air and in a liquid."""
    rng = np.random.default_rng((seed, 26))
    radius, count, sd = 10 ** rng.uniform(-0.5, 0.5), int(rng.integers(5, 21)), 10 ** rng.uniform(-5.7, -4.9)
    order, scale, wavelength = (
        np.arange(1.0, count + 1),
        1 + 0.02 * rng.normal(),
        WAVELENGTH * (1 + 0.01 * rng.normal()),
    )
    tables = []
    for gap_index in (1.0, index):
        height = order * wavelength / (2 * gap_index)
        diameters = scale * 2 * np.sqrt(2 * radius * height - height**2) + sd * rng.normal(size=count)
        tables.append({"order": order, "diameter_mm": np.round(1e3 * diameters, 3)})
    return tables


def covered(seed: int, index: float) -> tuple[bool, float]:
    """Whether the interval holds the index, and the deviation in standard deviations."""
    results = [fitting.rings(table, wavelength=WAVELENGTH) for table in pair(seed, index)]
    result = fitting.compare(results, "gap_index")
    low, high = result.interval
    return low < index < high, (result.value - index) / result.sd


def main() -> None:
    """Count how often the interval covers, print and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=500)
    parser.add_argument("--quick", action="store_true", help="60 pairs, nothing written")
    options = parser.parse_args()
    count = 60 if options.quick else options.pairs
    rows = [covered(seed, 1.29) for seed in range(count)]
    share = float(np.mean([inside for inside, _ in rows]))
    record = {
        "pairs": count,
        "index": 1.29,
        "covered": share,
        "median deviation": float(np.median([d for _, d in rows])),
    }
    print(record)
    if options.quick:
        return
    records.save("liquids", record)
    if not 0.93 <= share <= 0.97:
        raise SystemExit(f"{share:.1%} covered")


if __name__ == "__main__":
    main()
