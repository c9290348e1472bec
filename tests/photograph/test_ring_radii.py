"""The rings' radii by order: where the rings are, as uncertain as the fit says, and what `rings` makes of them."""

import json

import numpy as np
import pytest
from rings_data import WAVELENGTH, added_path, rings

import fitting
from fitting.shell.cli import main

GIVEN = {"wavelength": WAVELENGTH, "pixel_size": 5e-6, "view": "reflected"}


def true_radius(turns, radius, gap=0.0, view="reflected"):
    """Where the path difference of `rings_data.rings` is so many wavelengths [m]."""
    r2 = np.linspace(0, (1.5e-3) ** 2, 200_001)
    height = gap + r2 / radius / (1 + np.sqrt(1 - r2 / radius**2))
    path = 2 * height + added_path(r2 / radius**2, height, gap, view)
    return np.sqrt(np.interp(np.asarray(turns) * WAVELENGTH, path, r2))


@pytest.mark.parametrize(
    ("radius", "view", "kinds"),
    [(0.02, "reflected", ("dark", "bright")), (0.3, "transmitted", ("bright", "dark"))],
)
def test_rings_lie_where_the_path_difference_is_whole_and_half_waves(radius, view, kinds):
    image = rings(radius, gap=60e-9, noise=0.02, dark=view == "reflected")
    result = fitting.fit(image, **(GIVEN | {"view": view}))
    of_kind = [[ring for ring in result.rings if ring.kind == kind] for kind in kinds]
    for before, rows in zip((0.0, 0.5), of_kind, strict=True):
        order = np.array([ring.order for ring in rows])
        assert order.tolist() == list(range(1, len(order) + 1))
        radii, sds = np.array([(ring.radius, ring.radius_sd) for ring in rows]).T
        assert np.abs((radii - true_radius(order - before, radius, 60e-9, view)) / sds).max() < 4
    assert len(of_kind[0]) > 3
    distances = [ring.radius_px for ring in result.rings]
    assert distances == sorted(distances)
    assert distances[-1] < np.hypot(130, 135) + 1


def test_deviations_are_those_of_radius_and_gap_together():
    result = fitting.fit(rings(noise=0.05), **GIVEN, pixel_size_sd=1e-8, parts={"contact": False})
    at = [result.names.index(name) for name in ("radius", "gap")]
    spread = result.covariance[np.ix_(at, at)]
    for ring in result.rings:
        # r² = 2 R (m λ/2 - g)
        slopes = np.array([ring.radius / (2 * result.radius), -result.radius / ring.radius])
        of_image = np.sqrt(slopes @ spread @ slopes)
        assert ring.radius_sd == pytest.approx(np.hypot(of_image, ring.radius * 2e-3), rel=1e-3)
        assert ring.radius_px_sd * 5e-6 == pytest.approx(of_image, rel=1e-3)


@pytest.mark.parametrize("pixel_size", [5e-6, None])
def test_rings_finds_the_fits_radius_again(pixel_size):
    result = fitting.fit(rings(0.02, gap=40e-9, noise=0.02), **(GIVEN | {"pixel_size": pixel_size}))
    for kind in ("dark", "bright"):
        again = fitting.rings(result.ring_table(kind), wavelength=WAVELENGTH, bright=kind == "bright")
        assert again.gap == pytest.approx(40e-9, abs=5e-9)
        if pixel_size is None:
            difference = again.fringe_scale_per_px2 - result.fringe_scale_per_px2
            assert abs(difference) < 0.1 * result.fringe_scale_sd
        else:
            assert abs(again.radius - result.radius) < 0.1 * result.radius_sd


def test_a_distortion_and_a_view_are_taken_off():
    y, x = np.mgrid[:256, :256].astype(float)
    ux, uy = (x - 127.5) / 180.3, (y - 127.5) / 180.3
    factor = 1 + 0.02 * (ux**2 + uy**2)
    dx, dy = 180.3 * ux * factor * np.exp(0.01), 180.3 * uy * factor * np.exp(-0.01)
    turns = (dx**2 + dy**2) * 15e-6**2 / WAVELENGTH
    image = 0.5 - 0.4 * np.cos(2 * np.pi * turns) + 0.01 * np.random.default_rng(1).normal(size=x.shape)
    given = GIVEN | {"pixel_size": 15e-6}
    result = fitting.fit(image, **given, parts={"distortion": True, "oblique_view": True, "contact": False})
    for ring in (ring for ring in result.rings if ring.kind == "dark"):
        assert abs(ring.radius - np.sqrt(ring.order * WAVELENGTH)) < 4 * ring.radius_sd


def test_a_traced_bench_has_the_rings_of_its_own_picture():
    import newtonjax as nj

    scene, camera = nj.newton_rings(0.3, WAVELENGTH), nj.Camera((128, 128), 1e-5)
    image = np.asarray(nj.render(scene, camera), float)
    image = image + 0.02 * image.max() * np.random.default_rng(2).normal(size=image.shape)
    traced = fitting.fit(image, scene=scene, pixel_size=1e-5)
    formula = fitting.fit(image, wavelength=WAVELENGTH, pixel_size=1e-5, view="reflected", parts={"contact": False})
    assert [(ring.order, ring.kind) for ring in traced.rings] == [(ring.order, ring.kind) for ring in formula.rings]
    for ring, by_formula in zip(traced.rings, formula.rings, strict=True):
        assert abs(ring.radius - by_formula.radius) < 0.5 * by_formula.radius_sd
        assert ring.radius_sd == pytest.approx(by_formula.radius_sd, rel=0.2)


def test_rings_are_saved_and_written_as_tables(tmp_path, capsys):
    np.save(tmp_path / "rings.npy", rings(noise=0.02))
    folder = tmp_path / "out"
    given = ["--wavelength", f"{WAVELENGTH * 1e9:g}nm"]
    fit = ["fit", str(tmp_path / "rings.npy"), *given, "--pixel-size", "5um", "--output-dir", str(folder)]
    assert main(fit) == 0
    assert "[[Rings]]" in capsys.readouterr().out
    result = fitting.FitResult.load(folder / "result.json")
    assert result.rings
    assert result.ring_table("dark")["order"][0] == 1
    for kind, options in (("dark", []), ("bright", ["--bright"])):
        assert main(["rings", str(folder / f"{kind}_rings.csv"), *given, *options, "--json", "-"]) == 0
        again = json.loads(capsys.readouterr().out)
        assert abs(again["radius_m"] - result.radius) < 0.1 * result.radius_sd
    with pytest.raises(ValueError, match="kind is 'grey'"):
        result.ring_table("grey")
