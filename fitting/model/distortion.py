"""The parts of a camera's distortion: of the third order, and of the fifth beside it (Brown 1966)."""

from collections.abc import Collection
from types import MappingProxyType

from fitting.model.part import AbstractPart, Law
from fitting.parameters import Numbers

_ADVICE = "keep the rings in the middle of a longer focal length"
# A microscope on the gap of a steep sphere sees 2 t only to some 3.3 (r/R)², which a distortion imitates; twice that,
# since the share depends on the glass above.
_STEEP, _STEEP_VIEW = 6.6, "view of a steep sphere"
# The two usual laws of distortion, from the image to the object and back, differ by 3 κ² in the fifth order: taken as
# one and a half standard deviations where the image does not tell.
_FIFTH, _LAW = 2.0, "distortion's law"


class Distortion(AbstractPart):
    """The object's point is u (1 + κ |u|²) of the pixel's u; the pixel size is that of the middle."""

    name = "distortion"
    parameters = ("distortion",)
    is_warp = True
    radial_power = 1
    advice = MappingProxyType({"distortion": _ADVICE, _LAW: _ADVICE, _STEEP_VIEW: "give the bench as a scene"})

    def imitates(self, numbers: Numbers, steepness: float, rim: float) -> tuple[str, str] | None:
        """What the gap formula itself leaves out for a steep sphere, where the distortion is no larger than that."""
        if 2 * abs(numbers.distortion) * rim < _STEEP * steepness:
            return _STEEP_VIEW, "so steep a sphere bends the view of the gap as much; a scene tells them apart"
        return None

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
    advice = MappingProxyType({"fifth_order": _ADVICE})
