"""What the light and the camera change in an image: parts of `explain`."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from newtonjax.fields import Fields
from newtonjax.methods import AbstractMethod, ClosedForm, means_error, parallel, summed_at_nodes
from newtonjax.scene import Camera, Light, Scene, channels_of, imaged_plane

# What may hide between the points where an image with and without a part are compared.
_BETWEEN, _BETWEEN_SLOPES = 2.0, 1.5
# Order of the quadrature over a source.
_ORDER = 4


@dataclass(frozen=True)
class Omission:
    """A part of the optics, and by how much the image would change with it, or without it.

    - `part`: what it is.
    - `error`: bound on the largest change of intensity over the peak; None where there is no number for it.
    - `modelled`: whether the image has it.
    - `note`: how it was estimated, or what it takes to have it.
    """

    part: str
    error: float | None
    modelled: bool
    note: str


def peak_of(fields: Fields) -> float:
    """The largest intensity that fields may make."""
    return float(fields.background.max() + np.abs(fields.envelope).sum(axis=0).max())


def way_of_means(scene: Scene, camera: Camera, method: AbstractMethod) -> str:
    """How the means over pixels are in an image, and what tables of the path difference alone err by."""
    if not camera.takes_means:
        return "the image is taken at the pixels' centres"
    if ClosedForm().refusal(scene) is not None:
        return "by aperture and blur, at nodes"
    error = f"{means_error(scene, camera):.2g}"
    if isinstance(method, ClosedForm):
        return f"by aperture and blur, as functions of the path difference, which err by {error}"
    return f"by aperture and blur, at nodes (functions of the path difference alone would err by {error})"


def of_pixel(
    fields: Fields, frequency: tuple[np.ndarray, np.ndarray], all_arrive: bool, modelled: bool, note: str
) -> Omission:
    """What the mean over a pixel takes off the contrast, sinc(fx) sinc(fy); all where a beam ends within the pixel."""
    if not all_arrive:
        return Omission(
            "mean over each pixel", 1.0, False, "a beam ends in the image: on its edge a pixel is lit or dark"
        )
    size = np.abs(fields.envelope).sum(axis=0)
    contrast = np.sinc(frequency[0]) * np.sinc(frequency[1])
    error = _BETWEEN_SLOPES * float((size * (1 - contrast)).max()) / peak_of(fields)
    return Omission("mean over each pixel", error, modelled, note)


def of_line_width(scene: Scene, fields: Fields, tolerance: float) -> Omission:
    """The width of a line that would fade the fringes by the tolerance: exp(-2 (π m δ)²) at the order m."""
    order = float(np.abs(fields.phase).max(initial=0.0))
    width = float(np.sqrt(tolerance / 2) / (np.pi * order)) * float(scene.wavelength) if order else np.inf
    return Omission(
        "width of the line, coherence", None, False, f"an rms width of {width * 1e9:.2g} nm costs {tolerance:g}"
    )


def of_spectrum(light: Light, fields: Fields) -> Omission:
    """What the fading of the fringes and the shift of their phase change, against one sharp line."""
    change = np.abs(channels_of(light, None).lines.coherence(fields.phase) - 1)
    error = min(_BETWEEN_SLOPES * float((np.abs(fields.envelope) * change).max()) / peak_of(fields), 2.0)
    note = "against one sharp line of the mean wavenumber; lenses and plates do not disperse"
    return Omission("spectrum, coherence", error, True, note)


def of_extent(scene: Scene, camera: Camera, fields: Fields, tolerance: float) -> Omission:
    """What the source's size changes; of parallel light the angular radius that would cost the tolerance.

    The mean of the path 2 n t cos θ over a disc of angular radius α is shorter by the part α²/4.
    """
    part, order = "extent of the source", float(np.abs(fields.phase).max(initial=0.0))
    if scene.light.extent is None:
        radius = 2 * float(np.sqrt(tolerance / (np.pi * order))) if order else np.inf
        note = f"an angular radius of {radius:.2g} rad costs {tolerance:g} where fringes lie in the gap"
        return Omission(part, None, False, note)
    lit = summed_at_nodes(scene, camera, _ORDER)
    change = np.abs(lit - summed_at_nodes(parallel(scene), camera, 1)).max() / lit.max()
    error = min(_BETWEEN * float(change), 2.0)
    return Omission(part, error, True, "against parallel light, in the mean line")


def of_distance(scene: Scene, camera: Camera, points: Float[np.ndarray, "n 2"], fields: Fields, tolerance: float):
    """What the curved wavefront of a near source changes; of plane waves the distance that would cost the tolerance.

    At an angle θ to the axis the path is shorter by the part θ²/2, and the irradiance by 3 θ²/2.
    """
    part, order = "distance of the source", float(np.abs(fields.phase).max(initial=0.0))
    if scene.light.curvature is None:
        reach = float(np.hypot(*points.T).max()) / abs(float(imaged_plane(scene)[1]))
        distance = reach * float(np.sqrt((np.pi * order / 2 + 1.5) / tolerance))
        note = f"a source {distance:.2g} m away costs {tolerance:g} where fringes lie in the gap"
        return Omission(part, None, False, note)
    lit = summed_at_nodes(scene, camera, _ORDER)
    by_plane_waves = replace(scene, light=replace(scene.light, curvature=None))
    plane = summed_at_nodes(by_plane_waves, camera, _ORDER)
    change = np.abs(lit - (lit @ plane) / (plane @ plane) * plane).max() / lit.max()
    note = "against plane waves that make the image as bright, in the mean line"
    error = min(_BETWEEN * float(change), 2.0)
    return Omission(part, error, True, note)
