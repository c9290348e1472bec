"""Ready benches: Newton's rings and the air wedge."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from newtonjax.benches.checks import checked
from newtonjax.benches.light_and_matter import curvature_of, extent_of, index_of, light_of, mean_wavelength
from newtonjax.numerics import Scalar, Vector2
from newtonjax.scene import (
    AllOrders,
    Coating,
    CollectingLens,
    Scene,
    Shield,
    Spectrum,
    Surface,
    Terms,
    Zernike,
    choose_beams,
    coating,
    focus_height,
    frame,
    lens_to_image,
)

_PAIRS = {
    "transmitted": ("T0 T1 T2 T3", "T0 T1 R2 R1 T2 T3"),
    "reflected": ("T0 R1 T0", "T0 T1 R2 T1 T0"),
}


@checked
def newton_rings(
    radius: Scalar = 1.0,
    wavelength: Scalar = 589.3e-9,
    gap: Scalar = 0.0,
    view: str = "reflected",
    *,
    light: str | Spectrum | None = None,
    screen: Scalar | str = "gap",
    lens_index: Scalar | str = 1.5,
    plate_index: Scalar | str = 1.5,
    gap_index: Scalar | str = 1.0,
    ambient_index: Scalar | str = 1.0,
    lens_thickness: Scalar = 5e-3,
    plate_thickness: Scalar = 5e-3,
    lens_tilt: Vector2 = (0.0, 0.0),
    plate_tilt: Vector2 = (0.0, 0.0),
    light_tilt: Vector2 = (0.0, 0.0),
    angular_radius: Scalar | None = None,
    numerical_aperture: Scalar | None = None,
    source_distance: Scalar | None = None,
    lamp_radius: Scalar | None = None,
    collimator: Scalar | None = None,
    polarization: Scalar | None = None,
    polarization_degree: Scalar | None = None,
    beams: Sequence[str] | str | None = None,
    lens_coating: Coating | str | None = None,
    plate_coating: Coating | str | None = None,
    shield: Scalar | None = None,
    collecting_lens: Scalar | None = None,
    conic: Scalar | None = None,
    asphere: Terms | None = None,
    odd_asphere: Terms | None = None,
    radius_across: Scalar | None = None,
    axis: Scalar | None = None,
    zernike: Terms | None = None,
    zernike_radius: Scalar | None = None,
    plate_radius: Scalar | None = None,
) -> Scene:
    """A plano-convex lens, convex face down, over a plane-parallel plate (Debelov and Dolgov 2021, section 4).

    Surfaces in order: 0 the lens's flat face, 1 its convex face, 2 and 3 the plate's upper and lower face. The plate's
    upper face has its vertex at the origin; the apex of the convex face stands at height `gap` over it.

    Args:
      radius: of the convex face [m]; infinite for a plane, negative for a concave face.
      wavelength: in vacuum [m].
      light: a `Spectrum`, or the words for one that `lamp` takes, instead of a wavelength.
      gap: height of the apex [m]; 0 is contact, negative an approach beyond it.
      view: "reflected" (reflections at the convex face and at the plate's upper face) or "transmitted" (direct beam and
        the one reflected twice in the gap); `beams` (words, or names as in `choose_beams`) replaces the pair, and
        "all" takes all orders in the gap.
      screen: distance [m] of a plane below the plate ("transmitted") or above the lens ("reflected"), or "gap": a
        microscope focused on the plate's upper face, i.e. the plane of that face's paraxial image through the glass.
      lens_index, plate_index, gap_index, ambient_index: refractive indices, or names such as "N-BK7" as
        `refractive_index` takes them, at the wavelength of the light (the mean one of a spectrum).
      lens_thickness, plate_thickness: on the axis [m].
      lens_tilt, plate_tilt: rotations about x and y [rad], of the lens about its apex, of the plate about the origin.
      angular_radius: of a round source, as seen from the bench [rad]; other shapes are an `Extent` of the `Light`.
      numerical_aperture: of a microscope that lights the gap and sees it through one objective; it is such a source.
      source_distance: of the lamp from the vertex of the upper face [m]; None for parallel light.
      lamp_radius: of a round lamp at that distance [m], instead of its angular radius.
      collimator: focal length [m] of a thin lens on the upper face, through which the lamp lights the bench: from its
        focal plane if no `source_distance` is given (Debelov and Dolgov 2021, figure 5: lamp, filter, bench,
        collecting lens, shield and screen; a filter is of the `light`).
      light_tilt, polarization, polarization_degree: as in `Light`.
      lens_coating, plate_coating: on the faces of the gap, as a `Coating` or the words for one that `coating` takes;
        with one all orders in the gap are summed.
      shield: radius [m] of a round hole in a shield on the face where the light leaves; None for no shield.
      collecting_lens: focal length [m] of an ideal lens that images the gap, enlarged, on a `screen` at least four
        times as far away; None for a bare screen (Debelov and Dolgov 2021, figure 5).
      conic, asphere, odd_asphere, axis: of the convex face, as in `Surface`.
      radius_across: of the convex face across `axis` [m], a toroid; infinite for a cylinder.
      zernike, zernike_radius: of the convex face, as in `Zernike`, in Noll's order.
      plate_radius: of the plate's upper face [m], positive where it bulges to the lens, negative for a concave one.

    Raises ValueError for values that no bench can have. Traced values are not checked.

    """
    lens_axis, plate_axis = frame(lens_tilt)[2], frame(plate_tilt)[2]
    ambient = index_of(ambient_index, mean_wavelength(light, wavelength, 1.0))
    mean = mean_wavelength(light, wavelength, ambient)
    lens_index, plate_index, gap_index = (index_of(n, mean, ambient) for n in (lens_index, plate_index, gap_index))
    if isinstance(screen, str):
        height = 0.0  # placed below, once there is a scene whose focus can be computed
    else:
        height = -plate_thickness - screen if view == "transmitted" else gap + lens_thickness + screen
    scene = Scene(
        surfaces=(
            Surface(0.0, _point_on_axis(lens_axis, lens_thickness, gap), lens_tilt),
            Surface(
                1 / radius,
                (0.0, 0.0, gap),
                lens_tilt,
                conic,
                asphere,
                odd_asphere,
                None if radius_across is None else 1 / radius_across,
                axis,
                _zernike(zernike, zernike_radius),
            ),
            Surface(0.0 if plate_radius is None else -1 / plate_radius, (0.0, 0.0, 0.0), plate_tilt),
            Surface(0.0, _point_on_axis(plate_axis, -plate_thickness), plate_tilt),
        ),
        media=(ambient, lens_index, gap_index, plate_index, ambient),
        light=light_of(
            light,
            wavelength,
            ambient,
            light_tilt,
            polarization,
            polarization_degree,
            extent_of(
                angular_radius,
                numerical_aperture,
                ambient,
                lamp_radius,
                collimator if source_distance is None else source_distance,
            ),
            curvature_of(source_distance, collimator),
        ),
        screen=Surface(0.0, (0.0, 0.0, height)),
        beams=_PAIRS[view],
    )
    scene = _with_orders(scene, beams, lens_coating, plate_coating)
    beams = None if scene.all_orders is not None else beams
    return _with_options(scene, screen, beams, shield, collecting_lens)


def _zernike(coefficients, radius) -> Zernike | None:
    if (coefficients is None) != (radius is None):
        raise ValueError("zernike and zernike_radius: one is given without the other; allowed: both, or none")
    return None if coefficients is None else Zernike(coefficients, radius)


def _with_orders(scene: Scene, beams, lens_coating, plate_coating) -> Scene:
    """The scene with all orders in its gap, where they are asked for or a face is coated."""
    is_all = beams == "all" or (isinstance(beams, tuple | list) and tuple(beams) == ("all",))
    coatings = [_coating(part, scene.wavelength) for part in (lens_coating, plate_coating)]
    if coatings == [None, None] and not is_all:
        return scene
    if beams is not None and not is_all:
        raise ValueError("beams with a coating; allowed: 'all', since every order in the gap counts, or None")
    return replace(scene, all_orders=AllOrders(*coatings))


def _coating(part: Coating | str | None, wavelength: Scalar) -> Coating | None:
    return coating(part, wavelength) if isinstance(part, str) else part


def _with_options(scene: Scene, screen, beams, shield, collecting_lens) -> Scene:
    """The bench with the options that follow from the rest of it: beams by name, focus, shield, collecting lens."""
    if beams is not None:
        scene = choose_beams(scene, names=tuple(beams))
    if shield is not None:
        face = scene.surfaces[-1 if scene.view == "transmitted" else 0]
        scene = replace(scene, shield=Shield(shield, face.vertex, face.tilt))
    if screen == "gap":
        if collecting_lens is not None:
            raise ValueError("collecting_lens with screen='gap': it needs a screen at a distance; give that in metres")
        return replace(scene, screen=Surface(0.0, (0.0, 0.0, focus_height(scene, upper=1))))
    if collecting_lens is None:
        return scene
    focus = focus_height(scene, upper=1)
    down = -1.0 if scene.view == "transmitted" else 1.0
    before = lens_to_image(down * (scene.screen.vertex[2] - focus), collecting_lens)
    return replace(scene, collecting_lens=CollectingLens(collecting_lens, (0.0, 0.0, focus + down * before)))


@checked
def air_wedge(
    wedge_angle: Scalar = 1e-4,
    wavelength: Scalar = 589.3e-9,
    gap: Scalar = 0.0,
    view: str = "reflected",
    *,
    light: str | Spectrum | None = None,
    screen: Scalar | str = "gap",
    lens_index: Scalar | str = 1.5,
    plate_index: Scalar | str = 1.5,
    gap_index: Scalar | str = 1.0,
    ambient_index: Scalar | str = 1.0,
    lens_thickness: Scalar = 5e-3,
    plate_thickness: Scalar = 5e-3,
    plate_tilt: Vector2 = (0.0, 0.0),
    light_tilt: Vector2 = (0.0, 0.0),
    angular_radius: Scalar | None = None,
    numerical_aperture: Scalar | None = None,
    source_distance: Scalar | None = None,
    lamp_radius: Scalar | None = None,
    collimator: Scalar | None = None,
    polarization: Scalar | None = None,
    polarization_degree: Scalar | None = None,
    beams: Sequence[str] | str | None = None,
    lens_coating: Coating | str | None = None,
    plate_coating: Coating | str | None = None,
    shield: Scalar | None = None,
    collecting_lens: Scalar | None = None,
) -> Scene:
    """Two plane-parallel plates, the upper one turned by `wedge_angle` so that the gap opens towards +x.

    Surfaces in order: 0 and 1 the upper plate, 2 and 3 the lower one; the gap is `gap` + x tan(wedge_angle) thick.

    Args:
      wedge_angle: [rad], below 45 degrees in size.
      gap: thickness of the gap on the axis [m].
      lens_index, plate_index: refractive indices of the upper and of the lower plate.
      lens_thickness, plate_thickness: of the upper and of the lower plate [m].
      plate_tilt: rotations of the lower plate about x and y [rad]; the gap's angle is the difference of the plates'.
      wavelength, light, gap_index, ambient_index: as in `newton_rings`, and so are view, screen, light_tilt,
        angular_radius, numerical_aperture, source_distance, lamp_radius, collimator,
        polarization, polarization_degree, beams, lens_coating (of the upper plate), plate_coating, shield and
        collecting_lens.

    Raises ValueError for values that no bench can have. Traced values are not checked.

    """
    return newton_rings(
        np.inf,
        wavelength,
        gap,
        view,
        light=light,
        screen=screen,
        lens_index=lens_index,
        plate_index=plate_index,
        gap_index=gap_index,
        ambient_index=ambient_index,
        lens_thickness=lens_thickness,
        plate_thickness=plate_thickness,
        lens_tilt=(0.0 * wedge_angle, -wedge_angle),
        plate_tilt=plate_tilt,
        light_tilt=light_tilt,
        angular_radius=angular_radius,
        numerical_aperture=numerical_aperture,
        source_distance=source_distance,
        lamp_radius=lamp_radius,
        collimator=collimator,
        polarization=polarization,
        polarization_degree=polarization_degree,
        beams=beams,
        lens_coating=lens_coating,
        plate_coating=plate_coating,
        shield=shield,
        collecting_lens=collecting_lens,
    )


def _point_on_axis(axis, length: Scalar, height: Scalar = 0.0):
    return axis[0] * length, axis[1] * length, height + axis[2] * length
