"""What a result keeps of its fit, for all that is asked of it afterwards."""

from typing import NamedTuple

import numpy as np

from fitting.estimate import Fitted
from fitting.parameters import Quantities
from fitting.photograph.averaging import Averaging


class Evidence(NamedTuple):
    """What a posterior is made of: the fit, what was given, the noise's variance per unit weight, the covariance.

    `averaging`, `ratio`: over sets of parts, as those of a `Choice`.
    """

    found: Fitted
    known: Quantities
    variance: float
    covariance: np.ndarray
    averaging: Averaging | None = None
    ratio: float = 1.0
