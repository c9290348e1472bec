"""The rival of a lens with two radii: elliptic rings are those of a view at an angle, or of an astigmatic lens."""

import numpy as np

from fitting.parameters import Numbers
from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding
from fitting.reasons import Reason

# The row of the budget.
VIEW_OR_FORM = "view or form"
# Stretches below this change nothing: 1 - 1/cosh of it is a millionth of the radius.
LEAST = 1.5e-3
# A view at more than this angle [degrees] is taken for less likely than a lens with two radii.
_LIKELY = 16.5


class ViewOrForm(AbstractRival):
    """That a view's stretch m is the lens's own: one image does not tell.

    Principal radii then are R exp(-m) and R exp(m), with R their geometric mean, which the view does not change; the
    radius of the mean curvature is R / cosh m. The difference is a row.
    """

    name = VIEW_OR_FORM

    def finding(self, remainder: Remainder) -> Finding | None:
        """By how much the geometric mean exceeds the radius of the mean curvature."""
        numbers = Numbers(*remainder.fit.numbers)
        stretch = float(np.hypot(numbers.stretch, numbers.shear))
        if stretch < LEAST:
            return None
        angle = float(np.degrees(np.arccos(np.exp(-stretch))))
        deviation = 1 - 1 / float(np.cosh(stretch))
        words = Reason.RIVAL_VIEW_OR_FORM(
            stretch=np.expm1(2 * stretch), angle=angle, apart=2 * np.sinh(stretch), share=deviation
        )
        return Finding(self.name, angle, _LIKELY, "warning" if angle > _LIKELY else "budget", words, deviation)
