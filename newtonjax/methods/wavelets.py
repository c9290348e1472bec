"""The spherical wavelets of Debelov and Dolgov (2021): the path that they give a pair of rays, and by how much it errs.

A ray that lands beside the meeting point is taken there along a sphere about the last surface point it left. The true
wavefront has another curvature: the error is half the shift's square times the difference of the two (Fermat: the
first order is right).
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from newtonjax.rays import Landing, Route, Setting, trace
from newtonjax.scene import dot


class PairError(NamedTuple):
    """Second order of the error of a pair's path difference [m], and the pair's separation on the screen [m]."""

    error: Float[Array, ""]
    separation: Float[Array, ""]


def wavelet_opd(setting: Setting, first: Landing, second: Landing) -> Float[Array, ""]:
    """Optical path difference of two rays at the midpoint of their landing points [m], the second's minus the first's.

    Each path is taken to the midpoint along a spherical wavelet about the ray's last surface point (section 3).
    """
    meeting = (first.point + second.point) / 2
    return second.path + _longer(setting, second, meeting) - first.path - _longer(setting, first, meeting)


def _longer(setting: Setting, landing: Landing, meeting: Float[Array, "2"]) -> Float[Array, ""]:
    """By how much the optical path from the last surface to the meeting point exceeds that to the landing point [m]."""
    across = setting.across()
    shift = (meeting - landing.point) @ across
    segment = landing.length * landing.direction
    length = jnp.sqrt(dot(segment + shift, segment + shift))
    total = length + jnp.abs(landing.length)  # 0 on a screen that touches the last surface
    grown = (dot(shift, shift) + 2 * dot(segment, shift)) / jnp.where(total > 0, total, 1.0)
    # Backwards to a virtual screen; on a screen that touches the last surface rounding must not choose.
    return setting.exit_index * jnp.where(landing.length < -1e-12, -grown, grown)


def pair_error(first: Route, second: Route, setting: Setting, start: Float[Array, "2"]) -> PairError:
    """What the wavelets of two beams' rays from one launch point get wrong at the midpoint between them.

    To second order in the separation: good to some 5 % where that is below a hundredth of the way to the screen.
    """
    across = setting.across()

    def landed(route, start):
        landing, _ = trace(route, setting, start)
        return (landing.point, across @ landing.direction), landing

    def one_beam(route):
        # The path's gradient over the screen is the direction along it, and its second derivative the curvature.
        (d_point, d_slope), landing = jax.jacfwd(lambda s: landed(route, s), has_aux=True)(start)
        slope = across @ landing.direction
        sphere = (across @ across.T - jnp.outer(slope, slope)) / landing.length
        return landing.point, d_slope @ jnp.linalg.inv(d_point) - sphere

    (point_1, error_1), (point_2, error_2) = one_beam(first), one_beam(second)
    half = (point_2 - point_1) / 2
    error = jnp.abs(setting.exit_index * (half @ (error_2 - error_1) @ half) / 2)
    return PairError(error, 2 * jnp.linalg.norm(half))
