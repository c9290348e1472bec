"""Fresnel's equations for the complex field vector, without a plane of incidence.

The s and p parts are separated by projectors. Written with the usual unit vector along d x n they are undefined
at normal incidence; multiplied out, every division by the sine of incidence cancels (derived from Born and Wolf,
Principles of Optics, section 1.5.2), so that values and gradients are finite at any incidence.
"""

from typing import Any

from jaxtyping import Array, Bool, Complex

from newtonjax.numerics import as_complex, functions
from newtonjax.scene import Vectors, dot

# Of one ray, or of many along the last axes.
Field = Complex[Any, "3 polarizations ..."]


def amplitudes(n1, n2, cos_i, cos_t):
    """Amplitude coefficients r_s, r_p, t_s, t_p (Born and Wolf 1.5.2, eqs. 20a and 21a).

    Cosines of incidence and refraction, never angles. Beyond the critical angle `cos_t` is imaginary. At normal
    incidence r_p = -r_s: both describe the same reflected field.
    """
    d_s = n1 * cos_i + n2 * cos_t
    d_p = n2 * cos_i + n1 * cos_t
    r_s = (n1 * cos_i - n2 * cos_t) / d_s
    r_p = (n2 * cos_i - n1 * cos_t) / d_p
    return r_s, r_p, 2 * n1 * cos_i / d_s, 2 * n1 * cos_i / d_p


def refract(n1, n2, direction: Vectors, normal: Vectors):
    """Snell's law: refracted direction, cosines of incidence and refraction, and whether light passes at all.

    `normal` points against the light. Beyond the critical angle the cosine of refraction is 1 and the flag False.
    """
    eta = n1 / n2
    cos_i = -dot(direction, normal)
    tangent = direction + cos_i * normal
    cos2_t = 1 - eta * eta * dot(tangent, tangent)
    passes = cos2_t > 0
    xp = functions(cos2_t)
    cos_t = xp.sqrt(xp.where(passes, cos2_t, 1.0))
    return eta * tangent - cos_t * normal, cos_i, cos_t, passes


def complex_cosine(n1, n2, direction, normal) -> Complex[Any, "..."]:
    """Cosine of refraction, +i sqrt(sin² - 1) beyond the critical angle (time factor e^{-iωt})."""
    tangent = direction - dot(direction, normal) * normal
    cos2_t = 1 - (n1 / n2) ** 2 * dot(tangent, tangent)
    passes = cos2_t > 0
    xp = functions(cos2_t)
    root = xp.sqrt(xp.where(cos2_t == 0, 1.0, abs(cos2_t)))
    return as_complex(xp.where(passes, root, 0.0)) + 1j * as_complex(xp.where(cos2_t < 0, root, 0.0))


def transmit_field(n1, n2, direction, normal, cos_i, cos_t, field: Field) -> Field:
    """The refracted field, scaled so that its square is the transmitted flux through the refracted tube.

    t_s E + [ (2 n1 n2 cos_i (1 - η²) / D) τ + (2 n1 cos_i² (n1² - n2²) / (n2 D)) n ] (n·E), with τ the tangential
    part of the direction, η = n1/n2 and D = (n1 cos_i + n2 cos_t)(n2 cos_i + n1 cos_t); times
    sqrt(n2 cos_t / (n1 cos_i)), the change of index and of the tube's cross-section.
    """
    d_s = n1 * cos_i + n2 * cos_t
    d_p = n2 * cos_i + n1 * cos_t
    tangent = direction + cos_i * normal
    along_tangent = 2 * n1 * n2 * cos_i * (1 - (n1 / n2) ** 2) / (d_s * d_p)
    along_normal = 2 * n1 * cos_i**2 * (n1**2 - n2**2) / (n2 * d_s * d_p)
    scale = functions(cos_t).sqrt(n2 * cos_t / (n1 * cos_i))
    straight, turned = 2 * n1 * cos_i / d_s, along_tangent * tangent + along_normal * normal
    return _apply(scale * straight, scale * turned, normal, field)


def reflect_field(n1, n2, direction, normal, cos_i, cos_t, field: Field) -> Field:
    """The reflected field, for a real or an imaginary cosine of refraction.

    r_s E + [ (r_p - r_s) n + (2 n1 n2 cos_i (1 - η²) / D) τ ] (n·E), symbols as in `transmit_field`.
    """
    tangent = direction + cos_i * normal
    # One dtype for all: the cosine of refraction may be imaginary.
    xp, ratio = functions(cos_t), n1 / n2
    n1, n2, ratio, cos_i, cos_t = (xp.asarray(value).astype(field.dtype) for value in (n1, n2, ratio, cos_i, cos_t))
    # The amplitudes of `amplitudes`; a complex division is much to compile, so there is none.
    d_s = n1 * cos_i + n2 * cos_t
    d_p = n2 * cos_i + n1 * cos_t
    over = d_s * d_p
    inverse = over.conj() * (1 / (over.real * over.real + over.imag * over.imag)).astype(field.dtype)
    r_s, r_p = (n1 * cos_i - n2 * cos_t) * d_p * inverse, (n2 * cos_i - n1 * cos_t) * d_s * inverse
    along_tangent = 2 * n1 * cos_i * (n2 - n1 * ratio) * inverse
    turned = along_tangent * tangent.astype(field.dtype) + (r_p - r_s) * normal.astype(field.dtype)
    return _apply(r_s, turned, normal, field)


def _apply(straight, turned, normal, field: Field) -> Field:
    """Straight E + turned (n·E)."""
    straight, turned, normal = (value.astype(field.dtype) for value in (straight, turned, normal))
    return straight * field + turned[:, None] * dot(normal, field)[None]


def is_total(n1, n2, direction, normal) -> Bool[Array, ""]:
    """True beyond the critical angle."""
    return ~refract(n1, n2, direction, normal)[3]
