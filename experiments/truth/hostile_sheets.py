"""More made spreadsheets that nobody had tried: hostile layouts, signs, workbooks, pages copied from programs."""

from collections.abc import Iterator, Sequence

from experiments.truth.sheet_forms import DIAMETERS, LEFTS, ORDERS, RIGHTS, Form, comma, ods, text
from experiments.truth.workbooks import xlsx_of_sheets

_SIDES = list(zip(ORDERS, LEFTS, RIGHTS, strict=True))
_PLAIN = list(zip(ORDERS, DIAMETERS, strict=True))
_ARABIC = str.maketrans("0123456789.", "٠١٢٣٤٥٦٧٨٩٫")
_FULL_WIDTH = str.maketrans("0123456789.", "０１２３４５６７８９．")


def _of_headers() -> Iterator[Form]:
    three = [
        ("", "Microscope readings (mm)", "", ""),
        ("Ring", "Left", "Right", "D"),
        *((n, left, right, size) for (n, left, right), size in zip(_SIDES, DIAMETERS, strict=True)),
    ]
    yield Form("a merged header above sides", text("", three)[1:].encode())
    deep = [("", "", "Reading"), ("No.", "D", "remarks"), ("", "mm", ""), *((n, size, "") for n, size in _PLAIN)]
    yield Form("a merged header and a row of units", text("", deep)[1:].encode())
    columns = [("n", "D", "u(D)"), ("1", "mm", "µm"), *((n, size, 5) for n, size in _PLAIN)]
    yield Form("deviations in another unit than sizes", text("", columns)[1:].encode())
    far = [(n, "", left, "", right) for n, left, right in _SIDES]
    yield Form("empty columns between the sides", text("n,,Left (mm),,Right (mm)", far).encode())
    apart = [(left, n, "blue", right) for n, left, right in _SIDES]
    yield Form("the order between the sides", text("x left [mm],ring,lamp,x right [mm]", apart).encode())
    turned = [(n, right, left) for n, left, right in _SIDES]
    yield Form("the right side first", text("n,right edge (mm),left edge (mm)", turned).encode())
    yield Form("a percent column", text("n,D (mm),error (%)", [(n, size, "0.5%") for n, size in _PLAIN]).encode())
    percent = [(n, size, 0.5) for n, size in _PLAIN]
    yield Form("relative deviations", text("n,D (mm),ΔD/D (%)", percent).encode())
    lens = [(n, size, round(size / 2, 4), 589.3, 1.0) for n, size in _PLAIN]
    yield Form("wavelength and radius beside", text("n,D (mm),r (mm),λ (nm),R (m)", lens).encode())
    numbered = [(k, n, size) for k, (n, size) in enumerate(_PLAIN)]
    yield Form("a column without a name for rows", text(",order,diameter_mm", numbered).encode())
    questions = "Which ring is it? (count from the centre),What diameter did you measure in mm?"
    yield Form("a long question for a header", text(questions, _PLAIN).encode(), 0)


def _of_rows() -> Iterator[Form]:
    notes = "\n1) read twice\n2) lamp moved after ring 7\n* by eye\n"
    marked = [(n, f"{size}{mark}") for (n, size), mark in zip(_PLAIN, ["", "*", "", "¹", *[""] * 8], strict=True)]
    yield Form("footnotes", text("n,D (mm)", _PLAIN, after=notes).encode())
    yield Form("signs of footnotes at the numbers", text("n,D (mm)", marked, after=notes).encode())
    commented = text("n,D (mm)", [(n, f"{size} # ring {n}") for n, size in _PLAIN], before="# Tuesday, lamp 2\n")
    yield Form("comments behind the rows", commented.encode())
    dated = [(f"2024-03-{n:02d}", n, size) for n, size in _PLAIN]
    yield Form("dates beside", text("date,order,diameter (mm)", dated).encode())
    clock = [(f"14:{n:02d}:30", n, size) for n, size in _PLAIN]
    yield Form("times beside", text("Time;n;D (mm)", clock, ";").encode())
    months = [(n, f"{size:.2f}") for n, size in _PLAIN]
    months[3] = (4, "03. Jul")
    yield Form("a reading that became a date", text("n,D (mm)", months).encode(), 0)
    falling = text("ring,D (mm)", _PLAIN[::-1])
    yield Form("rings from outside inwards", falling.encode())
    spaced = "\n\n".join(f"{n};{comma(size)}" for n, size in _PLAIN)
    yield Form("a blank line after each row", f"Ring;D [mm]\n\n{spaced}\n".encode())
    repeated = text("n,D (mm)", _PLAIN[:6]) + text("n,D (mm)", _PLAIN[6:])
    yield Form("the header again on a second page", repeated.encode())
    total = text("n,D (mm)", [*_PLAIN, ("Sum", round(sum(DIAMETERS), 3)), ("Average", "3.6")])
    yield Form("sum and average below", total.encode())
    estimate = text("n,D (mm)", [(n, f"~{size}" if n == 5 else size) for n, size in _PLAIN])
    yield Form("about, by a sign", estimate.encode())
    ranges = text("n,D (mm)", [(n, f"{size - 0.01:.3f}-{size + 0.01:.3f}") for n, size in _PLAIN])
    yield Form("ranges for sizes", ranges.encode(), 0)


def _of_tables() -> Iterator[Form]:
    beside = [(n, size, "", n, round(size / 1.152, 3)) for n, size in _PLAIN]
    yield Form("air and water side by side", text("n,D air (mm),,n,D water (mm)", beside).encode(), 0)
    same = [(*_PLAIN[k], "", *_PLAIN[k + 6]) for k in range(6)]
    yield Form("a table cut in two, side by side", text("n,D (mm),,n,D (mm)", same).encode())
    lens = "Lens,f (mm)\nA,500\nB,250\n\n"
    yield Form("another table above", text("n,D (mm)", _PLAIN, before=lens).encode())
    below = "\nResult,R (m)\nmean,1.002\nsd,0.004\n"
    yield Form("a table of results below", text("n,D (mm)", _PLAIN, after=below).encode())


def _of_separators() -> Iterator[Form]:
    mixed = [(n, comma(size)) for n, size in _PLAIN]
    yield Form("tabs and decimal commas", text("Ring\tDurchmesser / mm", mixed, "\t").encode())
    both = "\n".join(f"{n},\t{size}" for n, size in _PLAIN)
    yield Form("comma and tab between cells", f"n,\tD (mm)\n{both}\n".encode())
    yield Form("a header with commas over tabs", text("n,D (mm)", _PLAIN, "\t").encode())
    thousands = [(n, f"{1e4 * size:,.0f}") for n, size in _PLAIN]
    quoted = [(n, f'"{cell}"') for n, cell in thousands]
    yield Form("thousands in quotes", text("n,D (0.1 um)", quoted).encode(), 0)
    apostrophes = [(n, f"{1e3 * size:,.0f}".replace(",", "'")) for n, size in _PLAIN]
    yield Form("Swiss thousands", text("Ordnung;Durchmesser (µm)", apostrophes, ";").encode())
    dots = [(n, f"{1e3 * size:,.1f}".replace(",", "t").replace(".", ",").replace("t", ".")) for n, size in _PLAIN]
    yield Form("points between thousands of micrometres", text("Ordnung;Durchmesser (µm)", dots, ";").encode())
    colons = [(n, f"{size}") for n, size in _PLAIN]
    yield Form("colons", text("ring: D in mm", colons, ": ").encode())
    arrows = "\n".join(f"ring {n} = {size} mm" for n, size in _PLAIN)
    yield Form("sentences", f"diameters\n{arrows}\n".encode(), 0, ".txt")
    json = "{" + f'"order": {ORDERS}, "diameter_mm": {DIAMETERS}' + "}\n"
    yield Form("JSON", json.encode(), suffix=".json")


def _of_signs() -> Iterator[Form]:
    arabic = [(str(n).translate(_ARABIC), f"{size}".translate(_ARABIC)) for n, size in _PLAIN]
    yield Form("Arabic digits and unit", text("رقم الحلقة;القطر (مم)", arabic, ";").encode())
    wide = [(str(n).translate(_FULL_WIDTH), f"{size}".translate(_FULL_WIDTH)) for n, size in _PLAIN]
    yield Form("full-width digits", text("次数,直径（ｍｍ）", wide).encode())
    hard = "\n".join(f"{n}\u00a0\t{size}\u00a0mm" for n, size in _PLAIN)
    yield Form("blanks that do not break, of a text processor", f"Ring\u00a0no.\tD\n{hard}\n".encode())
    soft = text("Ord\u00adnung;Durch\u00admesser\u200b (mm)", _PLAIN, ";")
    yield Form("soft hyphens and blanks of no width", soft.encode())
    roman = ["I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX", "X", "XI", "XII"]
    yield Form("Roman numerals", text("n,D (mm)", list(zip(roman, DIAMETERS, strict=True))).encode(), 0)
    words = ["1st dark", "2nd dark", "3rd dark", *(f"{n}th dark" for n in ORDERS[3:])]
    yield Form("ordinals of dark rings", text("ring,D (mm)", list(zip(words, DIAMETERS, strict=True))).encode())
    scientific = [(n, f"{size * 1e-3:.4e}".replace("e-03", "E-03")) for n, size in _PLAIN]
    yield Form("powers of ten in metres", text("n\tD (m)", scientific, "\t").encode())
    typeset = [(n, f"{size / 10:.4f}×10^1") for n, size in _PLAIN]
    yield Form("typeset powers of ten", text("n,D (mm)", typeset).encode())
    primes = [(f"{n}.", f"{comma(size)} мм") for n, size in _PLAIN]
    yield Form("Cyrillic units in the cells", text("№ п/п;Диаметр кольца", primes, ";").encode("cp1251"))


def _of_pages() -> Iterator[Form]:
    latex = "\\begin{tabular}{cc}\n\\toprule\n$m$ & $D$ (\\si{\\milli\\metre}) \\\\\n\\midrule\n"
    body = "".join(f"{n} & \\num{{{size}}} \\\\\n" for n, size in _PLAIN)
    yield Form("LaTeX with siunitx", f"{latex}{body}\\bottomrule\n\\end{{tabular}}\n".encode(), suffix=".tex")
    dollars = "".join(f"${n}$ & ${size} \\pm 0.005$ \\\\ \\hline\n" for n, size in _PLAIN)
    yield Form("LaTeX in dollars", f"$n$ & $D$ / mm \\\\ \\hline\n{dollars}".encode(), suffix=".tex")
    bars = "\n".join(f"| **{n}** | {size} |" for n, size in _PLAIN)
    yield Form("Markdown in bold", f"| *n* | `D (mm)` |\n|:-:|--:|\n{bars}\n".encode(), suffix=".md")
    cells = "".join(f"<tr><td>{n}</td><td>{size}</td></tr>\n" for n, size in _PLAIN)
    page = f"<html><body><table><tr><th>n</th><th>D&nbsp;(mm)</th></tr>\n{cells}</table></body></html>\n"
    yield Form("HTML of the clipboard", page.encode(), suffix=".html")
    framed = "\n".join(f"║ {n:>2} ║ {size} ║" for n, size in _PLAIN)
    yield Form(
        "a frame of lines", f"╔════╦═══════╗\n║  n ║ D, mm ║\n╠════╬═══════╣\n{framed}\n╚════╩═══════╝\n".encode()
    )
    ascii_frame = "\n".join(f"| {n:>2} | {size} |" for n, size in _PLAIN)
    yield Form(
        "a frame of signs", f"+----+-------+\n|  n | D, mm |\n+====+=======+\n{ascii_frame}\n+----+-------+\n".encode()
    )
    wiki = "".join(f"|-\n| {n} || {size}\n" for n, size in _PLAIN)
    yield Form("a wiki's table", f'{{| class="wikitable"\n! n !! D (mm)\n{wiki}|}}\n'.encode(), suffix=".txt")


def _of_workbooks() -> Iterator[Form]:
    rows: list[Sequence[object]] = [["n", "D (mm)"], *(list(pair) for pair in _PLAIN)]
    notes = ["Newton's rings", "group 3"], ["date", "2024-03-07"]
    yield Form(
        "a workbook with notes on its first sheet", xlsx_of_sheets({"notes": notes, "data": rows}), suffix=".xlsx"
    )
    constants = [["lamp", "sodium"], ["wavelength (nm)", 589.3], ["room", 21]]
    yield Form("a sheet of constants first", xlsx_of_sheets({"constants": constants, "rings": rows}), suffix=".xlsx")
    lens = [["lens", "f (mm)"], ["A", 500], ["B", 250], ["C", 125]]
    yield Form("a sheet of another table first", xlsx_of_sheets({"lenses": lens, "rings": rows}), suffix=".xlsx")
    merged = [["Readings", None, None], ["Ring", "Left (mm)", "Right (mm)"], *map(list, _SIDES)]
    yield Form("merged cells", xlsx_of_sheets({"rings": merged}, merged=("A1:C1",)), suffix=".xlsx")
    below = [["ring", "side", "x (mm)"]]
    for n, left, right in _SIDES:
        below += [[n, "left", left], [None, "right", right]]
    yield Form(
        "rings in merged cells, sides below", xlsx_of_sheets({"rings": below}, merged=("A2:A3",)), suffix=".xlsx"
    )
    shifted = [[None, None, None], [None, None, None], *([None, *row] for row in rows)]
    yield Form("a table that begins at B3", xlsx_of_sheets({"rings": shifted}), suffix=".xlsx")
    spoken = [["№ кольца", "D, мм", "примечание"], *([str(n), comma(size), ""] for n, size in _PLAIN)]
    yield Form("ods of texts with decimal commas", ods(spoken), suffix=".ods")


HOSTILE = (
    *_of_headers(), *_of_rows(), *_of_tables(), *_of_separators(), *_of_signs(), *_of_pages(), *_of_workbooks(),
)  # fmt: skip
