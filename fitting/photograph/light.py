"""How far the light behind a few fringes moves their scale."""

from dataclasses import replace

import numpy as np

from fitting.estimate import SHAPES, solve
from fitting.photograph.choice import Choice

# The least degrees of background and contrast that a few fringes are compared with.
_RICHER = (4, 2)


def with_richer_light(choice: Choice) -> Choice:
    """A choice of few fringes, with its fit behind more uneven light among the fits that are not ruled out.

    Degrees of background and contrast are those of the least information criterion; what a contrast of no polynomial's
    form (a Gaussian's, a blur's) leaves over moves the scale of a few fringes by up to some percent, and hardly shows.
    The next degrees tell: of 4 and 2 at least.
    """
    fit = choice.found
    if fit.shape == SHAPES[-1] or not fit.converged:
        return choice
    shape = SHAPES[max(SHAPES.index(fit.shape) + 1, SHAPES.index(_RICHER))]
    weighted = replace(fit.reduced, weights=fit.left.weights)
    with np.errstate(over="ignore", invalid="ignore"):
        solution = solve(replace(fit.solution.problem, degrees=shape), weighted, fit.numbers)
    if not (solution.converged and np.isfinite(solution.numbers).all()):
        return choice
    return choice._replace(undecided=(*choice.undecided, ("light behind few fringes", replace(fit, solution=solution))))
