"""The arguments of the ready benches, declared once: TOML tables, the shell's options and help, and checks are made of
this table. No JAX here: the shell's `--help` reads it.
"""

from collections.abc import Iterable
from typing import Any, Literal, NamedTuple

from newtonjax.scene import HEIGHT, INDEX, RADIUS, THICKNESS, TILT, WAVELENGTH

Kind = Literal[
    "length", "wavelength", "light", "screen", "angle", "angles", "index", "fraction", "view", "names", "number",
    "terms", "heights", "coating",
]  # fmt: skip
Test = Literal[
    "finite", "radius", "wavelength", "index", "height", "thickness", "tilt", "tilts", "angles", "view", "screen",
    "names", "fraction", "light", "terms", "coating",
    "radius_of_source", "aperture", "lamp",
]  # fmt: skip


class Argument(NamedTuple):
    """One argument of one or more benches.

    - `name`: in Python, in TOML, and with dashes in the shell.
    - `kind`: what it measures, and so its unit: metres for lengths, radians for angles, none for the others.
    - `default`: in SI units; None for what a bench does without.
    - `shown`: the default as a reader sees it.
    - `help`: one sentence, for the shell and for docs/scene.toml.
    - `allowed`: what a value may be, for messages; `test`: the check of it.
    - `benches`: that have it.
    """

    name: str
    kind: Kind
    default: Any
    shown: str
    help: str
    allowed: str
    test: Test
    benches: tuple[str, ...] = ("newton_rings", "air_wedge")


_RINGS, _WEDGE = ("newton_rings",), ("air_wedge",)
_ANGLES = "two finite angles in radians, about x and about y"
_TILTS = f"two angles about x and about y, {TILT.words}"
_INDEX = f"a positive refractive index, {INDEX.words}, or a name such as 'N-BK7'"
_SCREEN = "a distance in metres, or 'gap'"
_THICKNESS = f"a positive thickness, {THICKNESS.words}"
_LIGHT = "words such as 'sodium', 'mercury:546nm/10nm', 'white:5500K' or 'lamp.csv', or a Spectrum"
_COATING = "words such as '1.38:107nm, 0.05+3.1i:20nm' or 'mirror:90%', or a Coating"
_LIGHT_HELP = "Lamp, filtered lamp, line of a width, white light or file of a spectrum, instead of a wavelength."
_RADIUS = f"a non-zero radius, {RADIUS.words}; infinite for a plane"
_POWERS = "1 to 8 finite coefficients [m^(1 - power)], or None"
_SCREEN_HELP = "Distance of the screen behind the glass, or gap: a microscope focused on the gap."

# In the order of the Python signatures.
ARGUMENTS = (
    Argument("radius", "length", 1.0, "1m", "Radius of the lens's convex face, negative for a concave one.",
             _RADIUS, "radius", _RINGS),
    Argument("wedge_angle", "angle", 1e-4, "0.1mrad", "Angle of the wedge.",
             f"an angle {TILT.words}", "tilt", _WEDGE),
    Argument("wavelength", "wavelength", 589.3e-9, "589.3nm", "Vacuum wavelength.",
             f"a positive length, {WAVELENGTH.words}", "wavelength"),
    Argument("gap", "length", 0.0, "0nm", "Gap at the apex, or on the wedge's axis; 0 is contact.",
             f"a finite height, {HEIGHT.words}", "height"),
    Argument("view", "view", "reflected", "reflected", "The side that the light is seen on: transmitted or reflected.",
             "'transmitted' or 'reflected'", "view"),
    Argument("light", "light", None, "none", _LIGHT_HELP, _LIGHT, "light"),
    Argument("screen", "screen", "gap", "gap", _SCREEN_HELP, _SCREEN, "screen"),
    Argument("lens_index", "index", 1.5, "1.5", "Refractive index of the lens, or of the upper plate of a wedge.",
             _INDEX, "index"),
    Argument("plate_index", "index", 1.5, "1.5", "Refractive index of the plate, the lower one of a wedge.",
             _INDEX, "index"),
    Argument("gap_index", "index", 1.0, "1", "Refractive index of what fills the gap.", _INDEX, "index"),
    Argument("ambient_index", "index", 1.0, "1", "Refractive index of the surroundings.", _INDEX, "index"),
    Argument("lens_thickness", "length", 5e-3, "5mm", "Thickness of the lens on its axis, or of the upper plate.",
             _THICKNESS, "thickness"),
    Argument("plate_thickness", "length", 5e-3, "5mm", "Thickness of the plate.", _THICKNESS, "thickness"),
    Argument("lens_tilt", "angles", (0.0, 0.0), "none", "Rotations of the lens about its apex, about x and y.",
             _TILTS, "tilts", _RINGS),
    Argument("plate_tilt", "angles", (0.0, 0.0), "none", "Rotations of the plate about the origin, about x and y.",
             _TILTS, "tilts"),
    Argument("light_tilt", "angles", (0.0, 0.0), "none", "Rotations of the light's direction about x and y.",
             _ANGLES, "angles"),
    Argument("angular_radius", "angle", None, "none", "Angular radius of a round source; none is parallel light.",
             f"0 or more, {TILT.words}, or None", "radius_of_source"),
    Argument("numerical_aperture", "number", None, "none",
             "Numerical aperture of a microscope that lights the gap and sees it.",
             "a number from 0 to below 2, or None", "aperture"),
    Argument("source_distance", "length", None, "none",
             "Distance of the lamp from the glass, or from a collimator on it; none is parallel light.",
             f"a positive distance, {THICKNESS.words}, or None", "thickness"),
    Argument("lamp_radius", "length", None, "none", "Radius of a round lamp at that distance.",
             f"0 or a positive radius, {THICKNESS.words}, or None", "lamp"),
    Argument("collimator", "length", None, "none",
             "Focal length of a lens between lamp and glass; the lamp is in its focus if no distance is given.",
             f"a positive focal length, {THICKNESS.words}, or None", "thickness"),
    Argument("polarization", "angle", None, "unpolarized", "Linear polarization from x towards y.",
             "a finite angle in radians, or None for unpolarized light", "finite"),
    Argument("polarization_degree", "fraction", None, "1 with a polarization", "Degree of polarization.",
             "a number from 0 to 1, or None", "fraction"),
    Argument("beams", "names", None, "the gap's two",
             "Beams that meet, by their reflections at the faces (numbered from 0 on, as light meets them), or all.",
             "a sequence of names or words, such as ('R1', 'R2'), or 'all' for all orders in the gap", "names"),
    Argument("lens_coating", "coating", None, "none",
             "Layers on the lens's face of the gap, from the glass, or a mirror; all orders in the gap count then.",
             _COATING, "coating"),
    Argument("plate_coating", "coating", None, "none", "Layers on the plate's face of the gap, or a mirror.",
             _COATING, "coating"),
    Argument("shield", "length", None, "none", "Radius of a round hole in a shield where the light leaves.",
             f"a positive radius, {THICKNESS.words}, or None", "thickness"),
    Argument("collecting_lens", "length", None, "none",
             "Focal length of a lens that images the gap on a screen at least four times as far away.",
             f"a positive focal length, {THICKNESS.words}, or None", "thickness"),
    Argument("conic", "number", None, "none", "Conic constant of the lens's convex face: 0 a sphere, -1 a paraboloid.",
             "a finite number, or None", "finite", _RINGS),
    Argument("asphere", "terms", None, "none",
             "Terms of the lens's convex face in r⁴, r⁶, ..., in metres over metres⁴, ...",
             _POWERS, "terms", _RINGS),
    Argument("odd_asphere", "terms", None, "none", "Its terms in r³, r⁵, ..., in metres over metres³, ...",
             _POWERS, "terms", _RINGS),
    Argument("radius_across", "length", None, "none",
             "Its other radius where it is a toroid; infinite for a cylinder, whose radius is the first.",
             f"{_RADIUS}; or None", "radius", _RINGS),
    Argument("axis", "angle", None, "none", "Direction along which a toroid has the first radius, from x towards y.",
             "a finite angle in radians, or None", "finite", _RINGS),
    Argument("zernike", "heights", None, "none",
             "Zernike terms of its figure in Noll's order, piston first, rms heights.",
             "finite heights in metres, piston first, or None", "terms", _RINGS),
    Argument("zernike_radius", "length", None, "none",
             "Radius of the disc on which they are counted, where the lens ends.",
             f"a positive radius, {THICKNESS.words}, or None", "thickness", _RINGS),
    Argument("plate_radius", "length", None, "none", "Radius of the plate's upper face, negative for a concave one.",
             f"{_RADIUS}; or None", "radius", _RINGS),
)  # fmt: skip
BENCHES = ("newton_rings", "air_wedge")
# What arguments were called before, and what they are now.
_RENAMED = {
    "newton_rings": {"index": "lens_index"},
    "air_wedge": {
        "index": "lens_index and plate_index, of the upper and of the lower plate",
        "angle": "wedge_angle",
        "thickness": "lens_thickness and plate_thickness, of the upper and of the lower plate",
    },
}


def arguments_of(bench: str) -> tuple[Argument, ...]:
    """The arguments of a bench, in the order of its signature."""
    return tuple(argument for argument in ARGUMENTS if bench in argument.benches)


def refuse_old_names(bench: str, names: Iterable[str]) -> None:
    """Raise ValueError for a name that an argument had before, with its present one."""
    for name in names:
        if name in _RENAMED[bench]:
            raise ValueError(f"{name} of {bench} is called {_RENAMED[bench][name]} now")
