"""What is known of the camera before the picture: joined to a finished fit."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fitting.estimate import Fitted, problem_of, residuals_of, stay
from fitting.model import PARTS
from fitting.parameters import NUMBERS, slots_of


def with_prior(fit: Fitted, priors: Mapping[str, tuple[float, float]], variance: float) -> Fitted:
    """The fit moved to where the image and normal priors, by number (value, standard deviation), have their optimum.

    On the model linearized at the fit (Tarantola 2005, 3.2.3); a part that a prior speaks of joins the others.
    `variance`: of the light per unit weight, errors that neighbours share included.
    """
    slots, matrix = slots_of(priors), fit.matrix
    centre, cost = np.zeros(len(matrix.values)), np.zeros(len(matrix.values))
    centre[slots] = [value for value, _ in priors.values()]
    cost[slots] = [variance / sd**2 for _, sd in priors.values()]
    active = matrix.active.copy()
    active[slots] = True
    joined = replace(matrix, active=active, prior=matrix.prior + cost)
    step = np.zeros(len(matrix.values))
    step[active] = joined.inverse @ (matrix.gradient + cost * (centre - matrix.values))[active]
    present = {*fit.parts, *(name for name, part in PARTS.items() if set(part.parameters) & set(priors))}
    parts = tuple(name for name in PARTS if name in present)
    problem = problem_of(fit.model, fit.fixed, parts, fit.shape)
    problem = replace(problem, prior=dict(priors), variance=variance)
    solution = stay(problem, fit.solution.normal, fit.numbers + step[: len(NUMBERS)], fit.converged)
    return replace(
        fit,
        parts=parts,
        solution=solution,
        left=residuals_of(solution, fit.reduced, fit.scale),
        matrix=replace(joined, values=matrix.values + step, gradient=matrix.gradient - matrix.matrix @ step),
    )
