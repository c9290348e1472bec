"""What errors of held numbers do together: closed forms for small ones and for squares; files that go on."""

import csv
import json

import numpy as np
import pytest
from compilations import compilations
from scipy.io import netcdf_file
from scipy.stats import sobol_indices
from shell import refusal

import fitting
import newtonjax as nj
from fitting.shell.cli import main
from fitting.studies import draws_file, sobol

SCENE = nj.newton_rings(2.0, 550e-9, 0.3e-6, "reflected", screen="gap")
CAMERA = nj.Camera((26, 24), 0.1e-3)
SMALL = {"pixel_size": "0.1%", "wavelength": "0.1%"}


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """The study, broken off after its first batch, begun again; and the fits that were made each time."""
    file, made = tmp_path_factory.mktemp("spread") / "draws.nc", []

    def stop(done, total):
        made.append((done, total))
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fitting.spread(SCENE, CAMERA, SMALL, draws=32, path=file, progress=stop)
    fits = sobol._BatchedFits.__call__
    counted = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sobol._BatchedFits, "__call__", lambda self, rows: counted.append(len(rows)) or fits(self, rows))
        with compilations() as compiled:
            found = fitting.spread(SCENE, CAMERA, SMALL, draws=32, path=file)
    assert compiled.count == 0
    return found, file, made[0], sum(counted)


def test_small_errors_are_those_of_their_slopes(small):
    """R goes with s²/λ: shares of four fifths and one fifth."""
    found = small[0]
    assert found.slope_sd == pytest.approx(2.0 * 1e-3 * np.sqrt(5), rel=2e-3)
    assert found.sd == pytest.approx(found.slope_sd, rel=0.1)
    assert abs(found.shift) < 0.05 * found.sd
    assert [one.name for one in found.shares] == ["pixel_size", "wavelength"]
    for one, share in zip(found.shares, (0.8, 0.2), strict=True):
        assert one.total == pytest.approx(share, abs=0.05)
        for low, high in (one.first_range, one.total_range):
            assert low <= share <= high
    expected = 2.0 * (found.draws["pixel_size"] / 0.1e-3) ** 2 * (550e-9 / found.draws["wavelength"])
    np.testing.assert_allclose(found.targets, expected, rtol=1e-6)
    assert "given numbers leave sd" in str(found)


def test_indices_are_those_of_scipy():
    """Of a function in which numbers act together: f = x y + x."""
    rows = sobol._unit_rows(2, 256, 3)
    ours = sobol.indices((rows[:, 0] * rows[:, 1] + rows[:, 0]).reshape(4, 256))
    a, b, ab, ba = np.split(rows, 4)
    of = [(one[:, 0] * one[:, 1] + one[:, 0])[None] for one in (a, b, ab, ba)]
    theirs = sobol_indices(func={"f_A": of[0], "f_B": of[1], "f_AB": np.stack(of[2:])}, n=256)
    np.testing.assert_allclose(ours[0], theirs.first_order, rtol=1e-9)
    np.testing.assert_allclose(ours[1], theirs.total_order, rtol=1e-9)
    np.testing.assert_allclose(ours, [[0.5, 0.0], [1.0, 0.5]], atol=0.15)  # x alone, nothing of y but with x
    shares = list(sobol._shares(np.stack([one[0] for one in of]), 0))
    assert shares == list(sobol._shares(np.stack([one[0] for one in of]), 0))
    for (_, (low, high), *_), share in zip(shares, (0.5, 0.0), strict=True):
        assert low <= share <= high


def test_what_was_broken_off_goes_on(small):
    found, file, (done, total), after = small
    assert total == 32 * 4 == len(found.targets)
    assert done + after == total
    with netcdf_file(str(file), mmap=False) as kept:
        np.testing.assert_array_equal(kept.variables["radius"][:], found.targets)
        assert kept.variables["pixel_size"].units == b"m"
        assert b"[camera]" in kept.scene
    with pytest.raises(ValueError, match="holds draws of another study"):
        fitting.spread(SCENE, CAMERA, SMALL, draws=64, path=file)
    whole = file.read_bytes()
    broken = file.with_name("broken.nc")
    broken.write_bytes(whole[:100])
    with pytest.raises(ValueError, match="is not a file of draws"):
        fitting.spread(SCENE, CAMERA, SMALL, draws=32, path=broken)
    study = {name: getattr(kept, name).decode() for name in ("scene", "known", "fit")}
    refused = 0
    for at in range(0, len(whole), 5):  # whatever byte is wrong, it is accepted or refused, with a line
        broken.write_bytes(whole[:at] + bytes([whole[at] ^ 0x41]) + whole[at + 1 :])
        try:
            draws_file.DrawsFile(
                broken, found.draws, "radius", dict.fromkeys(("pixel_size", "wavelength", "radius"), "m"), study
            )
        except ValueError:
            refused += 1
    assert refused > 100
    row = whole.index(found.draws["wavelength"].astype(">f8").tobytes())
    broken.write_bytes(whole[:row] + np.float64(1e-6).astype(">f8").tobytes() + whole[row + 8 :])
    with pytest.raises(ValueError, match="holds draws of another study"):
        fitting.spread(SCENE, CAMERA, SMALL, draws=32, path=broken)


def test_tilts_about_zero_act_by_their_squares():
    """The path is 2 t cos θ: R found is R cos θ, whose slope is zero; two tilts of deviation σ leave R σ² of it."""
    found = fitting.spread(SCENE, CAMERA, {"light_tilt_x": 0.05, "light_tilt_y": 0.05}, draws=32, seed=1)
    assert found.slope_sd < 0.01 * found.sd
    tilt2 = found.draws["light_tilt_x"] ** 2 + found.draws["light_tilt_y"] ** 2
    np.testing.assert_allclose(found.targets, 2.0 * (1 - tilt2 / 2), rtol=2e-4)
    assert found.shift == pytest.approx(-2.0 * 0.05**2, rel=0.2)
    assert found.sd == pytest.approx(2.0 * 0.05**2, rel=0.3)
    for one in found.shares:
        low, high = one.total_range
        assert low <= 0.5 <= high


@pytest.mark.parametrize(
    ("known", "more", "message"),
    [
        (SMALL, {"draws": 48}, "draws is 48; allowed: a power of two"),
        (SMALL, {"draws": 16}, "draws is 16; allowed: a power of two from 32 on"),
        ({"pixel_size": "30%"}, {}, "at most a quarter of it"),
        ({"light_tilt_x": "5%"}, {}, "light_tilt_x is 0, and 5% of 0 is 0; give it in rad"),
        ({"colour": 1.0}, {}, "'colour' is not a number of this scene"),
        ({}, {}, "no number is named"),
        ({"gap": 1e-9}, {}, "gap is free"),
        ({"pixel_size": 0.0}, {}, "allowed: a positive value"),
        ({"pixel_size": "much"}, {}, "allowed: a standard deviation in its unit"),
        ({"light_tilt_x": 3.0}, {"draws": 32}, "does not converge"),
    ],
)
def test_it_refuses_with_a_line(known, more, message):
    with pytest.raises(ValueError, match=message):
        fitting.spread(SCENE, CAMERA, known, **more)


def test_the_verb_prints_shares_and_writes_the_draws(tmp_path, capsys):
    """Of one number all is its own, and of any size its effect is the formula's."""
    path, folder = tmp_path / "scene.toml", tmp_path / "out"
    nj.save_scene(path, SCENE, CAMERA)
    asked = ("sensitivity", str(path), "--sd", "wavelength=5nm", "--draws", "32")
    assert main([*asked, "--output-dir", str(folder)]) == 0
    assert "given numbers leave sd" in capsys.readouterr().out
    answer = json.loads((folder / "spread.json").read_text())
    assert [share["name"] for share in answer["shares"]] == ["wavelength"]
    assert answer["shares"][0]["total"] == pytest.approx(1.0, abs=0.3)
    with netcdf_file(str(folder / "spread.nc"), mmap=False) as draws:
        wavelengths, radii = (draws.variables[name][:] for name in ("wavelength", "radius"))
        np.testing.assert_allclose(radii, 2.0 * 550e-9 / wavelengths, rtol=1e-6)
    with (folder / "spread.csv").open(newline="") as table:
        assert [float(row["total"]) for row in csv.DictReader(table)] == [share["total"] for share in answer["shares"]]
    assert (folder / "sensitivity.csv").exists()
    assert (folder / "spread.png").read_bytes().startswith(b"\x89PNG")
    kept = (folder / "spread.nc").read_bytes()
    assert main([*asked, "--output-dir", str(folder), "--force"]) == 0
    assert (folder / "spread.nc").read_bytes() == kept
    assert "is there already" in refusal(capsys, *asked, "--output-dir", folder)
    assert "the image does not determine radius with gap, pixel_size free" in refusal(
        capsys, "sensitivity", path, "--free", "gap,pixel_size", status=3
    )
    assert "--draws needs --sd" in refusal(capsys, "sensitivity", path, "--draws", "64")
    for draws in ("48", "0", "-32"):
        assert "allowed: a power of two" in refusal(capsys, *asked[:-1], draws)
    before = {path: path.read_bytes() for path in folder.iterdir()}
    of_another_study = (*asked[:-1], "64", "--output-dir", folder, "--force")
    assert "holds draws of another study" in refusal(capsys, *of_another_study)
    assert {path: path.read_bytes() for path in folder.iterdir()} == before
