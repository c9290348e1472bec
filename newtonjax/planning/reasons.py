"""Why a plan takes its method, and what it warns of: the sentences of `Plan.reason` and `Plan.warnings`."""

from newtonjax.numerics import Wording


class PlanReason(Wording):
    """Sentences by name, which is the `code` of a plan's reason, and stays."""

    ALL_ORDERS = "all orders in the gap have a closed form alone"
    BEAM_MISSES_IMAGE = "not every beam reaches the whole image"
    CAUSTIC = (
        "not every beam reaches the whole image, and a caustic lies in it: where several rays of one beam reach a "
        "pixel, only one is traced"
    )
    FACES_CROSS = (
        "the faces of the gap pass through each other, by {depth_um} um at ({x_mm}, {y_mm}) mm: a real lens touches "
        "first; allowed: a gap larger by that (drawn are the fringes of the heights as they are)"
    )
    FOCUSED_ON_GAP = "the screen is focused on the gap"
    NODES_RESOLVE = "the fields are smooth: {count} x {count} nodes resolve them"
    NO_GRID_FINE_ENOUGH = "no grid of nodes is fine enough for the fields"
    SURFACE_ENDS = (
        "surfaces[{surface}] ends {end_mm} mm from its vertex, where {what}, and the image reaches {reach_mm} mm: "
        "nothing of it is seen beyond; allowed: a smaller image, or a surface that reaches as far"
    )
    SUM_OVER_SOURCE = "images of the directions of the source differ by more than their path in the gap"
    RAYS_ARE_CHEAPER = "rays at every pixel cost less than a grid of nodes that is fine enough"
