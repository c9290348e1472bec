"""Claim: what one picture does not separate of blur, line width, source size and doublet is said, pair by pair.

Fisher's information of a quarter of a picture of 1000 x 1000 pixels, 60 rings to its side, 1 % noise: by how much the
bounds of two numbers grow when both are unknown instead of one, beside radius, gap, exposure and contrast.

    python -m experiments.truth.separable [--quick]
"""

from typing import NamedTuple

import numpy as np

import newtonjax as nj
from experiments import records
from fitting import Information, information

SODIUM, RADIUS, RINGS = 589.3e-9, 1.0, 60
BESIDE = ("radius", "gap", "exposure", "contrast")
# As wide as each of them takes some tenths of the outermost fringes, and the two lines of sodium.
WIDTH, SINE, BLUR = 2e-9, 0.06, 1.2
LINES = (588.995e-9, 589.592e-9)


class Case(NamedTuple):
    """Two numbers, and the order at the centre."""

    first: str
    second: str
    order: int


CASES = (
    Case("blur", "lorentzian_width", 0),
    Case("blur", "gaussian_width", 0),
    Case("blur", "source_size", 0),
    Case("gaussian_width", "source_size", 0),
    Case("source_size", "radius", 0),
    Case("blur", "line_splitting", 0),
    Case("gaussian_width", "line_splitting", 0),
    Case("gaussian_width", "line_splitting", 440),
)


def bounds(case: Case, pixels: int) -> Information:
    """The information of a quarter picture in both numbers and in those beside them."""
    names = {case.first, case.second}
    is_doublet = "line_splitting" in names
    lines = LINES if is_doublet else (SODIUM,)
    # Narrow where the path is long.
    width = 0.02e-9 if case.order else WIDTH
    widths = {shape: (width,) * len(lines) for shape in ("gaussian", "lorentzian") if f"{shape}_width" in names}
    spectrum = nj.Spectrum(lines, (2.0, 1.0) if is_doublet else (1.0,), **widths)
    light = spectrum if widths or is_doublet else None
    scene = nj.newton_rings(
        RADIUS,
        SODIUM,
        0.1e-6 + case.order * SODIUM / 2,
        light=light,
        numerical_aperture=SINE if "source_size" in names else None,
    )
    side = np.sqrt(RINGS * RADIUS * SODIUM)
    blur = BLUR * pixels / 500 if "blur" in names else None
    camera = nj.Camera((pixels, pixels), side / pixels, centre_px=(0.0, 0.0), blur=blur)
    noise = 0.01 * 0.04 * pixels / 500
    free = tuple(dict.fromkeys((*BESIDE, case.first, case.second)))
    return information(scene, camera, free=free, noise=noise)


def row(case: Case, pixels: int) -> dict:
    """The correlation of both numbers, and by how much each bound and the radius's grows when the other is unknown."""
    joint = bounds(case, pixels)
    covariance = joint.covariance
    first, second = joint.position(case.first), joint.position(case.second)
    deviations = np.sqrt(np.diag(covariance))

    def growth(name: str, fixed: str) -> float:
        return float(joint.sd(name) / joint.with_sd(**{fixed: 0.0}).sd(name))

    return {
        "first": case.first,
        "second": case.second,
        "orders": f"{case.order} to {case.order + RINGS}",
        "correlation": float(covariance[first, second] / deviations[first] / deviations[second]),
        "sd of the first": growth(case.first, case.second),
        "sd of the second": growth(case.second, case.first),
        "sd of the radius": growth("radius", case.second if case.second != "radius" else case.first),
    }


def table(rows: list[dict]) -> str:
    """For docs/uncertainty.md."""
    lines = [
        "| numbers | orders | correlation | sd of the first x | of the second x | of R x |",
        "|---|---|---|---|---|---|",
    ]
    for each in rows:
        names = f"`{each['first']}`, `{each['second']}`"
        factors = (f"{each[f'sd of the {of}']:.2g}" for of in ("first", "second", "radius"))
        lines.append(f"| {names} | {each['orders']} | {each['correlation']:+.6f} | {' | '.join(factors)} |")
    return "\n".join(lines)


def main() -> None:
    """Print the table and write it."""
    options = records.arguments(__doc__, "150 pixels to a side, nothing written")
    rows = [row(case, 150 if options.quick else 500) for case in CASES]
    print(table(rows))
    if not options.quick:
        records.save("separable", rows)


if __name__ == "__main__":
    main()
