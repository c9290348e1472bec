"""The model of one channel at every pixel."""

import numpy as np
from jaxtyping import Bool, Float

from fitting.colour.measuring import ColourFit
from fitting.colour.waveform import gaps


def fitted_images(
    fit: ColourFit, number: int, shape: tuple[int, int], wavelength: float
) -> tuple[Float[np.ndarray, "rows columns"], Float[np.ndarray, "rows columns"], Bool[np.ndarray, "rows columns"]]:
    """Model image of a channel of the fit, phase of a wavelength's rings [turns], and where the model holds.

    Between the middles of bins the waveform is interpolated, and the light behind the rings between blocks.
    """
    rings, best = fit.rings, fit.fit
    problem, curve = best.problem, best.optimum.curve
    columns, rows = np.meshgrid(np.arange(shape[1], dtype=float), np.arange(shape[0], dtype=float))
    squares = rings.placed.figure.squares(columns, rows)
    profile = problem.profiles.squares
    model = problem.solved(curve)[number].model
    blocks, size = rings.blocks, rings.blocks.size
    table = np.full([-(-n // size) for n in shape], np.nan)
    places = ((blocks.y / size).astype(int), (blocks.x / size).astype(int))
    table[places] = rings.placed.behind[number]
    used = np.zeros(table.shape, bool)
    used[places] = rings.placed.is_used
    at = (np.arange(shape[0])[:, None] // size, np.arange(shape[1]) // size)
    fitted = np.nan_to_num(table)[at] * np.interp(squares, profile, model)
    is_fitted = (problem.profiles.weight[number] > 0).astype(float)
    holds = used[at] & (np.interp(squares, profile, is_fitted, left=0.0, right=0.0) > 0.99)
    phase = 2 * gaps(curve, squares, 1, problem.view) / wavelength
    return fitted, phase + (0.5 if problem.view.sign < 0 else 0.0), holds
