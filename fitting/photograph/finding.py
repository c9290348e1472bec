"""The rings of a photograph before any fit, and why there are none."""

from dataclasses import replace

import numpy as np

from fitting.parameters import Quantities, lensless
from fitting.photo import Photograph, Rings, evidence_of, find_rings, follow, pixels_of, view_of
from fitting.photograph.second_look import rings_in_the_middle, rings_without_spots
from fitting.photograph.task import Task
from fitting.photograph.verdict import RefusedError
from fitting.reasons import Reason
from newtonjax.numerics import Statement


def find(task: Task) -> tuple[Task, Rings]:
    """The rings of a photograph, and the task, whose photograph may be cut to where they are clear.

    Raises RefusedError where nothing speaks for rings, or they are larger than the lens that makes them.
    """
    photograph, coarse = task.photograph, view_of(task.photograph)
    rings = follow(photograph, _given_rings(task)) if task.start else find_rings(photograph, coarse)
    # A bench may well make fringes of many beams, or slanted ones; and a person who gives a start has seen them.
    is_doubted = task.scene is None and not task.start
    no_rings = evidence_of(photograph, rings, coarse).reason if is_doubted else None
    if reason := _too_steep(photograph, rings, task.quantities):
        raise RefusedError(reason, photograph)
    if no_rings:
        clearer = rings_without_spots(photograph) or rings_in_the_middle(photograph)
        if clearer is None:
            raise RefusedError(no_rings, photograph)
        photograph, rings = clearer
    return replace(task, photograph=photograph), rings


def _given_rings(task: Task) -> Rings:
    scale, values = task.start.get("fringe_scale_per_px2"), task.quantities.given
    if scale is None:
        if "pixel_size" not in values or "wavelength" not in values:
            raise ValueError("start holds a radius, which needs pixel_size and wavelength; give fringe_scale_per_px2")
        scale = values.get("gap_index", 1.0) * values["pixel_size"] ** 2 / (task.start["radius"] * values["wavelength"])
    return Rings(float(scale), task.start["centre_px"], 0.0, 0.0)


def _too_steep(photograph: Photograph, rings: Rings, known: Quantities) -> Statement | None:
    """That the given quantities make the lens smaller than the field it fills; None where they do not."""
    if known.unknown is None or rings.match < 0.05:
        return None
    values = known.values(rings.scale)
    x, y = pixels_of(photograph.mask)
    reach = values["pixel_size"] * float(np.hypot(x - rings.centre[0], y - rings.centre[1]).max())
    if reach < values["radius"]:
        return lensless(known.plate[0], values["radius"], reach) if known.plate else None
    return Reason.LENS_SMALLER_THAN_FIELD(radius=values["radius"], reach=reach)
