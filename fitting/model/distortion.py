"""The parts of a camera's distortion: of the third order, and of the fifth beside it (Brown 1966)."""

from collections.abc import Collection
from types import MappingProxyType

from fitting.model.part import AbstractPart, Law
from fitting.parameters import Numbers

# Where the axis of a camera is, in half diagonals from its frame's middle.
_AXIS = 0.015
_ADVICE = "keep the rings in the middle of a longer focal length"
# The row of a budget that the axis has, and what makes it smaller.
AXIS_ROW = "axis"
_AXIS_ADVICE = "say where the camera's axis is in the picture (axis_px, --axis), or take the uncut photograph"
# The two usual laws of distortion, from the image to the object and back, differ by 3 κ² in the fifth order: taken as
# one and a half standard deviations where the image does not tell.
_FIFTH, _LAW = 2.0, "distortion's law"


class Distortion(AbstractPart):
    """The object's point is u (1 + κ |u|²) of the pixel's u, from the camera's axis; the pixel size is that there."""

    name = "distortion"
    parameters = ("distortion", "axis_x", "axis_y")
    axis = ("axis_x", "axis_y")
    is_warp = True
    radial_power = 1
    priors = MappingProxyType({"distortion": (0.0, 0.1), "axis_x": (0.0, _AXIS), "axis_y": (0.0, _AXIS)})
    prior_words = "a distortion of 10 % at half a diagonal, as eyepieces reach, its axis near the middle"
    # An eyepiece's and a telephone's; where the axis is, a fit that starts without a distortion does not see.
    also_from = ({"distortion": -0.12}, {"distortion": 0.06})
    advice = MappingProxyType({"distortion": _ADVICE, AXIS_ROW: _AXIS_ADVICE, _LAW: _ADVICE})

    def law(self, numbers: Numbers, present: Collection[str]) -> Law | None:
        """That the fifth order is not in the model, where the law of the camera may have one."""
        if FifthOrder.name in present:
            return None
        return Law(_LAW, "distortion_fifth_order", _FIFTH * float(numbers.distortion) ** 2)


class FifthOrder(AbstractPart):
    """The object's point is u (1 + κ |u|² + κ₅ |u|⁴)."""

    name = "fifth_order"
    parameters = ("distortion_fifth_order",)
    needs = ("distortion",)
    is_warp = True
    radial_power = 2
    # A wider one follows structure of other kinds, and buys it with the third order.
    priors = MappingProxyType({"distortion_fifth_order": (0.0, 0.01)})
    prior_words = "a fifth order of 1 % at half a diagonal"
    advice = MappingProxyType({"fifth_order": _ADVICE})
