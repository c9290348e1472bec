"""How many nodes resolve what pixels and the directions of a source leave of the fringes."""

import numpy as np

from newtonjax.fields import bending_error
from newtonjax.methods import AbstractPicture, Chebyshev, error_between_directions
from newtonjax.numerics import chebyshev
from newtonjax.scene import Camera, Scene

LADDER = (3, 4, 5, 6, 7, 9, 11, 13, 17, 21, 25, 29, 33)
# Nodes to a side of grids by which coarser ones are judged, and by how much coarser these are at least. Of the first
# two each direction takes one call and two calls for its rays.
_GRIDS = ((8, 3), (12, 4), (17, 4), (41, 4))


def resolved(
    scene: Scene, camera: Camera, least: int, tolerance: float, table_error: float
) -> tuple[Chebyshev, float, AbstractPicture]:
    """The fewest nodes, at least so many, that keep a tolerance; their error, over the peak, and picture.

    Its coefficients are those of a finer grid, cut: no rays are traced again.

    Raises ValueError where a beam does not reach the whole image, or no grid is fine enough.
    """
    for finest, margin in _GRIDS:
        counts = [count for count in LADDER if least <= count <= finest - margin]
        if not counts:
            continue
        fine = Chebyshev(finest, table_error=table_error)
        light = fine.light(scene, camera)
        fields, picture_of = fine.cuts(light, scene, camera)
        shells, parts = chebyshev.shells(fields), (len(fields) - 1) // 3
        size = shells[1 : 1 + 2 * parts].sum()
        least_error = bending_error(fields[1 + 2 * parts :], camera) + error_between_directions(scene, camera, light)
        for count in counts:
            beyond = 2 * shells[:, count:].sum(axis=1)
            error = beyond[: 1 + 2 * parts].sum() + 2 * np.pi * size * beyond[1 + 2 * parts :].max()
            error = float(error / (abs(fields[0, 0, 0]) + size)) + least_error
            if error <= tolerance:
                return Chebyshev(count, table_error=table_error), error, picture_of(count)
    raise ValueError(
        f"aperture and blur over fringes that change within a pixel by more than {tolerance:.2g}, or that no grid of "
        "nodes resolves; allowed: a larger tolerance, finer pixels or a smaller image"
    )
