"""Normal priors: (value, standard deviation), or a normal distribution of SciPy's that says the same."""

from typing import Any

import numpy as np

from fitting.parameters.fringe_scale import read_sd
from newtonjax.numerics import shown


def normal_pair(prior: Any) -> Any:
    """Mean and standard deviation of a normal distribution of SciPy's; anything else as it is."""
    is_normal = getattr(getattr(prior, "dist", None), "name", None) == "norm"
    if not is_normal or np.ndim(prior.mean()):
        return prior
    return float(prior.mean()), float(prior.std())


def positive_sd(name: str, sd: Any, value: float) -> float:
    """A standard deviation above zero, also a percentage of a value that is not 0. Raises ValueError otherwise."""
    is_relative, size = read_sd(sd)
    absolute = size * abs(value) if is_relative else size
    if not 0 < absolute < np.inf:
        allowed = 'a number above zero, or a percentage of a value that is not 0, such as "10%"'
        raise ValueError(f"{name} has the sd {shown(sd)}; allowed: {allowed}")
    return absolute
