"""Another way to the same image: coherent Gaussian beamlets (Harvey, Irvin and Pfisterer 2015), for comparison.

The light is a grid of Gaussian beams of waist w on the launch plane, spaced so closely that their sum is flat. Each is
carried through the bench as a base ray and its differential rays, complex ray tracing to first order (Greynolds 1986):
with the ray matrices A, B, C, D of position and direction, a Gaussian of complex curvature Q becomes one of
(C + D Q) / (A + B Q) and of amplitude 1 / sqrt(det(A + B Q)). On the screen the beams' fields are summed. Unlike rays,
beamlets diffract; unlike `Traced` they cost a sum over some hundred neighbours at every pixel. The base rays and their
Fresnel coefficients are the simulator's own; what is checked is the aim, the tube's area, and the way to the screen.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

import newtonjax as nj
from newtonjax.methods.traced import at_every_pixel
from newtonjax.rays import carry_field, gather, trace

OVERLAP = 1.5  # waist over spacing: the sum then is flat to 2 exp(-(π w / d)²) = 5e-10
REACH = 6  # neighbours on each side that count: the next is weaker by exp(-(6.5 / 1.5)²) = 7e-9


class Beamlets(NamedTuple):
    """The beams of one word on the screen: base rays' points, optical paths and directions, complex curvatures."""

    point: Float[Array, "v u 2"]
    path: Float[Array, "v u"]
    slope: Float[Array, "v u 2"]
    curvature: Complex[Array, "v u 2 2"]
    field: Complex[Array, "v u 3 components"]


def launch(scene: nj.Scene, nodes: Float[Array, "v u 2"], spacing: float) -> list[Beamlets]:
    """The beamlets of every word, carried to the screen."""
    routes, setting = gather(scene)
    origin, across_x, across_y, direction = setting.launch
    waist = 1j * scene.wavelength / (jnp.pi * (OVERLAP * spacing) ** 2) * jnp.eye(2)

    def landed(route, u, p):
        """Point and direction on the screen of the ray from u with the transverse direction p."""
        turned = direction + (p[0] * across_x + p[1] * across_y) / scene.media[0]
        turned = turned / jnp.linalg.norm(turned)
        landing, legs = trace(route, setting._replace(launch=(origin, across_x, across_y, turned)), u)
        return (landing.point, setting.exit_index * (setting.across() @ landing.direction)), (landing, legs)

    def one(route, u):
        (by_u, by_p), (landing, legs) = jax.jacfwd(
            lambda q: landed(route, u + q[:2], q[2:]), has_aux=True
        )(jnp.zeros(4))  # fmt: skip
        (a, b), (c, d) = (by_u[:, :2], by_u[:, 2:]), (by_p[:, :2], by_p[:, 2:])
        spread = a + b @ waist
        curvature = (c + d @ waist) @ jnp.linalg.inv(spread)
        slope = setting.exit_index * (setting.across() @ landing.direction)
        scale = jnp.sqrt(jnp.linalg.det(spread)) * jnp.pi * OVERLAP**2
        return Beamlets(landing.point, landing.path, slope, curvature, carry_field(route, setting, legs) / scale)

    each = jax.vmap(jax.vmap(one, (None, 0)), (None, 0))
    return [each(jax.tree.map(lambda leaf, k=k: leaf[k], routes), nodes) for k in range(len(scene.beams))]


def field_at(beam: Beamlets, wavelength, point: Float[Array, "2"]) -> Complex[Array, "3 components"]:
    """The sum of the beamlets around a point, but for the phase of the middle one's path."""
    rows, columns = beam.path.shape
    first, last = beam.point[0, 0], beam.point[-1, -1]
    at = (point - first) / (last - first) * jnp.array([columns - 1.0, rows - 1.0])
    column, row = jnp.clip(jnp.round(at).astype(int), REACH, jnp.array([columns, rows]) - 1 - REACH)
    window = jax.tree.map(
        lambda leaf: jax.lax.dynamic_slice(
            leaf, (row - REACH, column - REACH, *[0] * (leaf.ndim - 2)), (2 * REACH + 1, 2 * REACH + 1, *leaf.shape[2:])
        ),
        beam,
    )
    away = point - window.point
    bend = jnp.einsum("vui,vuij,vuj->vu", away.astype(complex), window.curvature, away.astype(complex)) / 2
    path = window.path + jnp.einsum("vui,vui->vu", window.slope, away) + bend
    return jnp.einsum("vu,vuac->ac", jnp.exp(2j * jnp.pi / wavelength * path), window.field)


def beamlet_image(scene: nj.Scene, camera: nj.Camera, spacing: float, chunk: int = 2048):
    """A function of the scene that makes the image, and how many base rays it traces.

    For benches whose rays land near where they start, as those of weak lenses do.
    """
    half = np.array(camera.shape[::-1]) / 2 * float(camera.pixel_size) * 1.05 + (REACH + 2) * spacing
    count_x, count_y = (2 * np.ceil(half / spacing) + 1).astype(int)
    x = (np.arange(count_x) - count_x // 2) * spacing
    y = (np.arange(count_y) - count_y // 2) * spacing
    nodes = np.stack(np.meshgrid(x, y), axis=-1)

    @jax.jit
    def image(scene, nodes):
        beams = launch(scene, nodes, spacing)

        def intensity(points):
            fields = jax.vmap(lambda point: sum(field_at(beam, scene.wavelength, point) for beam in beams))(points)
            return jnp.sum(jnp.abs(fields) ** 2, axis=(1, 2)) / fields.shape[2]

        return at_every_pixel(intensity, camera, chunk)

    return lambda: image(scene, nodes), 5 * nodes[..., 0].size * len(scene.beams)
