"""Claim: every number that the paper prints, beside ours.

Reads what the experiments on Debelov and Dolgov (2021) left in `results` and writes `results/paper.md`: run it after
`figure4.py`, `figure7.py`, `figure10.py`, `textbook.py` and `wavelets.py`, as `make experiments` does.

    python -m experiments.paper.paper
"""

import json

import newtonjax as nj
from experiments.records import RESULTS

OURS = "the same; 5 mm of glass and a screen 1 mm away, which the paper does not state, are ours"


def result(name: str):
    """What an experiment left."""
    return json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))


def rows() -> list[tuple[str, str, str, str]]:
    """Place in the paper, what it says, what we get, and by which experiment."""
    return [
        ("2.1", "partially polarized light: up to three components", "two do, as three do to 1e-12", "the tests"),
        ("3", "a pixel of 0.01 mm at 500 nm fits a hundred wavelengths", f"{0.01e-3 / 500e-9:.0f} fit", ""),
        *wavelets(),
        *wedge(),
        *radius(),
        *third_beam(),
    ]


def wavelets() -> list[tuple[str, str, str, str]]:
    """Sections 3 and 5."""
    near = {row["screen_m"]: row for row in result("wavelets")["screens"] if row["view"] == "reflected"}
    off = ", ".join(f"{near[screen]['error_waves']:.1g}" for screen in (1e-3, 1e-2, 1e-1))
    limit = near[1e-1]["hundredth_beyond_m"] * 1e3
    return [
        (
            "3",
            "spherical wavelets serve",
            f"off by {off} wave with the screen at 1, 10, 100 mm (R = 2 m, 3 mm from the axis, reflected)",
            "`wavelets.py`",
        ),
        (
            "5",
            "the limits of the approach need further study",
            f"over 1/100 wave {limit:.1f} mm from the axis with the screen at 100 mm; useless behind a caustic",
            "`wavelets.py`",
        ),
    ]


def wedge() -> list[tuple[str, str, str, str]]:
    """Section 4.1."""
    found = result("figure4")
    energies = {beam.name: beam.energy for beam in nj.enumerate_beams((1.0, 1.5, 1.0, 1.5, 1.0), "reflected")}
    apart, height = found["apart_on_the_screen_px"], found["meeting_height_m"]["R1 R3"] * 1e3
    return [
        (
            "4.1",
            "R1 to R4 are of about the same order",
            ", ".join(f"{energies[f'R{face}']:.4f}" for face in range(4)),
            "`figure4.py`",
        ),
        (
            "4.1",
            "R1 meets R3 in one pixel, R2 meets R4 in another",
            f"as the faces 0 to 3, {apart['R1 R3']:.2f} and {apart['R2 R4']:.2f} pixels apart, all others "
            f"{apart['R3 R4']:.1f} and more: light 10 mrad oblique, lens focused {height:.0f} mm over the gap",
            "`figure4.py`",
        ),
    ]


def radius() -> list[tuple[str, str, str, str]]:
    """Section 4.2."""
    found = result("figure7")["ours"]
    bias = {(line["view"], line["screen_m"]): line["formula_mean"] for line in result("textbook")}
    lines = [("4.2", "lens radius 2 m, 500 nm, pixels of 0.005 mm, n = 1.5", OURS, "`figure7.py`")]
    for order, pixel, printed in ((1, 142, 2002.2), (6, 470, 2003.9)):
        ring = found[f"ring {order}"]
        whole, between = ring["radius_whole_pixel_m"] * 1e3, ring["radius_between_pixels_m"] * 1e3
        place = ring["pixel, counted as the paper does"]
        lines += [
            ("4.2", f"ring {order} at pixel {pixel}", f"{place:.2f}, read as {ring['whole pixel']}", "`figure7.py`"),
            (
                "4.2",
                f"ring {order} gives {printed} mm",
                f"{whole:.1f} mm from whole pixels, {between:.1f} mm between them",
                "`figure7.py`",
            ),
        ]
    formula, bench = found["whole image, gap formula_m"] * 1e3, found["whole image, bench_m"] * 1e3
    said = (
        f"the formula still gives {formula:.1f} mm over the whole image: the bare screen biases it by "
        f"{100 * bias['transmitted', 1e-3]:+.2f} % with that glass and screen; with the bench as the model "
        f"{bench:.6f} mm"
    )
    return [*lines, ("4.2", "the error is related to the pixel size", said, "`figure7.py`, `textbook.py`")]


def third_beam() -> list[tuple[str, str, str, str]]:
    """Section 4.3."""
    found = result("figure10")
    weak = found["and the next order in the gap"]
    plate, lens = (found[name]["contrast_over_half_a_wave_of_glass"] for name in list(found)[1:3])
    said = (
        f"contrast {found['R1, R2']['contrast']['Chebyshev']:.3f} of two; a third beam that brings "
        f"{100 * weak['share_of_the_light']:.2f} % of the light takes the paper's mean of pairs down to "
        f"{weak['contrast']['Splat']:.2f}, and leaves the sum of fields at {weak['contrast']['Chebyshev']:.3f}; "
        f"reflections at the plate's lower and the lens's flat face make it {plate[0]:.2f} to {plate[1]:.2f} and "
        f"{lens[0]:.2f} to {lens[1]:.2f}, by the thickness of the glass"
    )
    return [("4.3", "reflected rings of two beams, and of three", said, "`figure10.py`")]


def main() -> None:
    """Write the table."""
    lines = ["| place | the paper says | we get | by |", "|---|---|---|---|"]
    lines += [f"| {' | '.join(row)} |" for row in rows()]
    (RESULTS / "paper.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
