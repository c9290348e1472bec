"""Lines of lamps: wavelengths in standard air and relative strengths. No JAX here: the shell's `--help` reads it.

Wavelengths and strengths: J. E. Sansonetti and W. C. Martin, Handbook of Basic Atomic Spectroscopic Data, J. Phys.
Chem. Ref. Data 34, 1559 (2005), NIST Standard Reference Database 108; sodium's and the laser's: NIST Atomic Spectra
Database (the vacuum line 632.9912 nm of the mise en pratique of the metre over 1.000277). Strengths are those of the
handbook's lamps, rough even for these: a measured spectrum of the lamp at hand is better. Those of sodium are the
statistical weights of its upper levels.
"""

import difflib

# By lamp, the lines within 380 to 780 nm: wavelength in air [nm], relative strength.
LAMPS: dict[str, tuple[tuple[float, float], ...]] = {
    "sodium": ((588.9950, 2.0), (589.5924, 1.0)),
    "mercury": (
        (404.656, 1800.0), (407.783, 150.0), (435.833, 4000.0),
        (546.074, 1100.0), (576.960, 240.0), (579.066, 280.0),
    ),
    "hydrogen": ((410.174, 15.0), (434.047, 30.0), (486.133, 80.0), (656.279, 300.0)),
    "cadmium": ((467.815, 200.0), (479.991, 300.0), (508.582, 1000.0), (643.847, 2000.0)),
    "helium": (
        (388.865, 500.0), (447.148, 200.0), (471.315, 30.0), (492.193, 20.0),
        (501.568, 100.0), (587.562, 500.0), (667.815, 100.0), (706.519, 200.0),
    ),
    "hene": ((632.8162, 1.0),),
    "krypton": (
        (427.397, 1000.0), (431.958, 1000.0), (446.369, 800.0), (450.235, 600.0), (556.222, 500.0), (557.029, 2000.0),
        (587.092, 3000.0), (605.613, 60.0), (642.103, 100.0), (645.629, 200.0), (760.154, 2000.0), (769.454, 1200.0),
    ),
}  # fmt: skip
# Lines by names of their own, in air [nm]. "mercury-yellow" is the middle of two lines.
LINES: dict[str, float] = {
    "sodium-d1": 589.5924,
    "sodium-d2": 588.9950,
    "mercury-violet": 404.656,
    "mercury-blue": 435.833,
    "mercury-green": 546.075,
    "mercury-yellow": 578.013,
    "cadmium-red": 643.847,
    "hydrogen-red": 656.28,
    "hydrogen-blue": 486.13,
    "helium-yellow": 587.562,
}
# Kinds of light that are no lines.
BANDS = ("white", "led")


def index_of_air(wavelength_nm: float) -> float:
    """Of standard air (15 C, 101 325 Pa, dry) at a vacuum wavelength of 230 nm to 1.69 um.

    E. R. Peck and K. Reeder, J. Opt. Soc. Am. 62, 958 (1972), equation 3.
    """
    square = (1e3 / wavelength_nm) ** 2
    return 1 + (8060.51 + 2480990.0 / (132.274 - square) + 17455.7 / (39.32957 - square)) * 1e-8


def in_vacuum(air_nm: float) -> float:
    """The vacuum wavelength of a wavelength in standard air [nm]."""
    return air_nm * index_of_air(air_nm * 1.00028)  # the index changes by 1e-9 over what this guess is off


def nearest_names(name: str) -> str:
    """Names of lamps and lines like a name that is none, or all of lamps, for a message."""
    names = [*LAMPS, *BANDS, *LINES]
    return ", ".join(difflib.get_close_matches(name, names, 3, 0.6) or [*LAMPS, *BANDS])
