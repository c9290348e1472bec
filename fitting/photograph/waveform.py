"""The rival of another waveform: many beams, a camera's curve, or clipping in place of two beams' cosine."""

import numpy as np

from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding
from fitting.reasons import Reason

# A third harmonic over the first less half the square of the second: power laws of a camera leave -0.04 to 0.015 of
# two beams' fringes; more where their exponent is below 1, which makes the second negative.
_LEAST, _MOST, _SHARP = -0.04, 0.015, 0.02
# Harmonics are told where a fringe is so many blocks wide at least, in cycles of the harmonic per block.
_RESOLVED = 0.45
# Harmonics by chance exceed so many of their standard deviations next to never.
_SIGNIFICANT = 5.0


class Waveform(AbstractRival):
    """Harmonics of the fringes: the waveform of N beams is Airy's, with harmonics q, q² over the first.

    A power g of 1 + m cos x has a second harmonic s = m (g - 1) / 4 and a third (2/3) (g - 2) / (g - 1) s² to lowest
    order in m: at most 0.67 s² where s is positive, where Airy's is s².
    """

    name = "waveform"

    def finding(self, remainder: Remainder) -> Finding | None:
        """What the second and third harmonic in phase say."""
        second, third, deviation = harmonics(remainder)
        value = third - second**2 / 2
        limit = _MOST if value > 0 else _LEAST
        if abs(value) < abs(limit) + _SIGNIFICANT * deviation or (value > 0 and second < _SHARP):
            return None
        sentence = Reason.RIVAL_SHARP_FRINGES if value > 0 else Reason.RIVAL_CUT_FRINGES
        return Finding(self.name, float(value), limit, "warning", sentence(second=second, third=third))


def harmonics(remainder: Remainder) -> tuple[float, float, float]:
    """Second and third harmonic in phase over the first, and the third's standard deviation."""
    fit, used, cosine = remainder.fit, remainder.used, remainder.cosine
    slope_y, slope_x = np.gradient(fit.phase.astype(np.float32)) if min(used.shape) > 1 else (0.0, 0.0)
    finest = np.hypot(slope_y, slope_x)
    columns = []
    for order, wave in ((2, 2 * cosine**2 - 1), (3, (4 * cosine**2 - 3) * cosine)):
        columns.append(np.where(used & (order * finest < _RESOLVED), remainder.swing * wave, 0.0)[used])
    design = np.stack(columns, axis=1).astype(float)
    weighted = design * fit.left.weights[used][:, None]
    matrix = weighted.T @ design
    if not np.linalg.cond(matrix) < 1e6:
        return 0.0, 0.0, np.inf
    second, third = np.linalg.solve(matrix, weighted.T @ fit.left.value[used])
    variance = fit.chi2 / max(fit.weight, 1.0)
    return float(second), float(third), float(np.sqrt(variance * np.linalg.inv(matrix)[1, 1]))
