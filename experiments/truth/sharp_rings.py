"""Claim: rings of many beams are measured, finesse and fringe scale within their intervals, and give no radius.

Made pictures of Airy's law of a finesse of 3 to 30, bright rings or dark ones, 3 to 8 in view, uneven light, 1 or 3 %
noise, some behind a lens that distorts by up to 2 % at the corner: there the scale is that at the centre.

    python -m experiments.truth.sharp_rings [--pictures 40] [--quick]
"""

import argparse
from typing import NamedTuple

import numpy as np

import fitting
from experiments import records


class Made(NamedTuple):
    """A picture, its fringe scale [per px²], and its finesse between half levels."""

    image: np.ndarray
    scale: float
    finesse: float


def half_level_finesse(ratio: float) -> float:
    """Period over the full width half way between brightest and darkest of Airy's sum: cos φ = 2 ρ / (1 + ρ²)."""
    return float(np.pi / np.arccos(2 * ratio / (1 + ratio**2)))


def made(seed: int, finesse: float | None = None) -> Made:
    """A picture of rings between mirrors of a reflecting finesse, π √ρ / (1 - ρ)."""
    rng = np.random.default_rng((seed, 251))
    finesse = float(np.exp(rng.uniform(np.log(3), np.log(30)))) if finesse is None else finesse
    half = 1 + np.pi**2 / (2 * finesse**2)
    ratio = half - np.sqrt(half**2 - 1)
    orders = rng.uniform(3, 8)
    # The narrowest ring is two pixels wide at least.
    corner = max(250.0, 4.2 * finesse * orders)
    rows, columns = (int(share * corner) for share in (1.05, 1.3))
    y, x = np.mgrid[:rows, :columns]
    centre_x, centre_y = rng.uniform(0.42, 0.58, 2) * (columns, rows)
    square = (x - centre_x) ** 2 + (y - centre_y) ** 2
    scale = orders / float(square.max())
    bent = 1 + rng.choice([0.0, 0.04]) * rng.uniform(-1, 1) * square / square.max()
    phase = np.pi * (scale * square * bent + rng.uniform())
    wave = 1 / (1 + (2 * finesse / np.pi) ** 2 * np.sin(phase) ** 2)
    wave = 1 - 0.8 * wave if rng.random() < 0.3 else wave
    across, down = x / columns - 0.5, y / rows - 0.5
    slope_x, slope_y, fall = (*rng.uniform(-0.3, 0.3, 2), rng.uniform(0, 0.6))
    lamp = 0.7 + slope_x * across + slope_y * down - fall * (across**2 + down**2)
    light = 0.15 + lamp * wave + rng.normal(0, rng.choice([0.01, 0.03]), x.shape)
    return Made(np.round(np.clip(light / 1.2, 0, 1) * 65535).astype(np.uint16), scale, half_level_finesse(ratio))


def deviations(picture: Made) -> dict[str, float] | None:
    """Of finesse and fringe scale from the truth, in standard deviations; None where they were not measured."""
    result = fitting.fit(picture.image, wavelength=500e-9, pixel_size=10e-6)
    if result.status != "refused" or result.radius is not None:
        raise SystemExit(f"{result.status}: an answer from two beams")
    truth = {"fringe_scale": picture.scale, "finesse": picture.finesse}
    if result.reason != "MANY_BEAM_RINGS":
        return None
    found = result.parameters
    return {name: (found[name].value - value) / found[name].sd for name, value in truth.items()}


def main() -> None:
    """Count how often the intervals cover, print and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", type=int, default=40)
    parser.add_argument("--quick", action="store_true", help="4 pictures, nothing written")
    options = parser.parse_args()
    count = 4 if options.quick else options.pictures
    rows = [deviations(made(seed)) for seed in range(count)]
    measured = [row for row in rows if row is not None]
    record = {"pictures": count, "measured": len(measured)}
    for name in ("fringe_scale", "finesse"):
        values = np.array([row[name] for row in measured])
        record[f"{name} covered"] = float(np.mean(np.abs(values) < 1.96))
        record[f"{name} beyond 4 sd"] = int(np.sum(np.abs(values) > 4))
    print(record)
    if not options.quick:
        records.save("sharp_rings", record)
    if record["measured"] < 0.9 * count or record["fringe_scale beyond 4 sd"] + record["finesse beyond 4 sd"]:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
