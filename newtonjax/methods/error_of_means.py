"""What tables of pixels' means err by, where these are functions of the path difference in a gap."""

import numpy as np

from newtonjax.fields import airy_of, airy_pixels, bent_factors, gap_means, harmonics_of, twisting_error
from newtonjax.methods.gap_paths import parallel
from newtonjax.numerics import chebyshev
from newtonjax.scene import Camera, Scene, channels_of, gap_between, node_points

# Nodes to a side at which factors are compared, what may hide between them, and harmonics that are left out.
_NODES, _BETWEEN, _LEFT_OUT = 17, 1.5, 1e-6
# Steps of an order at which the brightest place of its profile is looked for.
_STEPS = 1001


def means_error(scene: Scene, camera: Camera) -> float:
    """By how much `GapMeans` are off the means over pixels, over the peak; of known numbers.

    Against what the local slope and bend of the path difference make of them at nodes; what its third derivative may
    change is added. 0 for pixels that are points.
    """
    gap, wavenumber = gap_between(scene), 1 / float(scene.wavelength)
    means = gap_means(gap, camera, wavenumber)
    if means is None:
        return 0.0
    points = node_points(camera, _NODES)
    turns = np.broadcast_to(gap.opd(points[:, 0], points[:, 1]) * wavenumber, len(points))
    ratios = np.asarray(channels_of(scene.light, None).lines.ratios)
    waves = np.unique([ratios.min(), 1.0, ratios.max()])
    twisted = twisting_error(chebyshev.coefficients(turns[None]), camera) * waves.max()
    error = 0.0
    for order, size in enumerate(_sizes(scene), 1):
        expected = bent_factors(turns[None], camera, order * waves)[:, 0]
        real, imaginary = means.of(order * waves[:, None], turns, 1.0, 0.0)
        error += size * (abs(real + 1j * imaginary - expected).max() + order * twisted)
    return _BETWEEN * float(error)


def _sizes(scene: Scene) -> np.ndarray:
    """Amplitudes of the harmonics of the fringes over their peak, of the mean line at normal incidence."""
    airy = airy_of(parallel(scene), np.asarray(scene.wavelength), np.zeros(()))
    orders = np.arange(harmonics_of(airy, _LEFT_OUT))
    phase = 2 * np.pi * np.linspace(0.0, 1.0, _STEPS)
    first, again = abs(airy.first[0]), abs(airy.round_trip[0])
    peak = airy_pixels(tuple(part[0] for part in airy.parts()), np.cos(phase), np.sin(phase)).max()
    return 2 * first * again**orders / peak
