"""Claim: no file that a person may keep ends `rings` with an error from inside, and 10 000 rows take no second.

Random files by hypothesis: headers of words and signs that tables have and others, cells with numbers in many forms,
text, gaps and errors, ragged rows, quotes, title lines, separators, encodings, bytes at random. Each is measured, or
refused by a ValueError.

    python -m experiments.truth.random_sheets [--files 20000] [--quick]
"""

import argparse
import tempfile
import traceback
from collections import Counter
from pathlib import Path
from time import process_time

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

import fitting
from experiments import records

_TEXT = """order n m k D d r R D² D^2 diameter radius left right L x1 x2 position sigma error ± MSR VSR mean mm cm µm px
m (mm) [mm] /mm № Ø 级数 直径/mm порядок диаметр, Durchmesser Ordnung series run # ring Ring number of 1 2 in LC =
0.01"""
_WORDS = st.sampled_from(_TEXT.split())
_HEADERS = st.one_of(st.lists(_WORDS, min_size=1, max_size=3).map(" ".join), st.text(max_size=6))
_NUMBERS = st.one_of(
    st.integers(-3, 40).map(str),
    st.floats(-10, 1e4, allow_nan=False).map(lambda x: f"{x:.3f}"),
    st.floats(0, 60).map(lambda x: f"{x:.2f}".replace(".", ",")),
    st.floats().map(str),
    st.floats(0, 9).map(lambda x: f"{x:.2f} mm"),
    st.floats(0, 9).map(lambda x: f"{x:.2f} ± 0.01"),
    st.sampled_from(["1,234.5", "1.234,5", "−3,2", "3.45(2)", "1e308", "1e400", "7th", "Ring 3", "0", "1_000", "0x1A"]),
)
_CELLS = st.one_of(
    _NUMBERS, _NUMBERS, _NUMBERS, st.sampled_from(["", "-", "#VALUE!", "n/a", "mean", '"', "x", "²", "nan", "inf"]),
    st.text(max_size=5),
)  # fmt: skip
_ENCODINGS = st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252", "cp1251", "gbk"])


@st.composite
def _tables(draw) -> bytes:
    separator = draw(st.sampled_from([",", ";", "\t", " ", "|", " & "]))
    width = draw(st.integers(1, 5))
    lines = draw(st.lists(st.text(max_size=20), max_size=2))
    lines.append(separator.join(draw(st.lists(_HEADERS, min_size=width, max_size=width))))
    lines += [
        separator.join(row) for row in draw(st.lists(st.lists(_CELLS, min_size=width, max_size=width), max_size=8))
    ]
    lines += [separator.join(row) for row in draw(st.lists(st.lists(_CELLS, max_size=7), max_size=2))]
    return draw(st.sampled_from(["\n", "\r\n", "\r"])).join(lines).encode(draw(_ENCODINGS), errors="replace")


@st.composite
def _likely(draw) -> bytes:
    """Tables that are nearly right."""
    separator = draw(st.sampled_from([",", ";", "\t"]))
    header = draw(st.sampled_from(["n{}D (mm)", "order{}diameter_mm", "m{}r/cm", "№{}диаметр, мм", "k{}D² (mm²)"]))
    first = draw(st.integers(1, 9))
    sizes = [f"{1.5 * k**0.5:.3f}" for k in range(first, first + draw(st.integers(2, 20)))]
    for place, cell in draw(st.lists(st.tuples(st.integers(0, 19), _CELLS), max_size=2)):
        sizes[place % len(sizes)] = cell
    rows = [f"{k}{separator}{size}" for k, size in enumerate(sizes, first)]
    return "\n".join([header.format(separator), *rows]).encode()


@st.composite
def _pages(draw) -> bytes:
    """Tables of pages, text processors and programs, whole and cut off."""
    pattern, between, before, after = draw(st.sampled_from([
        ("<tr><td{0}>{1}</td></tr>", "</td><td>", "<table><tr><th>n<th>D (mm)", "</table>"),
        ("{1} \\\\", " & ", "\\begin{tabular}{cc} n & D (\\si{\\mm}) \\\\ \\hline", "\\end{tabular}"),
        ("|-\n| {1}", " || ", "{|\n! n !! D (mm)", "|}"),
        ("[{1}],", ", ", "[[\"n\", \"D (mm)\"],", "[]]"),
        ("║ {1} ║", " ║ ", "║ n ║ D (mm) ║\n╠═══╬═══╣", "╚═══╝"),
    ]))  # fmt: skip
    span = draw(st.sampled_from(["", "", " colspan=2", " colspan=x", " rowspan=9"]))
    rows = draw(st.lists(st.lists(_CELLS, min_size=1, max_size=3), max_size=6))
    lines = [before, *(pattern.format(span, between.join(row)) for row in rows), after]
    content = "\n".join(lines).encode()
    return content[: draw(st.integers(0, len(content)))] if draw(st.booleans()) else content


@st.composite
def _long_form(draw) -> bytes:
    """A row for each side of a ring."""
    rows = draw(st.lists(st.tuples(_CELLS, st.sampled_from(["left", "right", "L", "R", ""]), _CELLS), max_size=9))
    return "\n".join(["n;side;x (mm)", *(";".join(row) for row in rows)]).encode()


SHEETS = st.one_of(_tables(), _likely(), _pages(), _long_form(), st.binary(max_size=60))


def main() -> None:
    """Try the files, time a long one, print and write the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=20_000)
    parser.add_argument("--quick", action="store_true", help="2000 files, nothing written")
    options = parser.parse_args()
    count = 2000 if options.quick else options.files
    outcomes, failures = Counter(), []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv"
        _seconds(path, 100)
        seconds = {rows: _seconds(path, rows) for rows in (10_000, 100_000)}

        @seed(26)
        @settings(max_examples=count, deadline=None, database=None, phases=[Phase.generate],
                  suppress_health_check=list(HealthCheck))  # fmt: skip
        @given(SHEETS)
        def each(content: bytes) -> None:
            path.write_bytes(content)
            try:
                outcomes[fitting.rings(path, wavelength=589.3e-9).status] += 1
            except ValueError:
                outcomes["not understood"] += 1
            except Exception:
                outcomes["error from inside"] += 1
                failures.append((content, traceback.format_exc()))

        each()
    for content, text in failures[:3]:
        print(content, text, sep="\n")
    record = {"files": outcomes.total(), "outcomes": dict(outcomes), "processor seconds by rows": seconds}
    print(record)
    if not options.quick:
        records.save("random_sheets", record)
    if failures:
        raise SystemExit(f"{len(failures)} files ended in an error from inside")
    if seconds[10_000] > 1:
        raise SystemExit(f"10 000 rows took {seconds[10_000]:.2g} s")


def _seconds(path: Path, rows: int) -> float:
    """Processor seconds of a table of so many readings, in five columns."""
    rng = np.random.default_rng(26)
    order = rng.integers(1, 40, rows)
    sizes = 2e3 * np.sqrt(order * 589.3e-9) + 0.003 * rng.normal(size=rows)
    lines = [f"{m};{size:.3f};{25 - size / 2:.3f};{25 + size / 2:.3f};a".replace(".", ",") for m, size in
             zip(order, sizes, strict=True)]  # fmt: skip
    path.write_text("\n".join(["Ordnung;D (mm);links (mm);rechts (mm);wer", *lines]), encoding="utf-8")
    began = process_time()
    fitting.rings(path, wavelength=589.3e-9)
    return process_time() - began


if __name__ == "__main__":
    main()
