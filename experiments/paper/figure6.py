"""Claim: traced rings look as photographed ones do: a photograph beside the image rendered from its fit.

Debelov and Dolgov (2021, figures 5 and 6) show a photograph of transmitted rings beside a computed image, without a
shield, and call them alike. Here are the bare screen that they use, the bench of their figure 5 with shield and
collecting lens, and, with a photograph at hand, the test of the claim: the photograph, the image rendered from its fit,
and what is left. No photograph is part of the project: the default is one of the tests' shared folder
(NEWTONJAX_SHARED), and the picture with it goes where `--output` says.

    python -m experiments.paper.figure6 [--photograph FILE --wavelength METRES --pixel-size METRES]
        [--output FILE] [--quick]
"""

import argparse
import os
from pathlib import Path

import jax
import numpy as np
from matplotlib.figure import Figure

import fitting
import newtonjax as nj
from experiments import records

SHARED = Path(os.environ.get("NEWTONJAX_SHARED", "../shared")) / "photos" / "surface_10mm_laser.png"


def benches(size: int) -> dict[str, tuple[nj.Scene, nj.Camera]]:
    """Title: scene and camera, each over 5 mm of the gap."""
    bare = nj.newton_rings(2.0, 500e-9, view="transmitted", screen=1e-3)
    full = nj.newton_rings(2.0, 500e-9, screen=1.0, collecting_lens=0.1, shield=2e-3, view="transmitted")
    # The lens enlarges by b / a: as many times larger are the pixels on the screen.
    lens = full.collecting_lens.vertex[2]
    enlarged = (lens - full.screen.vertex[2]) / (-5e-3 / 1.5 * 0.5 - lens)
    return {
        "bare screen, 1 mm away": (bare, nj.Camera((size, size), 5e-3 / size)),
        "shield, lens (f = 0.1 m), screen 1 m away": (full, nj.Camera((size, size), 5e-3 * enlarged / size)),
    }


def compare(photograph: Path, wavelength: float, pixel_size: float) -> tuple[dict, Figure]:
    """A photograph, the image rendered from its fit, and the residual, in units of the brightest pixels."""
    result = fitting.fit(photograph, wavelength=wavelength, pixel_size=pixel_size)
    if result.picture is None:
        raise SystemExit(f"{photograph}: {result.message}")
    seen, fitted, residual = result.picture.photograph.image, result.picture.fitted, result.residual
    rows, columns = np.nonzero(result.picture.weights > 0)
    window = slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1)
    used = np.where(result.picture.weights > 0, residual, 0.0)
    table = {
        "radius_m": result.radius,
        "radius_sd_m": result.radius_sd,
        "explained_variance": result.explained_variance,
        "residual_rms": float(np.sqrt(np.mean(used[result.picture.weights > 0] ** 2))),
        "photograph_sd": float(np.std(seen[result.picture.weights > 0])),
    }
    figure = Figure(figsize=(12, 4), layout="constrained")
    shown = np.where(result.picture.weights > 0, fitted, 0.0)
    pictures = {"photograph": seen, "rendered from its fit": shown, "photograph less image": used}
    for axes, (title, picture) in zip(figure.subplots(1, 3), pictures.items(), strict=True):
        low, high = (-0.5, 0.5) if picture is used else (0.0, 1.0)
        drawn = axes.imshow(picture[window], cmap="gray", vmin=low, vmax=high)
        axes.set_title(title)
        figure.colorbar(drawn, ax=axes, shrink=0.7)
    return table, figure


def main() -> None:
    """Render the benches, compare with the photograph, and write table and figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photograph", type=Path, default=SHARED)
    parser.add_argument("--wavelength", type=float, default=635e-9, help="[m]")
    parser.add_argument("--pixel-size", type=float, default=1.3612e-6, help="at the object [m]")
    parser.add_argument("--output", type=Path, help="PNG of the comparison")
    parser.add_argument("--quick", action="store_true", help="small images, nothing written, no photograph")
    options = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    images = {name: np.asarray(nj.render(*pair)) for name, pair in benches(100 if options.quick else 600).items()}
    table = {n: {"peak": float(image.max()), "dark_share": float(np.mean(image == 0))} for n, image in images.items()}
    # A hole of 2 mm in a frame of 5 mm leaves 1 - π (2 / 5)² of it dark, but for the bending of its rim.
    lensed = table["shield, lens (f = 0.1 m), screen 1 m away"]
    assert abs(lensed["dark_share"] - (1 - np.pi * 0.16)) < 0.02, "the shield's hole is not seen at its size"
    if not options.quick:
        figure = Figure(figsize=(8, 4.3), layout="constrained")
        for axes, (name, image) in zip(figure.subplots(1, 2), images.items(), strict=True):
            records.show(axes, image, name, benches(600)[name][1].pixel_size)
        if options.photograph.is_file():
            table["photograph"], comparison = compare(options.photograph, options.wavelength, options.pixel_size)
            if options.output:
                comparison.savefig(options.output, dpi=100)
        records.save("figure6", table, figure)
    print(table)


if __name__ == "__main__":
    main()
