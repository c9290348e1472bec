"""The command: wrong usage, pictures, answers, exit statuses and what it asks of JAX."""

import contextlib
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
from shell import refusal

import fitting
import newtonjax as nj
from fitting.shell import progress, session
from fitting.shell.argument_words import in_words_of_shell
from fitting.shell.cli import app, main

KEYS = [
    *("status", "message", "radius_m", "radius_sd_m", "radius_interval_m", "radius_sd_noise_m", "fringe_scale_per_px2"),
    *("centre_px", "gap_m", "contact_radius_m", "explained_variance", "budget", "warnings", "model", "seconds"),
]


# Usage


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "no verb given"),
        (("measure",), "No such command 'measure'; `newtonjax --help` lists what is allowed"),
        (("fit",), "Missing argument 'PHOTO'; `newtonjax fit --help` lists what is allowed"),
        (("fit", "none.png", "--pixelsize", "1um"), "Possible options: --pixel-size"),
        (("fit", "none.png"), "none.png is not a file"),
        (("fit", os.path.dirname(__file__)), "is a folder, whose photographs newtonjax batch measures"),
        (("fit", "none.png", "--wavelength", "589.3"), "has no unit"),
        (("fit", "none.png", "--pixel-size", "0um"), "not above zero"),
        (("fit", "none.png", "--pixel-size-sd", "nan um"), "is no length"),
        (("fit", "none.png", "--transfer", "cubic"), "linear, srgb, or an exponent"),
        (("fit", "none.png", "--view", "sideways"), "Invalid value for '--view': 'sideways' is not one of"),
        (("fit", "none.png", "--scale-from", "none.json"), "none.png is not a file"),
        (("fit", __file__, "--scale-from", "none.json"), "none.json is not a file"),
        (("fit", __file__, "--scale-from", __file__), "is no JSON"),
        (("fit", __file__, "--mask", "none.png"), "give the path of a mask"),
        (("scale", "none.png"), "--division"),
        (("scale", "none.png", "--division", "0.2mm"), "none.png is not a file"),
        (("scale", __file__, "--division", "0.2"), "has no unit"),
        (("scale", __file__, "--division", "0.2mm"), "cannot be read as an image"),
        (("render", "reflected"), "--output"),
        (("render", "reflected", "--output", "a.jpg"), "ends in .png"),
        (("render", "reflected", "--output", "no/such/a.png"), "no/such is not a folder"),
        (("render", "sideways", "--output", "a.png"), "transmitted, reflected, wedge"),
        (("render", "none.toml", "--output", "a.png"), "none.toml is not a file"),
        (("render", "none.toml", "--output", "a.png", "--radius", "1m"), "the file gives the scene"),
        (("render", "wedge", "--output", "a.png", "--radius", "1m"), "it has --wedge-angle, --wavelength, --gap"),
        (
            ("render", "reflected", "--output", "a.png", "--wedge-angle", "1mrad"),
            "it has --radius, --wavelength, --gap",
        ),
        (("render", "reflected", "--output", "a.png", "--radius", "0m"), "non-zero radius"),
        (("render", "reflected", "--output", "a.png", "--shape", "1024"), "ROWSxCOLUMNS"),
        (("render", "reflected", "--output", "a.png", "--tolerance", "0"), "tolerance is 0.0"),
        (
            ("render", "reflected", "--output", "a.png", "--screen", "1mm", "--method", "closed-form"),
            "focused on the gap",
        ),
        (("render", "reflected", "--output", "a.png", "--method", "traced", "--nodes", "5"), "--nodes"),
        (("render", "reflected", "--output", "a.png", "--method", "traced", "--epsilon", "5um"), "--epsilon"),
        (("render", "reflected", "--output", "a.png", "--beams", "R1,R7"), "beam 'R7' is unknown"),
        (("render", "reflected", "--output", "a.png", "--beams", "R1,"), "beam '' is unknown"),
        (("render", "reflected", "--output", "a.png", "--beams", "R1", "--method", "splat"), "a scene of one beam"),
        (
            ("render", "reflected", "--output", "a.png", "--screen", "1mm", "--collecting-lens", "1m"),
            "a quarter of the way",
        ),
        (("render", "transmitted", "--output", "a.png", "--beams", "R1,R2"), "leave on the other side"),
        (
            ("render", "reflected", "--output", "a.png", "--method", "splat", "--tolerance", "1e-3"),
            "only the phase error",
        ),
        (
            ("render", "reflected", "-o", "a.png", "--radius", "1mm", "--screen", "gap", "--method", "closed-form"),
            "does not reach the whole image",
        ),
        (
            ("render", "reflected", "-o", "a.png", "--screen", "1m", "--collecting-lens", "1mm"),
            "--collecting-lens stands",
        ),
    ],
)
def test_wrong_usage_is_refused_in_one_line(capsys, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert said in refusal(capsys, *arguments)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("verb", "of_library", "of_shell"),
    [
        ("fit", "axis_px_sd is given without axis_px; give both", "--axis-sd is given without --axis; give both"),
        (
            "fit",
            "scale is 3; allowed: a result of fitting.scale",
            "--scale-from is 3; allowed: a result of newtonjax scale",
        ),
        (
            "fit",
            "'radii' is none; allowed: radius, pixel_size, gap",
            "'radii' is none; allowed: radius, pixel_size, gap",
        ),
        ("fit", "list.csv, line 2: pixel_size is 'x'", "list.csv, line 2: pixel_size is 'x'"),
        ("render", "lens_tilt is 2 radians; allowed: 0.8", "--lens-tilt is 2 radians; allowed: 0.8"),
        ("render", "bench.toml: lens_tilt is 2", "bench.toml: lens_tilt is 2"),
        ("no verb", "lens_tilt is 2", "lens_tilt is 2"),
    ],
)
def test_errors_of_the_library_name_options(verb, of_library, of_shell):
    assert in_words_of_shell(of_library, app, verb) == of_shell


def test_version_is_the_packages(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"newtonjax {nj.__version__}\n"


@pytest.mark.parametrize("verb", ["render", "fit", "demo"])
def test_each_verb_explains_itself(capsys, verb):
    assert main([verb, "--help"]) == 0
    assert "--force" in capsys.readouterr().out


def test_help_cuts_no_word_at_80_columns(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    verbs = [command.name or command.callback.__name__ for command in app.registered_commands]
    assert {"render", "fit", "wedge"} <= set(verbs)
    for verb in verbs:
        assert main([verb, "--help"]) == 0
        lines = capsys.readouterr().out.splitlines()
        assert [line for line in lines if "…" in line] == []


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
        measured="radius",
        parameters={},
        warnings=[],
        budget=[],
        model={},
        rings=[],
        evidence=None,
        origin=None,
        budgets=dict,
        dominant=str,
        unstated=str,
        alternatives=list,
        to_dict=lambda: answer,
        figure=lambda: Figure(figsize=(1, 1)),
        report=lambda: f"radius {answer['radius_m']}",
        headline=lambda: status,
    )


@pytest.fixture
def fitted(monkeypatch, tmp_path):
    """Replace the fit; the list of (photo, arguments) that it was called with, its answer, and a photo."""
    calls, answer = [], [an_answer()]

    def fit(photo, **arguments):
        calls.append((photo, arguments))
        return answer[0]

    monkeypatch.setattr(fitting, "fit", fit, raising=False)
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
        "view": None,
        "transfer": 2.2,
    }


def test_a_percentage_of_a_length_reaches_the_fit(fitted):
    options = "--wavelength 589nm --wavelength-sd 0.1% --pixel-size-sd 2%"
    assert main(["fit", fitted.photo, *options.split()]) == 0
    (_, arguments) = fitted.calls[0]
    assert (arguments["wavelength_sd"], arguments["pixel_size_sd"]) == ("0.1%", "2%")


def test_a_scene_file_gives_what_was_not_given(fitted, tmp_path, capsys):
    scene = tmp_path / "scene.toml"
    bench = nj.newton_rings(2.0, 500e-9, ambient_index=1.00027, view="transmitted", screen=1e-3)
    nj.save_scene(scene, bench, nj.Camera((48, 64), 5e-6))
    assert main(["fit", fitted.photo, "--scene", str(scene)]) == 0
    assert main(["fit", fitted.photo, "--scene", str(scene), "--wavelength", "sodium-d2"]) == 0
    first, second = (arguments for _, arguments in fitted.calls)
    assert (first["wavelength"], first["pixel_size"], first["view"]) == (500e-9, 5e-6, "transmitted")
    assert first["scene"].beams == bench.beams
    assert second["wavelength"] == pytest.approx(589.1583e-9, rel=5e-6)
    assert "leave --view out" in refusal(capsys, "fit", fitted.photo, "--scene", scene, "--view", "reflected")


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
    found = sorted(path.name for path in folder.iterdir())
    assert found == ["report.html", "report.txt", "result.json", "result.png"]
    assert "--force" in refusal(capsys, *arguments)
    assert len(fitted.calls) == 1  # refused before the fit
    assert main([*arguments, "--force"]) == 0


def test_files_are_written_though_whoever_reads_the_text_is_gone(fitted, tmp_path, monkeypatch):
    """As `newtonjax fit ... | head -1` may leave it."""

    def gone(_):
        raise BrokenPipeError

    with monkeypatch.context() as patch, contextlib.suppress(BrokenPipeError, SystemExit):
        patch.setattr(sys, "stdout", SimpleNamespace(write=gone, flush=lambda: None, isatty=lambda: False))
        main(["fit", fitted.photo, "--output-dir", str(tmp_path / "results")])
    assert sum(1 for _ in (tmp_path / "results").iterdir()) == 4


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
        "from fitting.shell import session; session.prepare(); import jax; c = jax.config; "
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


@pytest.mark.parametrize(("command", "words"), [(["doctor"], "starting JAX"), (["rings", "readings.csv"], "drawing")])
def test_a_verb_says_what_it_does_where_it_may_take_seconds(monkeypatch, tmp_path, capsys, command, words):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    monkeypatch.chdir(tmp_path)
    rows = "".join(f"{m},{2e3 * (m * 589.3e-9) ** 0.5:.4f}\n" for m in range(1, 8))
    (tmp_path / "readings.csv").write_text(f"order,diameter_mm\n{rows}", encoding="utf-8")
    options = ["--wavelength", "sodium", "--output-dir", "answer"] if command[0] == "rings" else []
    assert main([*command, *options]) == 0
    assert words in capsys.readouterr().err


def test_without_a_terminal_there_is_no_progress_line(monkeypatch, capsys):
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    with progress.progress("working"):
        pass
    assert capsys.readouterr() == ("", "")


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


def test_every_part_of_the_model_has_an_option_and_only_those_given_are_wishes(tmp_path, monkeypatch):
    from fitting.model import PARTS
    from fitting.parameters import PART_OPTIONS
    from fitting.shell import fit_verb

    asked = []
    monkeypatch.setattr(fit_verb, "run", lambda _photo, options, _: asked.append(options.parts) or 0)
    assert set(PART_OPTIONS) == set(PARTS)
    assert main(["fit", str(tmp_path / "rings.png"), "--no-oblique-view", "--contact"]) == 0
    assert main(["fit", str(tmp_path / "rings.png")]) == 0
    assert asked == [{"oblique_view": False, "contact": True}, {}]


def test_standard_deviations_of_index_and_angle_may_be_percentages(tmp_path, capsys):
    table = tmp_path / "rings.csv"
    table.write_text("order,radius_mm\n1,1.0\n2,1.4142\n3,1.7321\n4,2.0\n5,2.2361\n")
    given = ["rings", str(table), "--wavelength", "589.3nm", "--view-angle", "20deg", "--json", "-"]
    budgets = []
    for sds in (("1%", "1%"), ("0.01", "0.2deg")):
        assert main([*given, "--gap-index-sd", sds[0], "--view-angle-sd", sds[1]]) == 0
        budgets.append({row["source"]: row["sd_m"] for row in json.loads(capsys.readouterr().out)["budget"]})
    assert budgets[0] == pytest.approx(budgets[1], rel=1e-12)
    assert budgets[0]["gap_index"] > 0
    assert budgets[0]["view_angle"] > 0
