"""The rings of a photograph before any fit, and why there are none."""

from dataclasses import replace

import numpy as np

from fitting.parameters import lens_misfit
from fitting.photo import Rings, evidence_of, follow, pixels_of, resolving_view, search_of
from fitting.photograph.second_look import bent_rings, rings_in_the_middle, rings_without_spots
from fitting.photograph.sharp_rings import refusal_of_sharp_rings
from fitting.photograph.task import Task
from fitting.photograph.verdict import RefusedError

# A match below this is chance, and says nothing of the lens; one above is that of circles.
_LEAST_MATCH, _CIRCLES = 0.05, 0.5


def find(task: Task) -> tuple[Task, Rings]:
    """The rings of a photograph, and the task, whose photograph may be cut to where they are clear.

    Raises RefusedError where nothing speaks for rings, or they are larger than the lens that makes them.
    """
    photograph, view = task.photograph, None
    if task.start:
        rings = follow(photograph, _given_rings(task))
    else:
        rings, view = search_of(photograph)
    # A bench may well make fringes of many beams, or slanted ones; and a person who gives a start has seen them.
    is_doubted = task.scene is None and not task.start
    evidence = evidence_of(photograph, rings, resolving_view(photograph, rings, view)) if is_doubted else None
    no_rings = None if evidence is None else evidence.reason
    x, y = pixels_of(photograph.mask)
    reach = float(np.hypot(x - rings.centre[0], y - rings.centre[1]).max())
    if rings.match >= _LEAST_MATCH and (reason := lens_misfit(task.quantities, rings.scale, reach)):
        raise RefusedError(reason, photograph)
    if evidence is not None and view is not None and (no_rings or rings.match < _CIRCLES):
        if no_rings and (refusal := refusal_of_sharp_rings(task, rings, evidence)):
            raise refusal
        clearer = bent_rings(photograph, view, rings.match)
        if no_rings and clearer is None:
            clearer = rings_without_spots(photograph) or rings_in_the_middle(photograph)
            if clearer is None:
                raise RefusedError(no_rings, photograph)
        photograph, rings = clearer or (photograph, rings)
    return replace(task, photograph=photograph), rings


def _given_rings(task: Task) -> Rings:
    scale, values = task.start.get("fringe_scale_per_px2"), task.quantities.given
    if scale is None:
        if "pixel_size" not in values or "wavelength" not in values:
            raise ValueError("start holds a radius, which needs pixel_size and wavelength; give fringe_scale_per_px2")
        scale = values.get("gap_index", 1.0) * values["pixel_size"] ** 2 / (task.start["radius"] * values["wavelength"])
    return Rings(float(scale), task.start["centre_px"], 0.0, 0.0)
