"""Claim: ring tables in the forms that people keep are read right, or refused with a command that reads them right.

Made spreadsheets (`sheet_forms`, `further_sheets`, `hostile_sheets`): the radius of the lens of 1 m is found within
four standard deviations from as many readings as there are; or the table is refused. A command that the refusal ends
with is run as it stands, and has to find that radius. "Before" is the verdict of the version before tables were read by
layout (`results/sheets.json` keeps it).

    python -m experiments.truth.sheets [--quick] [--before]
"""

import argparse
import contextlib
import io
import json
import shlex
import tempfile
from pathlib import Path

import fitting
from experiments import records
from experiments.truth.further_sheets import FURTHER
from experiments.truth.hostile_sheets import HOSTILE
from experiments.truth.sheet_forms import FORMS, RADIUS, WAVELENGTH, Form

EVERY = (*FORMS, *FURTHER, *HOSTILE)
WITH_COMMAND = "refused with a command that works"


def verdict(form: Form, folder: Path) -> str:
    """What becomes of a form: "read", "wrong: ...", "refused: ...", or `WITH_COMMAND`."""
    path = folder / f"table{form.suffix}"
    path.write_bytes(form.content)
    table = path if form.suffix else form.content.decode()
    options = dict(form.options)
    try:
        result = fitting.rings(table, wavelength=WAVELENGTH, **options)
    except (ValueError, OSError) as error:
        if not getattr(error, "suggestion", None):
            return f"refused: {str(error).splitlines()[0].replace(str(path), form.name)[-160:]}"
        return WITH_COMMAND if form.options else _of_command(path)
    except TypeError:  # before, arguments that there were not
        return "refused: no such argument"
    if result.radius is None or abs(result.radius - RADIUS) > max(4 * (result.radius_sd or 0.0), 1e-6):
        return f"wrong: R = {result.radius}"
    if form.readings and len(result.rings) != form.readings:
        return f"wrong: {len(result.rings)} readings"
    return "read"


def _of_command(path: Path) -> str:
    """What the command finds with which a refusal of the shell ends."""
    from fitting.shell.cli import main

    wavelength = f"{WAVELENGTH * 1e9:g}nm"
    with contextlib.redirect_stderr(io.StringIO()) as stderr:
        main(["rings", str(path), "--wavelength", wavelength])
    command = stderr.getvalue().partition("rightly: ")[2]
    with contextlib.redirect_stdout(io.StringIO()) as stdout:
        status = main([*shlex.split(command)[1:], "--json", "-"])
    if status:
        return f"wrong: the command ends with {status}"
    radius = json.loads(stdout.getvalue())["radius_m"]
    return WITH_COMMAND if abs(radius - RADIUS) < 0.02 * RADIUS else f"wrong: the command finds {radius:.4g} m"


def is_right(form: Form, outcome: str) -> bool:
    """Whether a table was read that can be, or refused that cannot."""
    return outcome == "read" if form.readings else outcome.startswith("refused")


def main() -> None:
    """Try each form, print the table, write it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="nothing written")
    parser.add_argument("--before", action="store_true", help="write the verdicts as those before")
    options = parser.parse_args()
    path = records.RESULTS / "sheets.json"
    rows = json.loads(path.read_text(encoding="utf-8"))["rows"] if path.is_file() else []
    before = {row["form"]: row["before"] for row in rows}
    with tempfile.TemporaryDirectory() as folder:
        now = {form.name: verdict(form, Path(folder)) for form in EVERY}
    before = now | before if options.before else before
    rows = [
        {"form": form.name, "before": before.get(form.name, ""), "now": now[form.name]} for form in EVERY
    ]  # fmt: skip
    counts = {when: sum(is_right(form, row[when]) for form, row in zip(EVERY, rows, strict=True))
              for when in ("before", "now")}  # fmt: skip
    for row in rows:
        print(f"{row['form']:46} {row['before'][:50]:50} {row['now'][:70]}")
    print(f"right: {counts['now']} of {len(EVERY)}, before {counts['before']}")
    if not options.quick:
        records.save("sheets", {"forms": len(EVERY), "right": counts, "rows": rows})
    wrong = [form.name for form in EVERY if not is_right(form, now[form.name])]
    if wrong and not options.before:
        raise SystemExit(f"not right: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
