"""Claim: ring tables in the forms that people keep are read right, or refused with columns that would do.

Made spreadsheets (`sheet_forms.py`): the radius of the lens of 1 m is found within four standard deviations from as
many readings as there are, or the table is refused and, where its columns are the reason, with names of columns that
read it. "Before" is the verdict of the version before tables were read by layout (`results/sheets.json` keeps it).

    python -m experiments.truth.sheets [--quick] [--before]
"""

import argparse
import json
import tempfile
from pathlib import Path

import fitting
from experiments import records
from experiments.truth.sheet_forms import FORMS, RADIUS, WAVELENGTH, Form


def verdict(form: Form, folder: Path) -> str:
    """What becomes of a form: "read", "wrong: ...", "refused: ...", or "refused, columns that would do are named"."""
    table: str | Path = folder / f"table{form.suffix}"
    if form.suffix:
        Path(table).write_bytes(form.content)
    else:
        table = form.content.decode()
    options = dict(form.options)
    try:
        result = fitting.rings(table, wavelength=WAVELENGTH, **options)
    except (ValueError, OSError) as error:
        named = getattr(error, "suggestion", None)
        return "refused, columns that would do are named" if named else f"refused: {str(error).splitlines()[0][-160:]}"
    except TypeError:  # before, arguments that there were not
        return "refused: no such argument"
    if result.radius is None or abs(result.radius - RADIUS) > max(4 * (result.radius_sd or 0.0), 1e-6):
        return f"wrong: R = {result.radius}"
    if form.readings and len(result.rings) != form.readings:
        return f"wrong: {len(result.rings)} readings"
    return "read"


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
        now = {form.name: verdict(form, Path(folder)) for form in FORMS}
    before = now if options.before else before
    rows = [
        {"form": form.name, "before": before.get(form.name, ""), "now": now[form.name]} for form in FORMS
    ]  # fmt: skip
    counts = {when: sum(is_right(form, row[when]) for form, row in zip(FORMS, rows, strict=True))
              for when in ("before", "now")}  # fmt: skip
    for row in rows:
        print(f"{row['form']:34} {row['before'][:50]:50} {row['now'][:70]}")
    print(f"right: {counts['now']} of {len(FORMS)}, before {counts['before']}")
    if not options.quick:
        records.save("sheets", {"forms": len(FORMS), "right": counts, "rows": rows})
    wrong = [form.name for form in FORMS if not is_right(form, now[form.name])]
    if wrong and not options.before:
        raise SystemExit(f"not right: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
