"""The command: wrong usage, pictures, answers, exit statuses and what it asks of JAX."""

import json
import os
import subprocess
import sys
from types import SimpleNamespace

import imageio.v3 as imageio
import jax
import numpy as np
import pytest
from matplotlib.figure import Figure

import fitting
import newtonjax as nj
from fitting import fit_verb, progress, session
from fitting.cli import main

KEYS = [
    *("status", "message", "radius_m", "radius_sd_m", "radius_interval_m", "radius_sd_noise_m", "fringe_scale_per_px2"),
    *("centre_px", "gap_m", "contact_radius_m", "explained_variance", "budget", "warnings", "model", "seconds"),
]


def refusal(capsys, *arguments) -> str:
    """The one line on stderr with which the command refuses wrong usage."""
    assert main([str(argument) for argument in arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("newtonjax: ")
    assert printed.err.count("\n") == 1
    return printed.err


# Usage


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "no verb given"),
        (("measure",), "measure"),
        (("fit",), "PHOTO"),
        (("fit", "none.png"), "none.png is no file"),
        (("fit", "none.png", "--wavelength", "589.3"), "has no unit"),
        (("fit", "none.png", "--pixel-size", "0um"), "not above zero"),
        (("fit", "none.png", "--pixel-size-sd", "nan um"), "is no length"),
        (("fit", "none.png", "--transfer", "cubic"), "linear, srgb, or an exponent"),
        (("fit", "none.png", "--view", "sideways"), "sideways"),
        (("render", "reflected"), "--output"),
        (("render", "reflected", "--output", "a.jpg"), "ends in .png"),
        (("render", "reflected", "--output", "no/such/a.png"), "no/such is no folder"),
        (("render", "sideways", "--output", "a.png"), "transmitted, reflected, wedge"),
        (("render", "none.toml", "--output", "a.png"), "none.toml is no file"),
        (("render", "none.toml", "--output", "a.png", "--radius", "1m"), "the file gives the scene"),
        (("render", "wedge", "--output", "a.png", "--radius", "1m"), "--angle, --gap, --screen"),
        (("render", "reflected", "--output", "a.png", "--angle", "1mrad"), "--radius, --gap, --screen"),
        (("render", "reflected", "--output", "a.png", "--radius", "0m"), "non-zero radius"),
        (("render", "reflected", "--output", "a.png", "--shape", "1024"), "ROWSxCOLUMNS"),
        (("render", "reflected", "--output", "a.png", "--tolerance", "0"), "tolerance is 0.0"),
        (("render", "reflected", "--output", "a.png", "--method", "closed-form"), "focused on the gap"),
        (("render", "reflected", "--output", "a.png", "--method", "traced", "--nodes", "5"), "--nodes"),
    ],
)
def test_wrong_usage_is_refused_in_one_line(capsys, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert said in refusal(capsys, *arguments)
    assert not list(tmp_path.iterdir())


def test_version_is_the_packages(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"newtonjax {nj.__version__}\n"


@pytest.mark.parametrize("verb", ["render", "fit", "demo"])
def test_each_verb_explains_itself(capsys, verb):
    assert main([verb, "--help"]) == 0
    assert "--force" in capsys.readouterr().out


# Render


def decoded(path):
    codes = imageio.imread(path)
    if codes.dtype == np.uint16:
        return codes / 65535
    value = codes / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize(("bits", "step"), [(16, 0.5 / 65535), (8, 0.6 * 2.4 / 255)])
def test_a_rendered_file_reads_back_as_linear_light(capsys, tmp_path, bits, step):
    path = tmp_path / "rings.png"
    options = f"--radius 2m --wavelength 500nm --shape 48x64 --nodes 5 --bits {bits} --output {path}"
    assert main(["render", "transmitted", *options.split()]) == 0
    scene = nj.newton_rings(2.0, 500e-9)
    truth = np.asarray(nj.render(scene, nj.Camera((48, 64), 5e-6), nj.Chebyshev(5)))
    assert np.abs(decoded(path) - truth / truth.max()).max() <= step * 1.001
    said = capsys.readouterr().out
    assert f"white is {truth.max():.6g} of the incident irradiance" in said
    assert "Chebyshev, 5 x 5 nodes" in said
    assert "turns" in said


def test_an_exposure_is_a_photograph_that_a_seed_repeats(capsys, tmp_path):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        options = f"--expose --seed {seed} --shape 48x64 --nodes 5 --output {tmp_path / name}.png"
        assert main(["render", "transmitted", *options.split()]) == 0
    a, b, c = (imageio.imread(tmp_path / f"{name}.png") for name in "abc")
    assert np.array_equal(a, b)
    assert not np.array_equal(a, c)
    assert "read noise of 5, seed 2" in capsys.readouterr().out


def test_a_scene_file_renders_as_its_preset_and_keeps_its_camera(capsys, tmp_path):
    scene, path = tmp_path / "scene.toml", tmp_path / "rings.png"
    nj.save_scene(scene, nj.newton_rings(2.0, 500e-9), nj.Camera((48, 64), 5e-6))
    assert main(["render", str(scene), "--nodes", "5", "--output", str(path)]) == 0
    options = f"--radius 2m --wavelength 500nm --shape 48x64 --nodes 5 --output {tmp_path / 'preset.png'}"
    assert main(["render", "transmitted", *options.split()]) == 0
    assert path.read_bytes() == (tmp_path / "preset.png").read_bytes()
    assert "is what the command reads" in refusal(capsys_cleared(capsys), "render", scene, "-o", png_named(scene))


def capsys_cleared(capsys):
    capsys.readouterr()
    return capsys


def png_named(scene):
    """A name that ends in .png and is the scene file."""
    link = scene.with_suffix(".png")
    link.symlink_to(scene)
    return link


def test_a_method_that_misses_the_tolerance_is_refused(capsys, tmp_path):
    options = f"--nodes 3 --tolerance 1e-9 --shape 48x64 --output {tmp_path / 'a.png'}"
    assert "is over --tolerance" in refusal(capsys, "render", "transmitted", *options.split())


def test_existing_pictures_stay_without_force(capsys, tmp_path):
    path = tmp_path / "rings.png"
    path.write_text("mine")
    assert "--force" in refusal(capsys, "render", "reflected", "--output", path)
    assert path.read_text() == "mine"


# Fit: the shell around it, with an answer put in its place


def an_answer(status="ok", **changes):
    answer = {
        **dict.fromkeys(KEYS),
        "status": status,
        "message": "no rings\nwere found",
        "radius_m": 1.0,
        "radius_sd_m": 0.01,
        **changes,
    }
    return SimpleNamespace(
        status=status,
        message=answer["message"],
        radius=answer["radius_m"],
        radius_sd=answer["radius_sd_m"],
        as_dict=lambda: answer,
        report=lambda: f"radius {answer['radius_m']}",
    )


@pytest.fixture
def fitted(monkeypatch, tmp_path):
    """Replace the fit; the list of (photo, arguments) that it was called with, its answer, and a photo."""
    calls, answer = [], [an_answer()]

    def fit(photo, **arguments):
        calls.append((photo, arguments))
        return answer[0]

    monkeypatch.setattr(fitting, "fit", fit, raising=False)
    monkeypatch.setattr(fit_verb, "_picture", lambda _: b"picture")
    photo = tmp_path / "photo.png"
    photo.write_bytes(b"")
    return SimpleNamespace(calls=calls, answer=answer, photo=str(photo))


def test_quantities_reach_the_fit_in_si(fitted):
    options = "--wavelength sodium --wavelength-sd 0.3nm --pixel-size 12.75um --pixel-size-sd 0.1um --transfer 2.2"
    assert main(["fit", fitted.photo, *options.split()]) == 0
    (_, arguments) = fitted.calls[0]
    assert arguments == {
        "wavelength": pytest.approx(589.294e-9, rel=1e-6),
        "wavelength_sd": pytest.approx(3e-10),
        "pixel_size": pytest.approx(12.75e-6),
        "pixel_size_sd": pytest.approx(1e-7),
        "radius": None,
        "view": "reflected",
        "transfer": 2.2,
    }


def test_a_scene_file_gives_what_was_not_given(fitted, tmp_path, capsys):
    scene = tmp_path / "scene.toml"
    bench = nj.newton_rings(2.0, 500e-9, ambient_index=1.00027)
    nj.save_scene(scene, bench, nj.Camera((48, 64), 5e-6))
    assert main(["fit", fitted.photo, "--scene", str(scene)]) == 0
    assert main(["fit", fitted.photo, "--scene", str(scene), "--wavelength", "sodium-d2"]) == 0
    first, second = (arguments for _, arguments in fitted.calls)
    assert (first["wavelength"], first["pixel_size"], first["view"]) == (500e-9, 5e-6, "transmitted")
    assert first["scene"].beams == bench.beams
    assert second["wavelength"] == pytest.approx(589.1583e-9, rel=5e-6)
    assert "leave --view out" in refusal(
        capsys_cleared(capsys), "fit", fitted.photo, "--scene", scene, "--view", "reflected"
    )


@pytest.mark.parametrize(("status", "code"), [("ok", 0), ("no-scale", 0), ("refused", 3), ("not-converged", 4)])
def test_the_exit_status_tells_how_the_fit_ended(fitted, capsys, status, code):
    fitted.answer[0] = an_answer(status)
    assert main(["fit", fitted.photo]) == code
    printed = capsys.readouterr()
    assert printed.err == (f"newtonjax: {status}: no rings were found\n" if code else "")
    assert bool(printed.out) == (code != 3)


def test_json_on_stdout_is_one_object_and_nothing_else(fitted, capsys):
    fitted.answer[0] = an_answer("refused", radius_m=float("nan"))
    assert main(["fit", fitted.photo, "--json", "-"]) == 3
    answer = json.loads(capsys.readouterr().out)
    assert list(answer) == KEYS
    assert answer["radius_m"] is None


def test_the_folder_gets_picture_report_and_answer_once(fitted, tmp_path, capsys):
    folder = tmp_path / "new" / "results"
    arguments = ["fit", fitted.photo, "--output-dir", str(folder)]
    assert main(arguments) == 0
    assert sorted(path.name for path in folder.iterdir()) == ["report.txt", "result.json", "result.png"]
    assert "--force" in refusal(capsys_cleared(capsys), *arguments)
    assert len(fitted.calls) == 1  # refused before the fit
    assert main([*arguments, "--force"]) == 0


def test_the_answer_never_replaces_the_photograph(fitted, capsys):
    said = refusal(capsys, "fit", fitted.photo, "--json", fitted.photo, "--force")
    assert "is what the command reads" in said


def test_unreadable_input_ends_with_two(fitted, capsys, monkeypatch):
    def unreadable(*_, **__):
        raise ValueError("photo.png is\nno image")

    monkeypatch.setattr(fitting, "fit", unreadable)
    assert "photo.png is no image" in refusal(capsys, "fit", fitted.photo)


# The session: JAX's configuration and the progress line


def test_compiled_code_is_kept_in_the_folder_that_the_user_names(tmp_path):
    program = (
        "from fitting import session; session.prepare(); import jax; c = jax.config; "
        "print(c.jax_enable_x64, c.jax_compilation_cache_dir, c.jax_persistent_cache_min_compile_time_secs)"
    )
    bare = {name: value for name, value in os.environ.items() if not name.startswith("JAX_")}
    bare["XDG_CACHE_HOME"] = bare["HOME"] = str(tmp_path)
    for folder in (None, str(tmp_path / "named")):
        environment = bare if folder is None else {**bare, "JAX_COMPILATION_CACHE_DIR": folder}
        done = subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment
        )
        x64, used, threshold = done.stdout.split()
        assert (x64, float(threshold)) == ("True", 0.0)
        assert used == folder if folder else used.startswith(str(tmp_path))


def test_the_progress_line_says_when_it_compiles(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    seen = []
    with progress._compilation(lambda: seen.append("begun"), lambda: seen.append("ended")):
        jax.block_until_ready(jax.jit(lambda x: x * 3 + 1.25)(np.arange(7.0)))
    assert seen[0] == "begun"
    assert seen[-1] == "ended"
    with progress.progress("working"):
        pass
    assert capsys.readouterr().out == ""


def test_without_a_terminal_there_is_no_progress_line(monkeypatch, capsys):
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    with progress.progress("working"):
        pass
    assert capsys.readouterr() == ("", "")


def test_the_picture_is_a_png(monkeypatch):
    plot = SimpleNamespace(result_figure=lambda _: Figure(figsize=(1, 1)))
    monkeypatch.setitem(sys.modules, "fitting.plot", plot)
    assert fit_verb._picture(None).startswith(b"\x89PNG")


def test_preparing_twice_is_harmless():
    session.prepare()
    session.prepare()
    assert jax.config.jax_enable_x64


# Together


def test_the_demo_finds_the_radius_that_its_sample_was_made_with(tmp_path, capsys):
    folder = tmp_path / "demo"
    assert main(["demo", "--output-dir", str(folder)]) == 0
    assert "true radius: 0.8462 m" in capsys.readouterr().out
    answer = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    assert set(KEYS) <= set(answer)
    assert abs(answer["radius_m"] - 0.8462) < 3 * answer["radius_sd_m"]
    assert answer["radius_sd_m"] < 0.005
    assert imageio.imread(folder / "result.png").shape[0] > 300


def test_straight_fringes_are_refused_with_three(shared, capsys):
    assert main(["fit", str(shared / "photos" / "wedge_straight_fringes.jpg"), "--json", "-"]) == 3
    printed = capsys.readouterr()
    answer = json.loads(printed.out)
    assert (answer["status"], answer["radius_m"]) == ("refused", None)
    assert "straight" in printed.err
    assert printed.err.count("\n") == 1
