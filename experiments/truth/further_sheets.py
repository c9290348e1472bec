"""More made spreadsheets: further languages and encodings, units with powers of ten, inches, verniers, readers."""

from collections.abc import Iterator

from experiments.truth.sheet_forms import DIAMETERS, LEFTS, ORDERS, RIGHTS, Form, comma, text

# Header of a semicolon table with decimal commas, and the encoding, by language; of diameters, or as the name says.
_LANGUAGES = {
    "Greek": ("τάξη m;διάμετρος D (mm)", "utf-8"),
    "Greek, number of the ring": ("αριθμός δακτυλίου;διάμετρος (mm)", "cp1253"),
    "Turkish": ("halka no;çap (mm)", "utf-8"),
    "Finnish": ("kertaluku;halkaisija (mm)", "utf-8"),
    "Czech, its word for mean": ("řád kroužku;průměr [mm]", "cp1250"),
    "Polish of Windows": ("numer prążka k;średnica d_k [mm]", "cp1250"),
    "Polish radius": ("Lp.;promień r [mm]", "utf-8"),
    "Hungarian": ("gyűrű sorszáma;átmérő (mm)", "utf-8"),
    "Hungarian sides": ("sorszám;bal oldal (mm);jobb oldal (mm)", "utf-8"),
    "Romanian": ("Numărul inelului;Diametrul (mm)", "utf-8"),
    "Croatian": ("redni broj;promjer / mm", "utf-8"),
    "Danish sides": ("ringnr.;venstre (mm);højre (mm)", "utf-8"),
    "Norwegian": ("orden m;diameter (mm)", "utf-8"),
    "Russian sides in one word": ("№ кольца;xлев, мм;xправ, мм", "cp1251"),
    "Japanese of Windows": ("次数 m;直径 (mm)", "shift_jis"),
    "Korean": ("차수;지름(mm)", "utf-8"),
    "Korean of Windows": ("차수;지름(mm)", "euc_kr"),
    "Chinese sides": ("环序数;左读数/mm;右读数/mm", "gbk"),
    "Vietnamese": ("bậc vân k;đường kính (mm)", "utf-8"),
    "Hebrew": ("מספר טבעת;קוטר (mm)", "utf-8"),
    "Arabic": ("رقم الحلقة;القطر (mm)", "utf-8"),
    "Arabic radius": ("رتبة الحلقة;نصف القطر (mm)", "utf-8"),
    "Hindi": ("वलय क्रम;व्यास (mm)", "utf-8"),
    "Finnish, ordinal": ("Järjestysluku;Halkaisija (mm)", "utf-8"),
    "Hebrew radius": ('סדר;רדיוס (מ"מ)', "utf-8"),
    "Bulgarian": ("Пореден номер на пръстена;Диаметър (мм)", "cp1251"),
    "Thai": ("ลำดับ;เส้นผ่านศูนย์กลาง (mm)", "utf-8"),
    "Persian": ("شماره حلقه;قطر (mm)", "utf-8"),
    "Latvian": ("Gredzena numurs;Diametrs (mm)", "utf-8"),
    "Lithuanian": ("Žiedo numeris;Skersmuo (mm)", "utf-8"),
    "Estonian": ("Rõnga number;Läbimõõt (mm)", "utf-8"),
    "Croatian, number of the ring": ("Broj prstena;Promjer (mm)", "utf-8"),
    "Malay": ("Tertib gelang;Garis pusat (mm)", "utf-8"),
    "Kazakh": ("Реті;Диаметрі, мм", "utf-8"),
    "Japanese radius": ("環の番号;半径 (mm)", "utf-8"),
    "misspelt": ("ring number;ring diamater (mm)", "utf-8"),
}


def _of_languages() -> Iterator[Form]:
    for language, (header, encoding) in _LANGUAGES.items():
        columns = [[comma(size, 4) for size in DIAMETERS]]
        if "sides" in language:
            columns = [[comma(size, 4) for size in side] for side in (LEFTS, RIGHTS)]
        if "radius" in language:
            columns = [[comma(size / 2, 4) for size in DIAMETERS]]
        yield Form(f"{language} (2)", text(header, list(zip(ORDERS, *columns, strict=True)), ";").encode(encoding))


def _of_units() -> Iterator[Form]:
    """Each header with what its diameters [mm] are to be multiplied by, and whether they are squared."""
    for header, factor, power in (
        ("Radius (x10^-3 m)", 0.5, 1),
        ("r² (10⁻⁶ m²)", 0.25, 2),
        ("D² (×10^-3 cm²)", 10.0, 2),
        ("D / 10^-3 m", 1.0, 1),
        ("D (m·10^-3)", 1.0, 1),
        ("rn2 / mm2", 0.25, 2),
        ("D (in)", 1 / 25.4, 1),
        ("diameter [mil]", 1 / 0.0254, 1),
        ("D² (in²)", 1 / 25.4**2, 2),
        ("$D_m$ ($\\mu$m)", 1e3, 1),
    ):
        rows = [(order, f"{factor * size**power:.7g}") for order, size in zip(ORDERS, DIAMETERS, strict=True)]
        yield Form(header, text(f"n,{header}", rows).encode())
    # Whether the numbers were multiplied by the power of ten, or are still to be, the header does not say.
    squares = [(order, round(size**2, 5)) for order, size in zip(ORDERS, DIAMETERS, strict=True)]
    yield Form("a power of ten outside of the unit", text("n,D^2 x 10^-6 (m^2)", squares).encode(), 0)


def _scales(reading: float) -> tuple[str, int]:
    """A reading [mm] on a main scale of half millimetres [cm], and divisions of 0.01 mm beside it."""
    halves = int(reading / 0.5)
    return f"{halves * 0.05:.2f}", round((reading - 0.5 * halves) / 0.01)


def _of_verniers() -> Iterator[Form]:
    rows = [(order, *_scales(left), *_scales(right)) for order, left, right in zip(ORDERS, LEFTS, RIGHTS, strict=True)]
    sides = "Ring,MSR_L (cm),VSR_L,MSR_R (cm),VSR_R"
    yield Form("verniers with letters for sides", text(sides, rows).encode(), options=(("vernier", 1e-5),))
    yield Form("verniers of no stated worth", text(sides, rows).encode(), 0)
    upper = "Order of ring,Microscope reading Left (cm),,Microscope reading Right (cm),,D,D2"
    below = [("", "MSR", "VSR", "MSR", "VSR", "", ""), *((*row, "", "") for row in rows)]
    yield Form("a unit above both scales", text(upper, below, before="Least count = 0.001 cm\n").encode())


def _of_readers() -> Iterator[Form]:
    two = [(n, size, round(size + 1e-3, 3)) for n, size in zip(ORDERS, DIAMETERS, strict=True)]
    for header in ("m,dm1 [mm],dm2 [mm]", "n,Dx (mm),Dy (mm)", "m,Observer A d (mm),Observer B d (mm)"):
        yield Form(header, text(header, two).encode(), 24)
    below = [("", "diameter (mm)", "diameter (mm)"), *two]
    yield Form("readers above the sizes", text("m,Trial 1,Trial 2", below).encode(), 24)
    # The sides of one ring in two blocks: no column is proposed that is not a size.
    blocks = [
        text(f"n,{side} (mm)", list(zip(ORDERS, readings, strict=True)))
        for side, readings in (("left", LEFTS), ("right", RIGHTS))
    ]
    yield Form("sides below each other", "\n".join(blocks).encode(), 0)


def _of_numbers() -> Iterator[Form]:
    um = [f"{1e3 * size:,.1f}" for size in DIAMETERS]
    pointed = [number.translate(str.maketrans(",.", ".,")) for number in um]
    eastern = str.maketrans("0123456789.", "٠١٢٣٤٥٦٧٨٩٫")
    rows = [
        (str(n).translate(eastern), f"{size}".translate(eastern)) for n, size in zip(ORDERS, DIAMETERS, strict=True)
    ]
    yield Form("points between thousands", text("n;D (µm)", list(zip(ORDERS, pointed, strict=True)), ";").encode())
    yield Form("Arabic digits", text("order,diameter (mm)", rows).encode())


def _stacked() -> Iterator[Form]:
    """Tables below each other, each with a header of its own."""
    plain = text("order;diameter (mm)", list(zip(ORDERS, DIAMETERS, strict=True)), ";")
    turned = [(comma(size / 10, 4), n) for n, size in zip(ORDERS, DIAMETERS, strict=True)]
    yield Form("a second header in cm, turned", (plain + text("diameter (cm);order", turned, ";")).encode(), 24)
    radii = text("order;radius (mm)", [(n, size / 2) for n, size in zip(ORDERS, DIAMETERS, strict=True)], ";")
    yield Form("radii below diameters", (plain + radii).encode(), 0)


FURTHER = (*_of_languages(), *_of_units(), *_of_verniers(), *_of_readers(), *_of_numbers(), *_stacked())
