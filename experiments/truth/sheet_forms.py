"""Made spreadsheets in the forms in which people keep ring readings: languages, layouts, separators, encodings."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.truth.workbooks import ods, xlsx

WAVELENGTH = 589.3e-9
RADIUS = 1.0
ORDERS = list(range(1, 13))
# Diameters [mm] of a lens of 1 m, to a micrometre; readings on both sides of a microscope's scale.
DIAMETERS = [round(float(size), 3) for size in 2e3 * np.sqrt(np.array(ORDERS) * WAVELENGTH * RADIUS)]
LEFTS = [round(25 - size / 2, 4) for size in DIAMETERS]
RIGHTS = [round(25 + size / 2, 4) for size in DIAMETERS]


@dataclass(frozen=True)
class Form:
    """A spreadsheet as bytes, with its file's suffix; readings that are in it, 0 where it has to be refused.

    `options`: of `fitting.rings` beside the wavelength. The lens has the radius `RADIUS` in each.
    """

    name: str
    content: bytes
    readings: int = 12
    suffix: str = ".csv"
    options: tuple[tuple[str, Any], ...] = ()


def comma(value: float, places: int = 3) -> str:
    """A number with a decimal comma."""
    return f"{value:.{places}f}".replace(".", ",")


def text(header: str, rows: Sequence[Sequence[object]], separator: str = ",", before: str = "", after: str = "") -> str:
    """A table as text: what stands before it, a header, rows, and what stands after it."""
    lines = [separator.join(map(str, row)) for row in rows]
    return before + "\n".join([header, *lines]) + "\n" + after


def _pairs(sizes: Sequence[float] = DIAMETERS) -> list[tuple[object, ...]]:
    return list(zip(ORDERS, sizes, strict=True))


def _commas(sizes: Sequence[float] = DIAMETERS) -> list[tuple[object, ...]]:
    return [(order, comma(size)) for order, size in zip(ORDERS, sizes, strict=True)]


# Header of a semicolon table with decimal commas, and the encoding, by language.
_LANGUAGES = {
    "English": ("Ring number;Diameter (mm)", "utf-8"),
    "English, order m": ("Order m;Diameter D (mm)", "utf-8"),
    "German": ("Ordnung;Durchmesser [mm]", "cp1252"),
    "German, ring's radius": ("Nr. des Rings;Ringradius in mm", "utf-8"),
    "French": ("Ordre;Diamètre (mm)", "cp1252"),
    "French, number of the ring": ("n° de l'anneau;Diamètre D / mm", "utf-8"),
    "Spanish": ("Orden;Diámetro (mm)", "cp1252"),
    "Spanish, number of the ring": ("Número de anillo;Diámetro [mm]", "utf-8-sig"),
    "Italian": ("Ordine;Diametro (mm)", "utf-8"),
    "Italian, number of the ring": ("Numero anello;Diametro [mm]", "cp1252"),
    "Portuguese": ("Ordem do anel;Diâmetro (mm)", "cp1252"),
    "Russian": ("Номер кольца;Диаметр, мм", "cp1251"),
    "Russian in UTF-8": ("порядок;диаметр (мм)", "utf-8"),
    "Russian, number sign": ("№;D, мм", "cp1251"),
    "Ukrainian": ("порядок;діаметр, мм", "utf-8"),
    "Polish": ("Nr prążka;Średnica [mm]", "utf-8"),
    "Dutch": ("orde;diameter (mm)", "utf-8"),
    "Chinese": ("级数;直径/mm", "gbk"),
    "Chinese, number of the ring": ("环的序数;直径(毫米)", "utf-8"),
    "Japanese": ("次数;直径 (mm)", "utf-8"),
    "letters": ("m;D/mm", "utf-8"),
    "sign of a diameter": ("n;Ø [mm]", "cp1252"),
    "capitals": ("ORDER;DIAMETER_MM", "utf-8"),
    "in words": ("order;diameter in millimetres", "utf-8"),
}


def _of_languages() -> Iterator[Form]:
    for language, (header, encoding) in _LANGUAGES.items():
        sizes = [size / 2 for size in DIAMETERS] if "radius" in header.lower() else DIAMETERS
        rows = [(order, comma(size, 4)) for order, size in zip(ORDERS, sizes, strict=True)]
        yield Form(language, text(header, rows, ";").encode(encoding))


def _of_sizes() -> Iterator[Form]:
    um = [round(1e3 * size) for size in DIAMETERS]
    squares = [round(size**2, 5) for size in DIAMETERS]
    sides = list(zip(ORDERS, LEFTS, RIGHTS, strict=True))
    again = [round(size + (-1) ** k * 2e-3, 3) for k, size in enumerate(DIAMETERS)]
    yield Form("plain", text("order,diameter_mm", _pairs()).encode())
    yield Form("radii in cm", text("k,r [cm]", _pairs([round(s / 20, 5) for s in DIAMETERS])).encode())
    yield Form("micrometres", text("order,diameter (µm)", _pairs(um)).encode())
    yield Form("micrometres in cp1252", text("order,diameter (µm)", _pairs(um)).encode("cp1252"))
    yield Form("squares", text("n,D² (mm²)", _pairs(squares)).encode())
    yield Form("squares with a caret", text("n,D^2/mm^2", _pairs(squares)).encode())
    yield Form("squares of radii", text("m,r_m^2 (mm2)", _pairs([round(s / 4, 5) for s in squares])).encode())
    yield Form(
        "diameters and squares",
        text("m,D_m (mm),D_m^2 (mm^2)", list(zip(ORDERS, DIAMETERS, squares, strict=True))).encode(),
    )
    yield Form("left and right", text("n,left (mm),right (mm)", sides).encode())
    yield Form("L and R", text("n,L (mm),R (mm)", sides).encode())
    yield Form("x1 and x2", text("k,x1 (mm),x2 (mm)", sides).encode())
    yield Form("x with subscripts", text("k,x_l / mm,x_r / mm", sides).encode())
    yield Form("Chinese left and right", text("环序,d左/mm,d右/mm", sides).encode("gbk"))
    yield Form("Russian left and right", text("№;слева, мм;справа, мм", sides, ";").encode("cp1251"))
    two = list(zip(ORDERS, DIAMETERS, again, strict=True))
    yield Form("two readings side by side", text("n,D1 (mm),D2 (mm)", two).encode(), 24)
    yield Form("two columns of one name", text("n,D (mm),D (mm)", two).encode(), 24)
    crossed = text("order,diameter horizontal (mm),diameter vertical (mm)", two).encode()
    yield Form("horizontal and vertical", crossed, 24)
    stated = [(*row, 0.005) for row in _pairs()]
    for header in ("sigma (mm)", "error", "u(D) (mm)", "± (mm)", "ΔD [mm]", "uncertainty (mm)"):
        yield Form(f"deviations as {header}", text(f"n;D (mm);{header}", stated, ";").encode())
    within = [(order, f"{size:.3f} ± 0.005") for order, size in _pairs()]
    yield Form("deviations in the cells", text("n;D (mm)", within, ";").encode())
    brief = [(order, f"{size:.3f}(5)") for order, size in _pairs()]
    yield Form("deviations in brackets", text("n;D (mm)", brief, ";").encode())


def _of_units() -> Iterator[Form]:
    yield Form("a row of units", text("n;D", [("", "mm"), *_commas()], ";").encode())
    yield Form("a row of units in brackets", text("order,diameter", [("[-]", "[mm]"), *_pairs()]).encode())
    in_cells = [(order, f"{size} mm") for order, size in _pairs()]
    yield Form("units in the cells", text("n,D", in_cells).encode())
    yield Form("units in the cells, tight", text("n;D", [(o, f"{comma(s)}mm") for o, s in _pairs()], ";").encode())
    mixed = [(o, f"{s / 10:.4f} cm" if s >= 4 else f"{s} mm") for o, s in _pairs()]
    yield Form("two units in the cells", text("n;diameter", mixed, ";").encode())
    yield Form("a unit above", text("n,diameter", _pairs(), before="All lengths in mm\n").encode())
    yield Form("no unit at all", text("n,diameter", _pairs()).encode(), 0)
    other = (("columns", {"diameter_mm": "D (cm)"}),)
    yield Form("another unit than asked for", text("n,D (cm)", _pairs()).encode(), 0, options=other)


def _of_separators() -> Iterator[Form]:
    yield Form("semicolons", text("order;diameter_mm", _commas(), ";").encode())
    yield Form("a comma in a semicolon's header", text("order;Diameter, mm", _commas(), ";").encode())
    yield Form("tabs", text("order\tD (mm)", _commas(), "\t").encode())
    yield Form("blanks", text("order diameter_mm", _pairs(), " ").encode())
    yield Form("blanks and decimal commas", text("n D/mm", _commas(), " ").encode())
    yield Form("columns set with blanks", text("Ring number    Diameter (mm)", _pairs(), "       ").encode())
    yield Form("bars of Markdown", text("| n | D (mm) |\n|---|--------|",
                                        [("", *row, "") for row in _pairs()], "|").encode())  # fmt: skip
    latex = [(order, f"{size} \\\\") for order, size in _pairs()]
    yield Form("LaTeX", text("n & D (mm) \\\\ \\hline", latex, " & ").encode())
    yield Form("Excel's own line", text("order,diameter_mm", _pairs(), before="sep=,\n").encode())
    quoted = [(order, f'"{comma(size)}"') for order, size in _pairs()]
    yield Form("quoted decimal commas", text("order,diameter_mm", quoted).encode())
    yield Form("all quoted", text('"order","D (mm)"', [(f'"{o}"', f'"{s}"') for o, s in _pairs()]).encode())
    yield Form("a header of two lines in quotes", text('n;"Diameter\n(mm)"', _commas(), ";").encode())
    yield Form("blanks around", text(" order , D (mm) ", [(f" {o} ", f"  {s} ") for o, s in _pairs()]).encode())
    yield Form("commas for both", text("n,D (mm)", _commas()).encode(), 0)


def _of_layouts() -> Iterator[Form]:
    title = "Newton's rings\n12 March; group 4\nlens 7\n\n"
    yield Form("title lines", text("n;D (mm)", _commas(), ";", before=title).encode())
    notes = "wavelength;589,3;nm\nmicroscope 2\n"
    yield Form("a title with a number", text("n;D (mm)", _commas(), ";", before=notes).encode())
    yield Form("a mean below", text("n;D (mm)", _commas(), ";", after=f"mean;{comma(3.9)}\n").encode())
    german = text("Ordnung;Durchmesser (mm)", _commas(), ";", after=";\nMittelwert;3,9\nStandardabweichung;1,2\n")
    yield Form("means below in German", german.encode("cp1252"))
    yield Form("a remark below", text("n;D (mm)", _commas(), ";", after="\nread by AB; lamp: sodium\n").encode())
    gaps = [(o, "" if o == 3 else "-" if o == 5 else "#VALUE!" if o == 7 else s) for o, s in _pairs()]
    yield Form("gaps, dashes, errors", text("n,D (mm)", gaps).encode(), 9)
    empty = [("", o, "", s, "", "") for o, s in _pairs()]
    yield Form("empty columns", text(",n,,D (mm),,", empty).encode())
    remarks = [(o, s, "blurred" if o == 4 else "") for o, s in _pairs()]
    yield Form("remarks beside", text("n,D (mm),remark", remarks).encode())
    minus = [(o, f"−{s / 2:.4f}", f"{s / 2:.4f}") for o, s in _pairs()]
    yield Form("Unicode minus", text("n;left (mm);right (mm)", minus, ";").encode())
    ordinals = [(f"{o}.", s) for o, s in _pairs()]
    yield Form("orders with points", text("Nr.;D (mm)", ordinals, ";").encode())
    yield Form("rings by name", text("ring,diameter (mm)", [(f"Ring {o}", s) for o, s in _pairs()]).encode())
    yield Form("ordinal numbers", text("order,diameter (mm)", [(f"{o}th", s) for o, s in _pairs()]).encode())
    yield Form("quantities in rows", "\n".join([";".join(["n", *map(str, ORDERS)]),
                                               ";".join(["D/mm", *map(comma, DIAMETERS)])]).encode())  # fmt: skip
    block = text("n;D (mm)", _commas(), ";")
    yield Form("series one a block", f"Series 1\n{block}\nSeries 2\n{block}".encode(), 24)
    beside = [(o, comma(s), "", o, comma(s + 0.002)) for o, s in _pairs()]
    yield Form("series beside each other", text("n;D (mm);;n;D (mm)", beside, ";").encode(), 24)
    yield Form("numbered readings", text("No.,m,D (mm)", [(k, o, s) for k, (o, s) in enumerate(_pairs())]).encode())
    both = list(zip(ORDERS, [size / 2 for size in DIAMETERS], DIAMETERS, strict=True))
    yield Form("radii and diameters", text("m,r (mm),D (mm)", both).encode())
    lens = [(*row, 1000) for row in _pairs()]
    yield Form("the lens's radius beside", text("n,D (mm),R (mm)", lens).encode())
    yield Form("names in a comment", text("# n D_mm", _pairs(), " ").encode())
    yield Form("a number sign for the orders", text("#;D (mm)", _commas(), ";").encode())
    yield Form("no header", text("", _pairs()).lstrip().encode(), 0)
    named = (("columns", {"order": "column 1", "diameter_mm": "column 2"}),)
    yield Form("no header, columns named", text("", _pairs()).lstrip().encode(), options=named)
    yield Form("orders nowhere", text("D (mm)", [(s,) for s in DIAMETERS]).encode(), 0)
    rows = (("columns", {"order": "row"}),)
    yield Form("orders nowhere, rows named", text("D (mm)", [(s,) for s in DIAMETERS]).encode(), options=rows)
    yield Form("a letter for a number", text("n,D (mm)", [(o, "2.l7" if o == 2 else s) for o, s in _pairs()]).encode(),
               0)  # fmt: skip


def _of_verniers() -> Iterator[Form]:
    def scales(reading: float, division: float = 0.01) -> tuple[str, str]:
        main = np.floor(2 * reading) / 2
        return f"{main:g}", f"{round((reading - main) / division):d}"

    sides = [(o, *scales(left), *scales(right)) for o, left, right in zip(ORDERS, LEFTS, RIGHTS, strict=True)]
    header = "n,Left MSR (mm),Left VSR,Right MSR (mm),Right VSR"
    constant = (("vernier", 0.01e-3),)
    yield Form("main scale and vernier", text(header, sides).encode(), options=constant)
    yield Form("the constant above", text(header, sides, before="Least count = 0.01 mm\n").encode())
    upper = "n,Left,,Right,\n,MSR (mm),VSR,MSR (mm),VSR"
    yield Form("a header of two rows", text(upper, sides).encode(), options=constant)
    yield Form("no constant", text(header, sides).encode(), 0)
    totals = [(*row, left, right) for row, left, right in zip(sides, LEFTS, RIGHTS, strict=True)]
    yield Form("totals beside", text(f"{header},Left total (mm),Right total (mm)", totals).encode())


def _of_encodings() -> Iterator[Form]:
    german = text("Ordnung;Durchmesser (mm);Größe", [(o, comma(s), "klein") for o, s in _pairs()], ";")
    for encoding in ("utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252"):
        yield Form(f"German in {encoding}", german.encode(encoding))
    russian = text("порядок;диаметр, мм;среднее", [(o, comma(s), comma(s)) for o, s in _pairs()], ";")
    yield Form("Russian in utf-16", russian.encode("utf-16"))
    yield Form("Windows line ends", text("order;D (mm)", _commas(), ";").replace("\n", "\r\n").encode())
    yield Form("old Macintosh line ends", text("order;D (mm)", _commas(), ";").replace("\n", "\r").encode())
    grouped = [(o, f"{1000 * s:,.0f}".replace(",", "\u202f")) for o, s in _pairs()]
    yield Form("blanks between thousands", text("n;D (µm)", grouped, ";").encode())
    pasted = text("n\tD (mm)", _commas(), "\t")
    yield Form("pasted text", pasted.encode(), suffix="")


def _of_workbooks() -> Iterator[Form]:
    rows = [["n", "D (mm)"], *[list(row) for row in _pairs()]]
    titled = [["Newton's rings"], [], *rows, ["mean", 3.9]]
    yield Form("xlsx", xlsx(rows), suffix=".xlsx")
    yield Form("xlsx with titles and a mean", xlsx(titled), suffix=".xlsx")
    yield Form("ods", ods(rows), suffix=".ods")
    yield Form("ods in Russian", ods([["№", "Диаметр, мм"], *rows[1:]]), suffix=".ods")


_KINDS: tuple[Callable[[], Iterator[Form]], ...] = (
    _of_languages, _of_sizes, _of_units, _of_separators, _of_layouts, _of_verniers, _of_encodings, _of_workbooks,
)  # fmt: skip
FORMS = tuple(form for kind in _KINDS for form in kind())
