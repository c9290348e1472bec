"""The sample photograph of `newtonjax demo`: reflected rings whose true radius is known.

Claim: the demo's radius is within three of its standard deviations of the 0.8462 m from which the sample is made here:
a traced bench seen through a microscope focused on the gap, with vignetting (25 % in the corners), shot and read noise,
and rounding to 8 bits in sRGB. Writes fitting/data/sample.png and sample.toml; the seed is fixed.

    python -m experiments.truth.make_sample [FOLDER]
"""

import sys
from pathlib import Path

import jax
import numpy as np
import tomli_w

import newtonjax as nj
from fitting.parameters import png

RADIUS, WAVELENGTH, PIXEL_SIZE = 0.8462, 589.294e-9, 8e-6
SHAPE, CENTRE_PX, SEED = (480, 640), (352.4, 217.8), 20210
VIGNETTING = 0.25
DATA = Path(__file__).resolve().parents[2] / "fitting" / "data"


def photograph() -> np.ndarray:
    """The fraction of full scale at every pixel, linear."""
    scene = nj.newton_rings(RADIUS, WAVELENGTH, view="reflected", screen="gap")
    camera = nj.Camera(SHAPE, PIXEL_SIZE, CENTRE_PX)
    image = np.asarray(nj.render(scene, camera, nj.Chebyshev(17)))
    y, x = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]]
    from_middle = (x - (SHAPE[1] - 1) / 2) ** 2 + (y - (SHAPE[0] - 1) / 2) ** 2
    lit = image / image.max() * (1 - VIGNETTING * from_middle / from_middle.max())
    exposed = nj.Camera(SHAPE, PIXEL_SIZE, full_well=4000.0, read_noise=10.0, exposure=3200.0, bits=16)
    return np.asarray(exposed.expose(lit, jax.random.key(SEED))) / 65535


def main(folder: Path = DATA) -> None:
    """Write the photograph, and beside it the truth and what a user would know."""
    jax.config.update("jax_enable_x64", True)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "sample.png").write_bytes(png.encode(photograph(), 8))
    tables = {
        "truth": {"radius": RADIUS, "centre_px": list(CENTRE_PX)},
        "given": {
            "wavelength": WAVELENGTH,
            "wavelength_sd": 0.15e-9,
            "pixel_size": PIXEL_SIZE,
            "pixel_size_sd": 0.01e-6,
            "view": "reflected",
        },
    }
    text = "# Made by experiments/truth/make_sample.py; metres and pixels.\n" + tomli_w.dumps(tables)
    (folder / "sample.toml").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
