"""The parts of a camera's distortion: of the third order, and of the fifth beside it (Brown 1966)."""

from fitting.model.part import AbstractPart


class Distortion(AbstractPart):
    """The object's point is u (1 + κ |u|²) of the pixel's u; the pixel size is that of the middle."""

    name = "distortion"
    parameters = ("distortion",)
    is_warp = True
    radial_power = 1


class FifthOrder(AbstractPart):
    """The object's point is u (1 + κ |u|² + κ₅ |u|⁴)."""

    name = "fifth_order"
    parameters = ("distortion_fifth_order",)
    needs = ("distortion",)
    is_warp = True
    radial_power = 2
