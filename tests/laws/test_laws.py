"""Laws of optics, on the rays and fields of whole benches."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import newtonjax as nj
from newtonjax.rays import amplitudes, arrive, carry_field, gather, trace
from newtonjax.scene import itinerary
from newtonjax.scene.beams import words

INDICES = {"lens_index": 1.62, "plate_index": 1.46, "gap_index": 1.1, "ambient_index": 1.0003}
LEANING = {"lens_tilt": (3e-3, -5e-3), "plate_tilt": (-2e-3, 4e-3), "light_tilt": (0.05, -0.02)}
VIEWS = ("transmitted", "reflected")
POINTS = 64  # every call has this shape, so that one compiled function serves all


def bench(view, radius=0.05):
    return nj.newton_rings(radius, 500e-9, 3e-6, view, screen=4e-3, **INDICES, **LEANING)


@jax.jit
def _follow(scene, starts):
    routes, setting = gather(scene)

    def one(route, start):
        landing, legs = trace(route, setting, start)
        unit = setting._replace(field=jnp.eye(3, dtype=complex))
        return landing, legs, carry_field(route, unit, legs)

    return jax.vmap(jax.vmap(one, (None, 0)), (0, None))(routes, starts)


def followed(scene, starts, beam):
    """Landings, legs and field matrices (3 x 3, of the three unit vectors) of one beam, for each launch point."""
    padded = np.concatenate([starts, np.zeros((POINTS - len(starts), 2))])
    return jax.tree.map(lambda leaf: np.asarray(leaf)[beam, : len(starts)], _follow(scene, padded))


def interactions(scene):
    """Of the scene's second beam, per interaction: whether it reflects, indices, directions, the sphere's normal."""
    landing, legs, _ = followed(scene, np.random.default_rng(2).uniform(-4e-3, 4e-3, (POINTS, 2)), beam=1)
    assert landing.alive.all()
    path = itinerary(scene.beams[1], 4)
    after = np.concatenate([legs.direction[:, 1:], landing.direction[:, None]], axis=1)
    for k, (surface, action) in enumerate(zip(path.surface, path.action, strict=True)):
        there = legs.position[:, k] + legs.length[:, k, None] * legs.direction[:, k]
        face, (a, b) = scene.surfaces[surface], scene.surfaces[surface].tilt
        axis = np.array([np.cos(a) * np.sin(b), -np.sin(a), np.cos(a) * np.cos(b)])
        normal = axis - face.curvature * (there - face.vertex)
        indices = scene.media[path.before[k]], scene.media[path.beyond[k]]
        yield bool(action), *indices, legs.direction[:, k], after[:, k], normal


@pytest.mark.parametrize("view", VIEWS)
def test_snells_law_holds_at_every_refraction(view):
    met = 0
    for reflects, n1, n2, before, after, normal in interactions(bench(view)):
        if not reflects:
            met += 1
            np.testing.assert_allclose(n1 * np.cross(before, normal), n2 * np.cross(after, normal), atol=2e-15)
            assert (np.sum(before * normal, 1) * np.sum(after * normal, 1) > 0).all()
    assert met == 4


@pytest.mark.parametrize("view", VIEWS)
def test_reflection_reverses_the_normal_part_of_the_direction_only(view):
    met = 0
    for reflects, _, _, before, after, normal in interactions(bench(view)):
        if reflects:
            met += 1
            np.testing.assert_allclose(np.sum(after * normal, 1), -np.sum(before * normal, 1), atol=1e-15)
            np.testing.assert_allclose(np.cross(after, normal), np.cross(before, normal), atol=2e-15)
    assert met == (2 if view == "transmitted" else 1)


@pytest.mark.parametrize("view", VIEWS)
def test_rays_before_and_after_lie_in_one_plane_with_the_normal(view):
    for _, _, _, before, after, normal in interactions(bench(view)):
        assert np.abs(np.sum(np.cross(before, after) * normal, 1)).max() < 1e-15
        np.testing.assert_allclose(np.linalg.norm(after, axis=1), 1, rtol=1e-14)


def turned_over(scene, direction, start_plane):
    """The bench rotated by half a turn about x, lit backwards along `direction`; the screen is the old launch plane."""
    flip = np.array([1.0, -1.0, -1.0])

    def over(face):
        return nj.Surface(-face.curvature, face.vertex * flip, (face.tilt[0], -face.tilt[1]))

    x, y, z = direction * flip  # = (cos a sin b, -sin a, cos a cos b): light along -z, turned
    light = nj.Light(scene.light.wavelength, (np.arcsin(-y), np.arctan2(x, z)))
    back = (" ".join(f"{token[0]}{3 - int(token[1])}" for token in reversed(word.split())) for word in scene.beams)
    return nj.Scene(
        surfaces=tuple(over(face) for face in reversed(scene.surfaces)),
        media=scene.media[::-1],
        light=light,
        screen=over(start_plane),
        beams=tuple(back),
    ), flip


@pytest.mark.parametrize("radius", [0.05, 2.0])
def test_light_sent_backwards_retraces_its_path_with_the_transposed_amplitudes(radius):
    scene = bench("transmitted", radius)
    start = np.array([[1.3e-3, -0.7e-3]])
    landing, _, matrix = jax.tree.map(lambda leaf: leaf[0], followed(scene, start, beam=1))
    launch_plane = nj.Surface(0.0, scene.surfaces[0].vertex, scene.light.tilt)
    reverse, flip = turned_over(scene, landing.direction, launch_plane)
    # Launch coordinates of the landing point, seen along the reversed light.
    there = landing.position + landing.length * landing.direction
    a, b = reverse.light.tilt
    frame = np.array(
        [
            [np.cos(b), 0, -np.sin(b)],
            [np.sin(a) * np.sin(b), np.cos(a), np.sin(a) * np.cos(b)],
            [np.cos(a) * np.sin(b), -np.sin(a), np.cos(a) * np.cos(b)],
        ]
    )
    offset = frame @ (there * flip - reverse.surfaces[0].vertex)
    back, _, back_matrix = jax.tree.map(lambda leaf: leaf[0], followed(reverse, offset[None, :2], beam=1))
    # Where it began: a screen turned over has its y axis reversed. Rounding of positions of some 10 mm.
    np.testing.assert_allclose(back.point, start[0] * [1, -1], atol=1e-17)
    # The reversed light counts from a plane that the landing point stands offset[2] before; 40 roundings of 16 mm.
    assert abs(back.path + offset[2] * INDICES["ambient_index"] - landing.path) < 8e-17
    a, b = scene.light.tilt
    light = np.array([np.cos(a) * np.sin(b), -np.sin(a), np.cos(a) * np.cos(b)])
    into, out = (np.linalg.svd(d[None])[2][1:].T for d in (light, landing.direction))  # unit vectors across each
    forth = out.T @ matrix @ into
    np.testing.assert_allclose(into.T @ (flip[:, None] * back_matrix * flip) @ out, forth.T, atol=1e-15)
    assert np.abs(forth).max() > 1e-3


@pytest.mark.parametrize("coherent", [True, False])
@pytest.mark.parametrize("polarization", [0.0, 0.7, np.pi / 2])
def test_reflected_and_transmitted_light_of_two_faces_sum_to_one(coherent, polarization):
    """By words of up to 15 reflections of 0.25 each at most: what is left out is of amplitude 1e-9, flux 1e-18."""
    angle, total = 0.4, 0.0
    for view, reflections in (("transmitted", 14), ("reflected", 15)):
        total += two_faces(view, words(2, reflections, view), angle, polarization, coherent)
    assert abs(total - 1) < 1e-9


@jax.jit
def _arrivals(scene):
    routes, setting = gather(scene)
    return jax.vmap(arrive, (0, None, None))(routes, setting, jnp.array([3e-4, -2e-4]))


def two_faces(view, beams, angle, polarization, coherent):
    scene = nj.Scene(
        surfaces=(nj.Surface(vertex=(0.0, 0.0, 30e-6)), nj.Surface()),
        media=(1.0, 1.5, 1.0),
        light=nj.Light(500e-9, (0.0, angle), polarization),
        screen=nj.Surface(vertex=(0.0, 0.0, -1e-3 if view == "transmitted" else 1e-3)),
        beams=beams,
    )
    found = _arrivals(scene)
    turns = np.asarray(found.path) / 500e-9
    lit = np.asarray(found.field)[..., 0]  # of polarized light the second component has no share
    field = lit * np.exp(2j * np.pi * turns)[:, None]
    summed = np.abs(field.sum(axis=0)) ** 2 if coherent else np.abs(field) ** 2
    return summed.sum() / np.cos(angle)  # irradiance is per area of the screen


def merged_words(media, sin_outside, polarization, crossings):
    """Amplitudes, scaled to flux, of all words with the same crossings of each layer, summed: {(side, counts): sum}.

    Words that cross each layer equally often have equal phases, so that only the state (medium, direction, crossings)
    matters: dynamic programming instead of a sum over millions of words.
    """
    cosines = [np.sqrt(1 - (media[0] * sin_outside / n) ** 2) for n in media]
    last = len(media) - 1
    states, out = {(0, True, (0,) * (last - 1)): 1.0}, {}
    while states:
        following = {}
        for (medium, down, counts), amplitude in states.items():
            beyond = medium + (1 if down else -1)
            n1, n2, c1, c2 = media[medium], media[beyond], cosines[medium], cosines[beyond]
            r_s, r_p, t_s, t_p = amplitudes(n1, n2, c1, c2)
            r, t = (r_s, t_s) if polarization == "s" else (r_p, t_p)
            for reached, heads, factor in ((medium, not down, r), (beyond, down, t * np.sqrt(n2 * c2 / (n1 * c1)))):
                if reached in (0, last):
                    key = ("reflected" if reached == 0 else "transmitted", counts)
                    out[key] = out.get(key, 0.0) + amplitude * factor
                    continue
                passed = tuple(c + (k == reached - 1) for k, c in enumerate(counts))
                if max(passed) <= crossings:
                    key = (reached, heads, passed)
                    following[key] = following.get(key, 0.0) + amplitude * factor
        states = following
    return out, cosines


@pytest.mark.parametrize("polarization", ["s", "p"])
@pytest.mark.parametrize("sine", [0.0, 0.5])
def test_reflected_and_transmitted_light_of_four_faces_sum_to_one(polarization, sine):
    media, thickness = (1.0, 1.5, 1.0, 1.7, 1.0), (11e-6, 1.3e-6, 17e-6)
    out, cosines = merged_words(media, sine, polarization, crossings=25)
    inner = [n * c * t for n, c, t in zip(media[1:-1], cosines[1:-1], thickness, strict=True)]
    sums = dict.fromkeys(("transmitted", "reflected"), 0.0)
    for (view, counts), amplitude in out.items():
        sums[view] += amplitude * np.exp(2j * np.pi * np.dot(counts, inner) / 500e-9)
    assert abs(sum(abs(field) ** 2 for field in sums.values()) - 1) < 1e-9
    assert 0.02 < abs(sums["reflected"]) ** 2 < 0.98


def test_merged_words_are_the_words_that_the_project_enumerates():
    """Summed one by one, at normal incidence, with r = (n1 - n2) / (n1 + n2) and t = sqrt(1 - r²)."""
    media, summed = (1.0, 1.5, 1.0, 1.7, 1.0), {}
    for view, reflections in (("transmitted", 6), ("reflected", 7)):
        for word in words(4, reflections, view):
            path, amplitude = itinerary(word, 4), 1.0
            for action, before, beyond in zip(path.action, path.before, path.beyond, strict=True):
                r = (media[before] - media[beyond]) / (media[before] + media[beyond])
                amplitude *= r if action else np.sqrt(1 - r * r)
            key = (view, tuple(path.before.count(layer) for layer in (1, 2, 3)))
            summed[key] = summed.get(key, 0.0) + amplitude
    merged, _ = merged_words(media, 0.0, "s", crossings=6)
    few = {key for key in merged if sum(key[1]) <= 6}  # such words have at most 7 reflections: all are enumerated
    assert len(few) > 10
    assert max(abs(merged[key] - summed[key]) for key in few) < 1e-15


def unpolarized_coefficient(scene, beam, radius):
    """Flux fraction of a ray at a distance from the axis of a centred bench: s and p keep apart; by angles, as taught.

    R_s = (sin(i-t)/sin(i+t))², R_p = (tan(i-t)/tan(i+t))² (Born and Wolf 1.5.2, eq. 33).
    """
    s = p = 1.0
    path = itinerary(scene.beams[beam], 4)
    _, legs, _ = followed(scene, np.column_stack([radius, 0 * radius]), beam)
    for k, action in enumerate(path.action):
        i = np.arccos(np.clip(np.abs(np.sum(legs.direction[:, k] * legs.normal[:, k], 1)), 0, 1))
        n1, n2 = scene.media[path.before[k]], scene.media[path.beyond[k]]
        t = np.arcsin(n1 * np.sin(i) / n2)
        head_on = i < 1e-6
        i, t = np.where(head_on, 1e-3, i), np.where(head_on, np.arcsin(n1 * np.sin(1e-3) / n2), t)
        r_s, r_p = (np.sin(i - t) / np.sin(i + t)) ** 2, (np.tan(i - t) / np.tan(i + t)) ** 2
        r_s, r_p = (np.where(head_on, ((n1 - n2) / (n1 + n2)) ** 2, r) for r in (r_s, r_p))
        s, p = s * (r_s if action else 1 - r_s), p * (r_p if action else 1 - r_p)
    return (s + p) / 2


@pytest.mark.parametrize("beam", [0, 1])
@pytest.mark.parametrize(
    ("view", "distance"), [("transmitted", 1e-3), ("transmitted", 10e-3), ("reflected", 1e-3), ("reflected", 60e-3)]
)
def test_flux_through_the_image_of_a_disc_is_the_flux_launched_times_the_coefficients(view, distance, beam):
    """A bench of 25 mm radius, the screen leaning, so that the image of the disc of launch points is none."""
    scene = nj.newton_rings(0.025, 500e-9, 2e-6, view, screen=distance, lens_index=1.62)
    scene = dataclasses.replace(scene, screen=dataclasses.replace(scene.screen, tilt=(0.1, -0.2)))
    disc = 3e-3
    x, weight = np.polynomial.legendre.leggauss(24)
    r, weight = (x + 1) / 2, weight / 2
    launched = 2 * np.pi * disc**2 * np.sum(weight * r * unpolarized_coefficient(scene, beam, disc * r))
    assert abs(received_flux(scene, beam, disc, r, weight) - launched) < 1e-9 * launched


_arrive_at = jax.jit(jax.vmap(arrive, (None, None, 0)))


def received_flux(scene, beam, disc, r, weight, spokes=POINTS):
    """Irradiance integrated over the image: rays from the image's middle to its edge, which is drawn by tracing."""
    azimuth = 2 * np.pi * np.arange(spokes) / spokes
    edge = followed(scene, disc * np.column_stack([np.cos(azimuth), np.sin(azimuth)]), beam)[0].point
    middle = edge.mean(axis=0)
    arm = edge - middle
    order = np.fft.fftfreq(spokes, 1 / spokes)[:, None]
    slope = np.fft.ifft(1j * order * np.fft.fft(arm, axis=0), axis=0).real
    # With x = middle + r arm(azimuth), dA = r |arm x d arm/d azimuth| dr d azimuth.
    stretch = np.abs(arm[:, 0] * slope[:, 1] - arm[:, 1] * slope[:, 0])
    points = middle + r[:, None, None] * arm
    routes, setting = gather(scene)
    found = _arrive_at(jax.tree.map(lambda leaf: leaf[beam], routes), setting, jnp.asarray(points.reshape(-1, 2)))
    assert found.arrives.all()
    received = (np.abs(np.asarray(found.field)) ** 2).sum(axis=1).mean(axis=1).reshape(len(r), spokes)  # unpolarized
    return np.sum(weight[:, None] * r[:, None] * received * stretch) * 2 * np.pi / spokes
