"""The same light in other people's programs: batoid's rays, and thin films by tmm."""

import dataclasses

import jax
import numpy as np
import pytest
import tmm

import newtonjax as nj
from newtonjax.fields import opd_at
from newtonjax.scene.beams import words

WAVELENGTH = 500e-9
# Radians. Batoid squares the whole radius in its root, which rounds the path by some 1e-16 m at each face.
RADIANS = 1e-8


def batoid_path(batoid, scene, word, launch):
    """Landing points on the screen and optical paths by batoid of rays along -z from the plane of the first vertex."""
    count = len(launch)
    z = scene.surfaces[0].vertex[2]
    rays = batoid.RayVector(*launch.T.copy(), np.full(count, z), *(np.zeros(count) for _ in "xy"), -np.ones(count))
    layer, down = 0, True
    for token in word.split():
        surface = scene.surfaces[int(token[1])]
        shape = batoid.Plane() if surface.curvature == 0 else batoid.Sphere(1 / surface.curvature)
        there = batoid.CoordSys(surface.vertex, batoid.RotX(surface.tilt[0]))
        if token[0] == "R":
            shape.reflect(rays, coordSys=there)
            down = not down
        else:
            beyond = layer + (1 if down else -1)
            media = (batoid.ConstMedium(scene.media[k]) for k in (layer, beyond))
            shape.refract(rays, *media, coordSys=there)
            layer = beyond
    batoid.Plane().intersect(rays, coordSys=batoid.CoordSys(scene.screen.vertex))
    rays.toCoordSys(batoid.CoordSys(scene.screen.vertex))
    return np.column_stack([rays.x, rays.y]), rays.t


@pytest.mark.parametrize("view", ["transmitted", "reflected"])
def test_batoid_finds_the_same_two_paths(view, record_property):
    batoid = pytest.importorskip("batoid", reason="batoid is not installed (extra 'peers')")
    scene = nj.newton_rings(2.0, WAVELENGTH, gap=1e-6, view=view, plate_tilt=(1e-3, 0.0), screen=5e-3)
    targets = np.random.default_rng(5).uniform(-2.5e-3, 2.5e-3, (200, 2))
    ours = np.asarray(jax.jit(opd_at)(scene, targets)[0])
    theirs = []
    for word in scene.beams:
        launch = targets
        for _ in range(12):  # launch and landing points nearly agree: each round gains two digits
            landed, path = batoid_path(batoid, scene, word, launch)
            launch = launch + targets - landed
        assert np.abs(landed - targets).max() < 1e-17
        theirs.append(path)
    error = 2 * np.pi * np.abs(ours - (theirs[1] - theirs[0])).max() / WAVELENGTH
    record_property("radians", float(error))
    assert error < RADIANS


def film(angle, indices, thickness, reflections, view, polarization=None, wedge=0.0, radius=np.inf):
    """Two faces only: the light starts in the first medium; the wedge and the screen lie as in `air_wedge`."""
    axis_x = (0.0, -wedge)
    return nj.Scene(
        surfaces=(nj.Surface(1 / radius, (0.0, 0.0, thickness), axis_x), nj.Surface()),
        media=indices,
        light=nj.Light(WAVELENGTH, (0.0, angle), polarization),
        screen=nj.Surface(0.0, (0.0, 0.0, 0.0 if view == "transmitted" else thickness)),
        beams=words(2, reflections, view),
    )


POLARIZATION = {"p": 0.0, "s": np.pi / 2}  # the light is turned about y, so that x lies in the plane of incidence
CAMERA = nj.Camera((1, 9), 20e-6)


@pytest.mark.parametrize(("view", "key"), [("transmitted", "T"), ("reflected", "R")])
def test_many_beams_between_parallel_faces_make_the_film_of_tmm(view, key):
    image = jax.jit(lambda scene: nj.render(scene, CAMERA, method=nj.Traced()))
    for polarization, turn in POLARIZATION.items():
        for angle, thickness in [(0.0, 2.1e-6), (0.15, 2.1e-6), (0.2, 333e-9)]:
            scene = film(angle, (3.0, 1.2, 2.5), thickness, 26 if key == "T" else 27, view, turn)
            peer = tmm.coh_tmm(polarization, [3.0, 1.2, 2.5], [np.inf, thickness, np.inf], angle, WAVELENGTH)[key]
            # tmm sums to infinity; here the fifteenth round trip in the film is the first that is left out.
            inside, behind = tmm.list_snell([3.0, 1.2, 2.5], angle)[1:]
            trip = tmm.interface_r(polarization, 1.2, 3.0, inside, angle)
            trip *= tmm.interface_r(polarization, 1.2, 2.5, inside, behind)
            # Per area of the screen: the light is of unit irradiance on a plane across it.
            assert np.abs(np.asarray(image(scene)) / np.cos(angle) - peer).max() < 2 * abs(trip) ** 14 + 1e-12


def test_many_beams_of_a_thin_wedge_follow_tmm_at_the_local_thickness():
    angle, thickness = 2e-5, 1.7e-6
    scene = film(0.0, (2.0, 1.0, 2.0), thickness, 16, "transmitted", wedge=angle)
    camera = nj.Camera((1, 64), 500e-6)
    image = np.asarray(nj.render(scene, camera, method=nj.Traced()))[0]
    x = (np.arange(64) - 31.5) * 500e-6
    peer = [
        tmm.coh_tmm("s", [2.0, 1.0, 2.0], [np.inf, thickness + a * np.tan(angle), np.inf], 0, WAVELENGTH)["T"]
        for a in x
    ]
    assert np.ptp(peer) > 0.2
    # Beam k walks off by k² angle thickness and lags k³ angle² thickness behind the parallel film: 1e-6 of a turn.
    # The first beam left out, 18 reflections of 1/3 each, has the amplitude 3e-9.
    assert np.abs(image - np.array(peer)).max() < 1e-6


def test_many_beams_of_a_thick_four_face_stack_are_the_plates_of_tmm():
    """Lens and plate turned plane: with the words of up to 5 reflections, against the stack of films."""
    scene = nj.newton_rings(
        np.inf, WAVELENGTH, gap=1.3e-6, lens_thickness=11e-6, plate_thickness=17e-6, screen=0.0, view="transmitted"
    )
    scene = dataclasses.replace(scene, beams=words(4, 8, "transmitted"))
    peer = tmm.coh_tmm("s", [1, 1.5, 1, 1.5, 1], [np.inf, 11e-6, 1.3e-6, 17e-6, np.inf], 0, WAVELENGTH)["T"]
    image = nj.render(scene, nj.Camera((1, 2), 1e-6), method=nj.Traced())
    # The 4004 words with 10 reflections, of amplitude 0.2 each and with scattered phases, are left out.
    assert np.abs(np.asarray(image) - peer).max() < 2 * 4004**0.5 * 0.2**10
