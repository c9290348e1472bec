"""Claim: the pictures of the README are made by the code as it is.

Writes docs/rings.png (both views of one lens, and a wedge), docs/colours.png (rings in white light and in that of two
lamps) and docs/fit.png (the demo's picture of its fit).

    python -m experiments.paper.pictures
"""

import tomllib
from pathlib import Path

import jax
import numpy as np
from matplotlib.figure import Figure

import fitting
import newtonjax as nj

ROOT = Path(__file__).parents[2]


def rings() -> Figure:
    """Transmitted and reflected rings of a 2 m lens, and an air wedge, at 500 nm."""
    camera = nj.Camera((600, 600), 8.5e-6)
    scenes = {
        "transmitted, R = 2 m": nj.newton_rings(2.0, 500e-9, view="transmitted", screen=1e-3),
        "reflected, R = 2 m": nj.newton_rings(2.0, 500e-9, view="reflected", screen=1e-3),
        "air wedge, 0.5 mrad": nj.air_wedge(0.5e-3, 500e-9, gap=2e-6, screen=1e-3),
    }
    figure = Figure(figsize=(9.6, 3.5), layout="constrained")
    for axes, (title, scene) in zip(figure.subplots(1, 3), scenes.items(), strict=True):
        image = np.asarray(nj.render(scene, camera))
        drawn = axes.imshow(image, cmap="gray", extent=(-2.55, 2.55, 2.55, -2.55))
        axes.set(title=title, xlabel="x [mm]")
        figure.colorbar(drawn, ax=axes, shrink=0.75)
    return figure


def colours() -> Figure:
    """Reflected rings of a lens of 154.5 mm, as an eye sees them that is used to the lamp, or to daylight."""
    camera = nj.Camera((500, 500), 3.4e-6, response=nj.cie_1931())
    figure = Figure(figsize=(9.6, 3.6), layout="constrained")
    lamps = {"white, 5500 K": "white:5500K", "LED, 525 nm, 30 nm wide": "led:525nm/30nm", "sodium": "sodium"}
    for axes, (title, words) in zip(figure.subplots(1, 3), lamps.items(), strict=True):
        scene = nj.newton_rings(0.1545, light=words)
        xyz = np.asarray(nj.render(scene, camera))
        spectrum = scene.light.spectrum
        of_lamp = nj.cie_1931().powers(spectrum.wavelengths, spectrum.shares).sum(axis=1)
        white = of_lamp if words.startswith("white") else None
        axes.imshow(nj.to_srgb(xyz / xyz[..., 1].max(), white), extent=(-0.85, 0.85, 0.85, -0.85))
        axes.set(title=title, xlabel="x [mm]")
    return figure


def main() -> None:
    """Draw all."""
    jax.config.update("jax_enable_x64", True)
    rings().savefig(ROOT / "docs" / "rings.png", dpi=90)
    colours().savefig(ROOT / "docs" / "colours.png", dpi=90)
    data = ROOT / "fitting" / "data"
    sample = tomllib.loads((data / "sample.toml").read_text(encoding="utf-8"))
    result = fitting.fit(data / "sample.png", **sample["given"])
    result.figure().savefig(ROOT / "docs" / "fit.png", dpi=75)


if __name__ == "__main__":
    main()
