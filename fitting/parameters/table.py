"""The table of named parameters: what fits, studies, chains, reports and files call a number, and what may be meant."""

from dataclasses import dataclass

from newtonjax.scene import INDEX, PIXEL_SIZE, RADIUS, WAVELENGTH

_ANY = (float("-inf"), float("inf"))


@dataclass(frozen=True)
class ParameterSpec:
    """A named parameter.

    - `symbol`: in formulae; `unit`: of its values, empty where they have none.
    - `bounds`: what can be meant [`unit`]; outside of them a unit was mistaken.
    - `sensible`: what lenses, lamps and gaps have [`unit`]; beyond, a unit or a given number may have been mistaken.
    - `positive`: whether only its ratios mean something.
    - `advice`: what makes its row of a budget smaller; empty where nothing can be said.
    - `in_fit`: whether it is a number of a part of the rings' model, and so stands in the vector of a fit.
    """

    name: str
    symbol: str
    unit: str = ""
    bounds: tuple[float, float] = _ANY
    positive: bool = False
    advice: str = ""
    in_fit: bool = False
    sensible: tuple[float, float] = _ANY

    @property
    def in_unit(self) -> str:
        """What follows its values in a text: a blank and the unit, or nothing."""
        return f" {self.unit}" if self.unit else ""

    def key(self, suffix: str = "") -> str:
        """Its key in JSON, the unit at its end: "radius_sd_m" of the suffix "sd"."""
        return "_".join(f"{self.name} {suffix}{self.in_unit}".split())

    @property
    def sd_key(self) -> str:
        """The key of a standard deviation in JSON: "sd_m"; "sd" where there is no unit."""
        return "_".join(f"sd{self.in_unit}".split())


_SPECS = (
    ParameterSpec("radius", "R", "m", RADIUS[:2], True, "a lens of better known radius", sensible=(1e-3, 1e3)),
    ParameterSpec(
        "wavelength", "λ", "m", WAVELENGTH[:2], True,
        "a spectral line instead of a lamp's band, or its catalogued value", sensible=(100e-9, 20e-6),
    ),
    ParameterSpec(
        "pixel_size", "s", "m", PIXEL_SIZE[:2], True,
        "a reticle with finer or better known divisions, over more of the field (newtonjax scale)",
    ),
    ParameterSpec("gap_index", "n", "", INDEX[:2], True, "a measured index of what fills the gap", sensible=(0.9, 2.5)),
    ParameterSpec("lens_index", "n", "", INDEX[:2], True),
    ParameterSpec("plate_index", "n", "", INDEX[:2], True),
    ParameterSpec("conic", "k"),
    ParameterSpec("asphere", "A₄", "per_m3"),
    ParameterSpec("plate_radius", "R", "m", RADIUS[:2], False, "a plate of better known radius, or a flat one"),
    ParameterSpec("gap", "t", "m"),
    ParameterSpec("view_angle", "θ", "rad"),
    ParameterSpec("centre_x", "x", "px"),
    ParameterSpec("centre_y", "y", "px"),
    # Of a bench and its image alone.
    ParameterSpec("screen", "z", "m"),
    ParameterSpec("exposure", "N", "photoelectrons", positive=True),
    ParameterSpec("stray", "b"),
    ParameterSpec("contrast", "C", positive=True),
    ParameterSpec("wedge_angle", "α", "rad", positive=True),
    ParameterSpec("light_tilt_x", "α", "rad"),
    ParameterSpec("light_tilt_y", "β", "rad"),
    ParameterSpec("plate_tilt_x", "α", "rad"),
    ParameterSpec("plate_tilt_y", "β", "rad"),
    # Of light beyond one line and parallel beams, and of pixels beyond points.
    ParameterSpec("gaussian_width", "Δλ", "m"),
    ParameterSpec("lorentzian_width", "Δλ", "m", (0.0, float("inf"))),
    ParameterSpec("line_splitting", "δλ", "m"),
    ParameterSpec("source_size", "sin α"),
    ParameterSpec("light_curvature", "c", "per_m"),
    ParameterSpec("blur", "b", "px"),
    ParameterSpec("aperture", "a", "px"),
    # Of a lens with two radii.
    ParameterSpec("radius_along", "R₁", "m", RADIUS[:2], True),
    ParameterSpec("radius_across", "R₂", "m", RADIUS[:2], True),
    ParameterSpec("astigmatism_axis", "α", "rad"),
    ParameterSpec("fringe_scale", "n s²/(R λ)", "per_px2", (0.0, float("inf"))),
    ParameterSpec("finesse", "N", positive=True),
    ParameterSpec("contact_radius", "a", "m", (0.0, float("inf"))),
    # Of the parts of a fit, in the order of its vector. Bounds: cos θ = 0.67 of a view, 15 % at the rim of the field of
    # a distortion (eyepieces reach 10 %), a disc of half the half diagonal.
    ParameterSpec("stretch", "a", bounds=(-0.4, 0.4), in_fit=True),
    ParameterSpec("shear", "b", bounds=(-0.4, 0.4), in_fit=True),
    ParameterSpec("distortion", "κ", bounds=(-0.15, 0.15), in_fit=True),
    ParameterSpec("contact", "a²", bounds=(0.0, 0.3), in_fit=True),
    ParameterSpec("distortion_fifth_order", "κ₅", bounds=(-0.05, 0.05), in_fit=True),
    # Of the distortion, from the image's middle, in half diagonals.
    ParameterSpec("axis_x", "x", bounds=(-1.0, 1.0), in_fit=True),
    ParameterSpec("axis_y", "y", bounds=(-1.0, 1.0), in_fit=True),
    # Turns at the rim of the field, which for rings off the middle is up to 1.6 half diagonals from their centre.
    *(
        ParameterSpec(f"{term}_{along}", "c", bounds=(-5.0, 5.0), in_fit=True)
        for term in ("coma", "trefoil", "astigmatism", "tetrafoil")
        for along in "xy"
    ),
)  # fmt: skip
TABLE = {spec.name: spec for spec in _SPECS}
# Of every number in a result; the last ones are of pictures, the scale also without a pixel size.
UNITS = {spec.name: spec.unit for spec in _SPECS} | {
    "centre_x_px": "px",
    "centre_y_px": "px",
    "contact_radius_px": "px",
    "fringe_scale_per_px2": "per px²",
}

# Parts of the rings' model, and what the shell says of their options: here, and not in the parts, since help comes
# without NumPy.
PART_OPTIONS = {
    "oblique_view": "A camera that looks at a slant.",
    "distortion": "A camera whose lens distorts.",
    "fifth_order": "The fifth order of that distortion.",
    "lens_form": "A lens whose form is no sphere's.",
    "contact": "A lens pressed flat on the plate.",
    "film": "A film between the pressed faces.",
}
