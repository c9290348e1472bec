"""Claim: what resembles Newton's rings is refused or measured within its interval, and what they are is not refused.

Made pictures (`rival_pictures.py`) of twenty kinds: another law of rings (equidistant circles, the fourth power,
spirals, saddles, cylinders), for which any answer is wrong; another waveform or a second pattern (many beams, two
systems, ghosts, grids, two spectral lines); another surface (astigmatism, for which the radius of the mean curvature is
right, coma, trefoil); and what cameras and people add (motion, interlace, overexposure, JPEG, print, crosshair,
droplets). An answer is confidently wrong beyond four standard deviations, or where there is no radius at all. One
picture in four has no pixel size, and its fringe scale is judged. Beside them plain rings with two ordinary defects,
which may be refused in 2 % at most; rings of a JPEG of quality 50; and rings with noise alone, of which each rival
speaks up by chance in at most 1 %.
Thresholds were set on seeds from 0, and some looking at those from 5000 to 69 999; the table is of others, from 70 000.

    python -m experiments.truth.rivals [--seeds 20] [--plain 200] [--first 70000] [--quick]
"""

import argparse
from collections import Counter

import fitting
from experiments import records
from experiments.truth.plain_pictures import UNSCALED, jpeg_50, on_model, ordinary
from experiments.truth.ring_field import PIXEL_SIZE, WAVELENGTH
from experiments.truth.rival_pictures import KINDS, RivalPicture, picture

_HELD_OUT = 70_000
_COVERED, _DEVIATIONS = 1.96, 4.0
_PLAIN = {"on the model": on_model, "ordinary defects": ordinary, "JPEG 50": jpeg_50}
# As it is today: none of 400.
_MOST_WRONG = 0.0


def outcome(made: RivalPicture, seed: int) -> dict:
    """What a fit says of one picture: whether it answers, its relative error, and that in standard deviations."""
    scaled = {} if seed % UNSCALED == 0 else {"pixel_size": PIXEL_SIZE}
    result = fitting.fit(made.image, wavelength=WAVELENGTH, **scaled)
    row = {"seed": seed, "strength": made.strength, "message": result.message, "error": None, "sd": None}
    if result.status not in ("ok", "no-scale"):
        return row | {"answered": False, "covered": False, "confidently wrong": False}
    row["message"] = ""
    if made.radius is None:
        return row | {"answered": True, "covered": False, "confidently wrong": True}
    scale = PIXEL_SIZE**2 / (made.radius * WAVELENGTH)
    error, sd = result.fringe_scale_per_px2 / scale - 1, result.fringe_scale_sd / result.fringe_scale_per_px2
    row |= {"answered": True, "error": error, "sd": sd}
    return row | {
        "covered": bool(abs(error) < _COVERED * sd),
        "confidently wrong": bool(abs(error) > _DEVIATIONS * sd),
    }


def line(name: str, rows: list[dict]) -> dict:
    """One line of the table."""
    answered = [row for row in rows if row["answered"]]
    errors = sorted(abs(row["error"]) for row in answered if row["error"] is not None)
    deviations = sorted(row["sd"] for row in answered if row["sd"] is not None)
    return {
        "kind": name,
        "pictures": len(rows),
        "answered": len(answered),
        "covered": sum(row["covered"] for row in answered),
        "refused": len(rows) - len(answered),
        "confidently wrong": sum(row["confidently wrong"] for row in rows),
        "median error": errors[len(errors) // 2] if errors else None,
        "median sd": deviations[len(deviations) // 2] if deviations else None,
    }


def show(table: list[dict]) -> None:
    """Print the table."""
    counts = ("pictures", "answered", "covered", "refused", "confidently wrong")
    print(f"{'kind':<22}" + "".join(f"{name:>{len(name) + 2}}" for name in counts) + "  median error, sd")
    for row in table:
        numbers = "".join(f"{row[name]:>{len(name) + 2}}" for name in counts)
        size = "" if row["median sd"] is None else f"  {row['median error']:.4%}, {row['median sd']:.4%}"
        print(f"{row['kind']:<22}{numbers}{size}")


def main() -> None:
    """Fit every picture, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20, help="of every kind")
    parser.add_argument("--plain", type=int, default=200, help="seeds of plain rings, of each of three kinds")
    parser.add_argument("--first", type=int, default=_HELD_OUT, help="seed")
    parser.add_argument("--kinds", nargs="*", default=KINDS, choices=KINDS)
    parser.add_argument("--quick", action="store_true", help="one seed of every other kind, nothing written")
    options = parser.parse_args()
    each, plain = (1, 2) if options.quick else (options.seeds, options.plain)
    first = options.first + 1 if options.quick else options.first
    names = options.kinds[::2] if options.quick else options.kinds
    rows = {kind: [outcome(picture(kind, seed), seed) for seed in range(first, first + each)] for kind in names}
    rows |= {kind: [outcome(make(seed), seed) for seed in range(first, first + plain)] for kind, make in _PLAIN.items()}
    table = [line(kind, of_kind) for kind, of_kind in rows.items()]
    show(table)
    rivals, plain_rings = table[: len(names)], table[len(names) :]
    wrong = sum(row["confidently wrong"] for row in rivals)
    print(f"confidently wrong {wrong} of {sum(row['pictures'] for row in rivals)}")
    for row in plain_rings:
        assert row["refused"] <= 0.02 * row["pictures"] + 1, row
    assert wrong <= _MOST_WRONG * sum(row["pictures"] for row in rivals)
    if not options.quick:
        reasons = {kind: Counter(row["message"] for row in of if row["message"]) for kind, of in rows.items()}
        doubtful = {kind: [row for row in of if row["confidently wrong"]] for kind, of in rows.items()}
        records.save(
            "rivals", {"first seed": options.first, "table": table, "confidently wrong": doubtful, "refused": reasons}
        )


if __name__ == "__main__":
    main()
