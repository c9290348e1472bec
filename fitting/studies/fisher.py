"""Fisher's information of a scene's and a camera's parameters in an image of them.

For independent normal pixels of variance σ² and mean μ(θ) it is F = Σ (∂μ/∂θ) (∂μ/∂θ)ᵀ / σ², and no unbiased estimate
of a number scatters less than sqrt (F⁻¹)_kk (Cramér 1946, Rao 1945; Kay 1993, Fundamentals of Statistical Signal
Processing, section 3.7). It is summed through the nodes of the image, not over its pixels. The codes of a dim image
are not normal, and carry more: with read noise well below a code the bounds are up to 1 % too large where the
brightest pixel has 34 codes, 10 % at 3, and 60 % below one (tests/studies/test_information.py sums over the codes).
"""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from fitting.parameters import Deviation, Knob, chosen, free_names, knobs
from fitting.studies.bench_origin import says_its_bench
from fitting.studies.electrons import moved, tables, weights
from fitting.studies.image_slopes import image_slopes, needs_images
from fitting.studies.information_result import Information
from fitting.studies.pixel_sums import equations
from newtonjax.fields import error_from_nodes, jet_fields
from newtonjax.methods import Chebyshev, require_method, unreached
from newtonjax.numerics import jets, require_mapping
from newtonjax.scene import Camera, Scene

# Nodes to a side that are tried, at most.
_MOST_NODES = 129


@says_its_bench
def information(
    scene: Scene,
    camera: Camera,
    *,
    free: Sequence[str] | None = None,
    sd: Mapping[str, Deviation] | None = None,
    noise: float | None = None,
    method: Chebyshev | None = None,
) -> Information:
    """Fisher's information of an image in parameters of its scene and camera.

    The inverse of the matrix bounds the covariance of every unbiased estimate (Cramér 1946; Rao 1945).

    Args:
      scene, camera: where; one gap with two faces.
      free: which parameters are not known, by name; None for what `fit` determines of such a scene: radius, gap,
        centre, exposure and contrast, or the wedge angle, gap, exposure and contrast of plane faces.
      sd: standard deviations of some of them from elsewhere, in their units, or as "0.1%" of their values.
      noise: of every pixel, as a standard deviation in incident irradiance; None for the camera's own: shot noise at
        its exposure, read noise, and the rounding of its code, full_well / (2^bits - 1) / sqrt 12. Saturated pixels
        carry no information.
      method: the nodes; None for as many as keep 1e-8 of the intensity, and 17 at least.

    Raises ValueError for parameters that the scene does not have or that are named twice, and where beams miss a node.

    """
    require_method(method, Chebyshev)
    require_mapping("sd", sd)
    present = knobs(scene, camera)
    names = free_names(present, free)
    numbers = tuple(chosen(present, names).values())
    scales = np.array([number.scale for number in numbers])
    if needs_images(scene, camera):
        if method is not None:
            raise ValueError("method with a spectrum, a source of a size, all orders, blur or channels; allowed: None")
        matrix = _by_images(scene, camera, numbers, noise)
    else:
        nodes = fine_nodes(scene, camera).nodes if method is None else method.nodes
        table, changes = derivatives(scene, camera, numbers, nodes)
        matrix = equations(table, changes, camera.shape, lambda image, _: weights(image, camera, noise)).matrix
    result = Information(
        names,
        tuple(number.unit for number in numbers),
        np.array([number.value for number in numbers]),
        scales,
        matrix / np.outer(scales, scales),
        {},
        tuple(number.positive for number in numbers),
    )
    return result.with_sd(**(sd or {}))


def _by_images(scene: Scene, camera: Camera, numbers: Sequence[Knob], noise) -> Float[np.ndarray, "numbers numbers"]:
    """The matrix by steps in the numbers' scales, of images that are rendered."""
    image, slopes = image_slopes(scene, camera, numbers)
    flat = slopes.reshape(len(slopes), -1)
    return (flat * weights(image, camera, noise).ravel()) @ flat.T


def derivatives(
    scene: Scene, camera: Camera, numbers: Sequence[Knob], nodes: int
) -> tuple[Float[np.ndarray, "3 nodes nodes"], Float[np.ndarray, "numbers 3 nodes nodes"]]:
    """Coefficients of an image's fields (`studies.tables`), and their derivatives by steps in the numbers' scales.

    Raises ValueError where beams miss a node.
    """
    still = jets.variable(np.zeros(len(numbers)), np.eye(len(numbers)), 1, 2)
    moves = tuple((number.name, number.move) for number in numbers)
    bench = moved(scene, camera, moves, still, [number.scale for number in numbers])
    table, reached = tables([bench], nodes, 2)
    if not reached.all():
        raise unreached(Chebyshev(nodes))
    return table.value[0], table.parts[0, 1:, 0]


def fine_nodes(scene: Scene, camera: Camera, keeps: float = 1e-8, least: int = 17) -> Chebyshev:
    """As many nodes as keep a share of the intensity, and a number of them at least.

    Raises ValueError where beams miss the image, and where 129 to a side do not.
    """
    count = least
    while True:
        fields = jet_fields.values_of(jet_fields.at_nodes([(scene, camera)], count, 1))
        # But for the rounding of the phases [turns].
        exact = fields._replace(rounding=np.zeros_like(fields.rounding))
        error = float(error_from_nodes(exact, count).intensity)
        # What rounding leaves in every coefficient of the phases, more nodes do not mend.
        allowed = keeps + 400 * float(fields.rounding.max())
        if error <= allowed:
            return Chebyshev(count)
        if not np.isfinite(error):
            raise ValueError("a beam does not reach the whole image; this takes smooth fields: take a smaller field")
        if count == _MOST_NODES:
            raise ValueError(
                f"{count} nodes to a side leave {error:.2g} of the intensity; this takes {keeps:.0e}: "
                "take a smaller field"
            )
        count = min(2 * count - 1, _MOST_NODES)
