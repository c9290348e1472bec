"""The command `newtonjax`: its verbs and their options. What is heavy is imported inside the verbs."""

import gc
import io
import os
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from typer.main import get_command

from fitting.parameters import output
from fitting.shell import stopping
from fitting.shell.app_command import app as page
from fitting.shell.argument_words import in_words_of_shell
from fitting.shell.batch_command import batch
from fitting.shell.bench_options import with_bench_options
from fitting.shell.form_command import form
from fitting.shell.measuring_verbs import compare, fit, rings, scale
from fitting.shell.options import Bits, Epsilon, Force, ScreenPixel, Shape, before_a_verb
from fitting.shell.study_verbs import design, sensitivity, tradeoff
from fitting.shell.testplate_command import plate
from fitting.shell.together_command import together
from fitting.shell.wedge_command import wedge
from fitting.studies import exit_status

app = typer.Typer(
    name="newtonjax",
    help="Newton's rings: render them, and measure a lens radius from a photograph of them.",
    epilog="Quantities carry their unit (589.3nm, 12.75um, 2m). Exit status: 0 done, 1 something is amiss (doctor, "
    "selftest), 2 wrong usage or unreadable input, 3 refused (no rings, straight fringes, undetermined: the reason "
    "without a report), 4 not converged (the report shows how far the fit came).",
)
# What a shell sets where it asks for the words that may follow, and no arguments.
_ASKED_BY_SHELL = "_NEWTONJAX_COMPLETE"


def main(arguments: list[str] | None = None) -> int:
    """Run the command; its exit status. Errors go to stderr in one line."""
    arguments = sys.argv[1:] if arguments is None else arguments
    # Importing and tracing make hundreds of thousands of objects that stay: looking through them for cycles at the
    # usual intervals takes as long as importing JAX.
    gc.set_threshold(200_000, 20, 20)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a λ must not cost the answer where the terminal has none
    if not arguments and _ASKED_BY_SHELL not in os.environ:
        return _fail("no verb given; give render, fit, scale, rings or another one (newtonjax --help explains them)")
    separated = _one_by_one(arguments)
    try:
        with stopping.watched():
            return app(args=separated, prog_name="newtonjax", standalone_mode=False) or 0
    except typer.TyperException as error:
        return _fail(_with_help(error.format_message(), separated))
    except (ValueError, OSError) as error:
        return _fail(_with_advice(error, arguments), exit_status(error))
    except typer.Abort:
        return 130
    except SystemExit as ending:  # Typer's, after an answer to the shell
        return int(ending.code or 0)


def _with_help(message: str, arguments: list[str]) -> str:
    """What is wrong with the words of a command, and which command lists those that it takes."""
    message = message.replace(": Value error, ", ": ").rstrip(".")
    if message.endswith("?"):  # it makes a proposal
        return message
    verbs = getattr(get_command(app), "commands", {})
    command = " ".join(["newtonjax", *(word for word in arguments[:1] if word in verbs)])
    return f"{message}; `{command} --help` lists what is allowed"


def _with_advice(error: Exception, arguments: list[str]) -> str:
    """An error's text with the command's names; of a table that is not understood with the command that reads it."""
    columns = getattr(error, "suggestion", None)
    if not columns:
        return in_words_of_shell(str(error), app, arguments[0])
    from fitting.shell.rings_verb import command_with

    command = command_with(columns, arguments)
    return f"{getattr(error, 'lack', '')}; this command reads it, if it names the columns rightly: {command}"


def _one_by_one(arguments: list[str]) -> list[str]:
    """`--vary a=1 b=2` as `--vary a=1 --vary b=2`: of the options that take NAME=VALUE."""
    separated, option = [], ""
    for argument in arguments:
        if argument.startswith("-"):
            option = argument if argument in ("--vary", "--sd", "--choose", "--prior") else ""
        elif option and "=" in argument and separated[-1] != option:
            separated.append(option)
        separated.append(argument)
    return separated


def _fail(message: str, status: int = 2) -> int:
    output.remove_empty_folders()
    print("newtonjax:", " ".join(message.split()), file=sys.stderr)
    return status


@app.command()
@with_bench_options
def render(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="transmitted, reflected, wedge, or a file SCENE.toml.")],
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", help="PNG to write; or TIFF (.tif), which may be larger than memory."
        ),
    ],
    shape: Shape = None,
    pixel_size: ScreenPixel = None,
    method: Annotated[
        Literal["closed-form", "chebyshev", "traced", "splat"] | None,
        typer.Option(help="Method; by default the cheapest one that meets the tolerance."),
    ] = None,
    nodes: Annotated[int | None, typer.Option(min=2, max=129, help="Nodes to a side, for chebyshev.")] = None,
    epsilon: Epsilon = None,
    tolerance: Annotated[
        float | None,
        typer.Option(help="Largest error of intensity over the peak.", show_default="0.001 without a method"),
    ] = None,
    expose: Annotated[
        bool, typer.Option("--expose", help="Add shot and read noise: a photograph of the image.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, max=2**63 - 1, help="Seed of the noise.")] = 0,
    bits: Bits = None,
    colour: Annotated[
        bool, typer.Option("--colour", help="In the colours that an eye sees (CIE 1931), as 8-bit sRGB.")
    ] = False,
    explain: Annotated[
        bool,
        typer.Option(
            "--explain", help="Also print what is modelled, what is not, and by how much that changes the image."
        ),
    ] = False,
    force: Force = False,
    **bench: Any,
) -> int:
    """Render an image of Newton's rings, of an air wedge or of a scene file.

    Says which method was used, with how many nodes, and the estimated error.
    """
    from fitting.shell import render_verb

    how = render_verb.How(method, nodes, epsilon, tolerance)
    noise = seed if expose else None
    named = {name: value for name, value in bench.items() if value is not None}
    what = render_verb.Request(scene, output, named, shape, pixel_size, how, noise, bits, colour, explain, force)
    return render_verb.run(what)


app.callback()(before_a_verb)
app.command("app")(page)
app.command("testplate")(plate)
for measuring in (fit, batch, together, form, scale, rings, wedge, compare):
    app.command()(measuring)
for study in (tradeoff, sensitivity, design):
    app.command()(study)


@app.command()
def demo(
    output_dir: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder for the results.")] = Path(
        "newtonjax-demo"
    ),
    force: Force = False,
) -> int:
    """Fit the sample photograph that comes along, and show the true radius beside the answer."""
    from fitting.shell import fit_verb

    return fit_verb.demo(output_dir, force)


@app.command()
def doctor(
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> int:
    """Say what is installed, which devices and caches are used, and what to do about what is amiss.

    Exit status: 0 nothing is amiss, 1 something is. Missing extras are not amiss.
    """
    from fitting.shell import doctor_verb

    return doctor_verb.run(json)


@app.command()
def selftest(
    seed: Annotated[int, typer.Option(min=0, max=2**63 - 1, help="Seed of the photographs and tables.")] = 0,
    output_dir: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Folder for selftest.csv and selftest.json.")
    ] = None,
    force: Force = False,
) -> int:
    """Measure made photographs and tables of rings here: bias, scatter, coverage and speed, in less than a minute.

    The table, as CSV and JSON with version, date and kind of machine, is for a quality
    file. Exit status: 0 all limits are kept, 1 one is missed, which chance alone does in
    0.06 % of seeds.
    """
    from fitting.shell import selftest_verb

    return selftest_verb.run(seed, output_dir, force)
