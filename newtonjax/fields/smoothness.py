"""Fields on nodes as Chebyshev coefficients, and the error of keeping fewer of them."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from newtonjax.fields.at_points import Fields, polar
from newtonjax.numerics import chebyshev, module_of


class ErrorEstimate(NamedTuple):
    """Bounds of a method's error: phase [turns], and intensity over the peak.

    The peak is the largest background plus the fringes' amplitude: an image that shows a dark fringe only stays below.
    """

    phase: Float[Any, ""] | float
    intensity: Float[Any, ""] | float


class Smooth(NamedTuple):
    """Fields on nodes, ready to be cut to fewer: NumPy where the fields are.

    - `coefficients`: of background, moduli and phases [turns], [1 + 2 pairs, nodes in y, nodes in x].
    - `shells`: sums of their absolute values by the larger degree, [1 + 2 pairs, nodes].
    - `sizes`: largest modulus of each pair; `peak`: of the intensity.
    - `rounding`: largest, of the phases [turns].
    - `reached`: whether every beam reaches every node.
    """

    coefficients: Float[Any, "fields nodes nodes"]
    shells: Float[Any, "fields nodes"]
    sizes: Float[Any, " pairs"]
    peak: Float[Any, ""]
    rounding: Float[Any, ""]
    reached: Bool[Any, ""]


def smooth(fields: Fields) -> Smooth:
    """The coefficients of fields on a square grid of nodes, row by row, and what an error estimate takes of them."""
    modulus, phase = polar(fields)
    xp = module_of(phase)
    coefficients = chebyshev.coefficients(xp.concatenate([fields.background[None], modulus, phase]))
    sizes = abs(modulus).max(axis=-1)
    return Smooth(
        coefficients,
        chebyshev.shells(coefficients),
        sizes,
        fields.background.max() + sizes.sum(),
        fields.rounding.max(),
        fields.arrives.all(),
    )


def error_of(nodes: Smooth, count: int) -> ErrorEstimate:
    """Error bounds of keeping `count` degrees to a side of fields known on at least as many nodes.

    Left out are the shells of coefficients beyond the cut as far as the nodes tell them, and beyond these what their
    last two shells would grow to if they went on at the rate at which shells decay there; folding back on fewer nodes
    doubles it (Trefethen 2013, Approximation Theory and Approximation Practice, theorem 8.2). Two shells, since one of
    them vanishes in a symmetric field; and the slower of their rate and that over twice as many, since the last ones
    hold what the nodes do not tell from them.
    """
    xp = module_of(nodes.shells)
    shell = nodes.shells
    # With hardly more nodes than are kept their last shells lie at the cut itself.
    end = shell.shape[-1] if shell.shape[-1] >= count + 4 else count
    edge = shell[:, end - 2] + shell[:, end - 1]
    before, long = (shell[:, max(end - k, 0)] + shell[:, max(end - k + 1, 1)] for k in (4, 8))
    rates = (edge / xp.where(before > 0, before, 1.0), (edge / xp.where(long > 0, long, 1.0)) ** (1 / 3))
    rate = xp.minimum(xp.maximum(*rates), 0.9)
    further = edge * xp.maximum(rate / (1 - rate), 1.0 if end < count + 4 else 0.1)
    beyond = shell[:, count:].sum(axis=-1)
    left_out = 2 * (beyond + further if end > count else xp.maximum(further, beyond))
    pairs = len(nodes.sizes)
    phase_error = left_out[1 + pairs :] + nodes.rounding
    error = left_out[: 1 + pairs].sum() + 2 * np.pi * (nodes.sizes * phase_error).sum()
    return ErrorEstimate(
        xp.where(nodes.reached, phase_error.max(initial=0.0), np.inf),
        xp.where(nodes.reached, error / xp.where(nodes.peak > 0, nodes.peak, 1.0), np.inf),
    )


def error_from_nodes(fields: Fields, count: int) -> ErrorEstimate:
    """`error_of` fields on nodes."""
    return error_of(smooth(fields), count)
