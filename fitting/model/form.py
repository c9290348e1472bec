"""The part of a lens, or a view of it, that is no sphere: what is left of low order about the rings' centre."""

from types import MappingProxyType

from fitting.model.part import AbstractPart

# By number: coefficients of monomials x^i y^j, by (i, j).
_TERMS = {
    "coma_x": {(3, 0): 1, (1, 2): 1},
    "coma_y": {(2, 1): 1, (0, 3): 1},
    "trefoil_x": {(3, 0): 1, (1, 2): -3},
    "trefoil_y": {(2, 1): 3, (0, 3): -1},
    "astigmatism_x": {(4, 0): 1, (0, 4): -1},
    "astigmatism_y": {(3, 1): 2, (1, 3): 2},
    "tetrafoil_x": {(4, 0): 1, (2, 2): -6, (0, 4): 1},
    "tetrafoil_y": {(3, 1): 4, (1, 3): -4},
}
# Of each term, at the rim [turns]: a fiftieth of a wavelength of path.
_SPREAD = 0.02


class LensForm(AbstractPart):
    """Coma, trefoil, astigmatism of the fourth order and tetrafoil, as turns of the phase at the rim of the field.

    With the offset z = x + iy from the rings' centre, over the field's reach from there: |z|² z, z³, |z|² z² and z⁴, of
    each the real and the imaginary part (the monomials that lead Zernike's: Born and Wolf 1999, 9.2). Lower orders are
    the sphere, its centre and an oblique view.
    """

    name = "lens_form"
    parameters = tuple(_TERMS)
    is_warp = True
    polynomials = MappingProxyType(_TERMS)
    priors = MappingProxyType(dict.fromkeys(_TERMS, (0.0, _SPREAD)))
    prior_words = "0.02 of a fringe for each term at the rim"
    advice = MappingProxyType({"lens_form": "turn the lens and take a second picture: what turns with it is its form"})
