"""How far a ratio under one unknown light moves among models that are as good: what no scatter of one fit shows."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from fitting.colour.unknown_problem import Number, SharedOptimum, SharedProblem, shared_optimum, variances_of
from fitting.colour.unknown_scatter import deviations, log_scales
from fitting.colour.waveform import COLOURS, Curve

# Waves and roughness over the usual ones; degrees of the background besides the usual one.
_FINENESS, _ROUGHNESS, _DEGREES = (0.75, 1.5), (0.2, 5.0), (2, 5)
# Gap from which on rings are taken [m], where so many bins remain; and share of the rings that are taken.
_INNER, _FEWEST, _OUTER = 0.8e-6, 100, 0.7
# A model that leaves so many times as much is none; steps to its optimum.
_ADMISSIBLE, _STEPS = 2.0, 3


def models_of(problem: SharedProblem, best: SharedOptimum) -> dict[str, SharedProblem]:
    """The models besides the usual one, by name."""
    light, together = problem.light, tuple(range(len(problem.profiles)))
    models: dict[str, SharedProblem] = {}
    for fineness in _FINENESS:
        models[f"{fineness:g} times the waves"] = replace(
            problem, light=light._replace(waves=round(fineness * light.waves))
        )
    for roughness in _ROUGHNESS:
        models[f"a spectrum {roughness:g} times as rough"] = replace(problem, light=light._replace(roughness=roughness))
    models |= {f"background of degree {degree}": replace(problem, degree=degree) for degree in _DEGREES}
    rates = [np.exp(curve.log_rate) for curve in best.curves]
    inner = [single.within(_INNER / rate, np.inf) for single, rate in zip(problem.profiles, rates, strict=True)]
    outer = [single.within(0.0, _OUTER * float(single.squares.max())) for single in problem.profiles]
    for name, profiles in (("without the innermost rings", inner), ("without the outermost rings", outer)):
        if min(len(single.squares) for single in profiles) > _FEWEST:
            models[name] = replace(problem, profiles=tuple(profiles))
    own_blur = tuple(Number("blur", (picture,)) for picture in together[1:])
    first_blur = tuple(Number("blur", together[:1]) if number.name == "blur" else number for number in problem.free)
    models["a blur of each picture"] = replace(problem, free=(*first_blur, *own_blur))
    lateral = tuple(Number(COLOURS[channel], together) for channel in problem.channels if channel != 1)
    if len(problem.channels) > 1:
        models["lateral colour"] = replace(problem, free=(*problem.free, *lateral))
    models["distortion"] = replace(problem, free=(*problem.free, Number("bend", together)))
    return models


class Shift(NamedTuple):
    """What another model changes in logarithms of scales, and in their differences from the first one's.

    `noise`: standard deviations of changes of noise alone.
    """

    change: Float[np.ndarray, "2 pictures"]
    noise: Float[np.ndarray, "2 pictures"]


class Estimate(NamedTuple):
    """Logarithms of the pictures' scales and their differences from the first one's, and the deviations of both."""

    values: Float[np.ndarray, "2 pictures"]
    deviations: Float[np.ndarray, "2 pictures"]


def estimate(problem: SharedProblem, curves: tuple[Curve, ...]) -> Estimate:
    """Of the curves of an optimum."""
    answers = problem.solved(curves)
    scales, gradients = log_scales(problem, curves, answers)
    both = deviations(problem, curves, answers, np.concatenate([gradients, gradients - gradients[0]]))
    return Estimate(np.stack([scales, scales - scales[0]]), both.reshape(2, -1))


def shifts_of(problem: SharedProblem, best: SharedOptimum, usual: Estimate) -> dict[str, Shift]:
    """Of the admissible models besides the best one, by name; noise is counted as `variants.py` counts it."""
    shifts = {}
    for name, model in models_of(problem, best).items():
        # Of the same bins.
        reference = replace(problem, profiles=model.profiles)
        curves = shared_optimum(model, best.curves, _STEPS).curves
        unexplained = variances_of(model, curves) / variances_of(reference, best.curves)
        if np.mean(unexplained) < _ADMISSIBLE:
            other = estimate(model, curves)
            further = np.maximum(other.deviations**2 - usual.deviations**2, 0.0)
            shifts[name] = Shift(other.values - usual.values, np.sqrt(further))
    return shifts
