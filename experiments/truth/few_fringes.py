"""Claim: of half a fringe to six, a scale is answered where the picture determines it, and refused where it does not.

Made pictures (`few_fringe_pictures.py`): rings of 0.5 to 6 fringes with noise of 0.5 to 10 %, the centre inside or
half a field outside at most, even and uneven light and contrast, vignetting, a bright spot, blur, fading contrast, 8
bits, an exponent that is not told, dust, a round stop; and as few fringes of another law, or none. Half of them with a
pixel size, so that every part of the model is tried. An answer is right within three of its standard deviations and 15
% of the scale; off within 15 % but not three deviations; wrong beyond, as is any answer to a picture without rings.
Limits were set on seeds from 0; the table is of others, from 1000.

    python -m experiments.truth.few_fringes [--seeds 30] [--first 1000] [--quick]
"""

import argparse
from collections import Counter
from itertools import pairwise

import fitting
from experiments import records
from experiments.truth.few_fringe_pictures import OTHERS, PIXEL_SIZE, RINGS, WAVELENGTH, FewFringes, picture

_HELD_OUT = 1000
_LIMITS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)
_DEVIATIONS, _SHARE = 3.0, 0.15
_OUTCOMES = ("right", "off", "wrong", "refused")


def outcome(made: FewFringes, with_pixel_size: bool) -> dict:
    """What a fit says of one picture: its outcome, relative error and standard deviation of the scale, message."""
    scaled = {"pixel_size": PIXEL_SIZE} if with_pixel_size else {}
    result = fitting.fit(made.image, wavelength=WAVELENGTH, **scaled)
    row = {"fringes": made.fringes, "error": None, "sd": None, "message": result.message}
    if result.status not in ("ok", "no-scale"):
        return row | {"outcome": "refused"}
    scale = result.fringe_scale_per_px2
    if made.scale is None or scale is None or result.fringe_scale_sd is None:
        return row | {"outcome": "wrong"}
    error, sd = scale / made.scale - 1, result.fringe_scale_sd / scale
    honest = "right" if abs(error) < _DEVIATIONS * sd else "off"
    return row | {"error": error, "sd": sd, "outcome": honest if abs(error) < _SHARE else "wrong"}


def line(name: str, rows: list[dict]) -> dict:
    """One line of the table: how many of each outcome, the largest error, and what was refused for."""
    counts = Counter(row["outcome"] for row in rows)
    errors = [abs(row["error"]) for row in rows if row["error"] is not None]
    return (
        {"pictures": name, "count": len(rows)}
        | {key: counts[key] for key in _OUTCOMES}
        | {"worst": max(errors, default=None)}
    )


def by_fringes(name: str, rows: list[dict]) -> list[dict]:
    """Lines of the table by number of fringes."""
    return [
        line(f"{name}, {low:g} to {high:g}", [r for r in rows if low <= r["fringes"] < high])
        for low, high in pairwise(_LIMITS)
    ]


def show(table: list[dict]) -> None:
    """Print the table."""
    print(f"{'pictures':<26}{'count':>6}" + "".join(f"{key:>9}" for key in _OUTCOMES) + "   largest error")
    for row in table:
        worst = "" if row["worst"] is None else f"{row['worst']:.2%}"
        print(
            f"{row['pictures']:<26}{row['count']:>6}" + "".join(f"{row[key]:>9}" for key in _OUTCOMES) + f"   {worst}"
        )


def main() -> None:
    """Fit every picture and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=30, help="of every kind")
    parser.add_argument("--first", type=int, default=_HELD_OUT, help="seed")
    parser.add_argument("--quick", action="store_true", help="two seeds of some kinds, nothing written")
    options = parser.parse_args()
    seeds = range(options.first, options.first + (2 if options.quick else options.seeds))
    step = 3 if options.quick else 1
    rows = {
        kind: [outcome(picture(kind, seed), bool(seed % 2)) for seed in seeds]
        for kind in RINGS[::step] + OTHERS[::step]
    }
    rings, others = ([row for kind, of in rows.items() if kind in kinds for row in of] for kinds in (RINGS, OTHERS))
    table = by_fringes("rings", rings) + by_fringes("no rings", others)
    table += [line(kind, of_kind) for kind, of_kind in rows.items()]
    show(table)
    wrong = sum(row["outcome"] == "wrong" for row in rings + others)
    off = sum(row["outcome"] == "off" for row in rings)
    answered = sum(row["outcome"] != "refused" for row in rings)
    print(f"wrong {wrong} of {len(rings + others)}, beyond {_DEVIATIONS:g} deviations {off} of {answered}")
    assert wrong <= 0.01 * len(rings + others)
    assert off <= 0.05 * max(answered, 20)
    if not options.quick:
        doubtful = {kind: [row for row in of if row["outcome"] in ("off", "wrong")] for kind, of in rows.items()}
        records.save("few_fringes", {"table": table, "not right": doubtful})


if __name__ == "__main__":
    main()
