"""Names of columns: what a header says of kind and unit, in the spellings that people use."""

import re
from collections.abc import Iterable

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
UNITS = (*METRES, "px")
# Kinds of sizes in their order of preference: the ring's radius over what such a column holds. "left" holds the
# distance to "right", its partner.
RADIUS_OVER = {"left": 0.5, "diameter": 0.5, "radius": 1.0, "position": 1.0}
SIZES = (*RADIUS_OVER, "right")
NAMES = ("order", "series", *(f"{kind}_{unit}" for kind in (*SIZES, "sd") for unit in UNITS))
UNIT_WORDS = {unit: unit for unit in UNITS} | {
    "metre": "m", "meter": "m", "metres": "m", "meters": "m",
    "micron": "um", "microns": "um", "micrometre": "um", "micrometer": "um", "micrometres": "um", "micrometers": "um",
    "millimetre": "mm", "millimeter": "mm", "millimetres": "mm", "millimeters": "mm",
    "centimetre": "cm", "centimeter": "cm", "centimetres": "cm", "centimeters": "cm",
    "pixel": "px", "pixels": "px",
}  # fmt: skip
DEVIATIONS = {"sd", "sigma", "error", "err", "uncertainty", "std", "stdev", "stddev", "deviation"}
_SERIES = {"series", "run", "set", "trial", "observer", "repeat", "measurement"}
FILLERS = {"ring", "rings", "of", "the", "reading", "readings", "standard", "side", "x", "dark", "bright"}
LETTERS = {"d": "diameter", "r": "radius"}
ORDER_LETTERS = {"m", "n", "k", "p"}
# What a column of orders is called by those who do not call it that.
ORDER_LIKE = {"m", "n", "k", "p", "j", "ring", "number", "no", "nr", "index", "i", "fringe", "#", "order"}
_SIGNS = str.maketrans({"µ": "u", "μ": "u", "σ": " sigma ", "±": " sd ", "Δ": " sd ", "δ": " sd ", "²": " squared "})
# What students of other languages write, as words; in Chinese as parts of a text without blanks, the longest first.
_TRANSLATIONS = {
    "ordnung": "order", "ordnungszahl": "order", "ringnummer": "order", "ordre": "order", "orden": "order",
    "ordine": "order", "ordem": "order", "порядок": "order", "durchmesser": "diameter", "ringdurchmesser": "diameter",
    "diamètre": "diameter", "diametre": "diameter", "diametro": "diameter", "diámetro": "diameter",
    "diâmetro": "diameter", "диаметр": "diameter", "halbmesser": "radius", "ringradius": "radius", "rayon": "radius",
    "raggio": "radius", "radio": "radius", "raio": "radius", "радиус": "radius", "links": "left", "gauche": "left",
    "izquierda": "left", "sinistra": "left", "rechts": "right", "droite": "right", "derecha": "right",
    "destra": "right", "messung": "series", "messreihe": "series", "série": "series", "serie": "series",
    "fehler": "sd", "unsicherheit": "sd", "standardabweichung": "sd", "incertitude": "sd", "écart": "sd",
    "mittelwert": "mean", "mittel": "mean", "moyenne": "mean", "moyen": "mean", "average": "mean", "avg": "mean",
    "quadrat": "squared", "carré": "squared", "lage": "position", "anneau": "ring", "mittlerer": "mean",
    "nummer": "number", "numéro": "number", "n°": "number",
    "de": "of", "des": "of", "der": "of", "le": "the", "la": "the", "du": "of",
}  # fmt: skip
_CHINESE = {
    "标准不确定度": "sd", "不确定度": "sd", "标准差": "sd", "误差": "sd", "平均值": "mean", "平均": "mean",
    "直径": "diameter", "半径": "radius", "级次": "order", "级数": "order", "环序": "order", "环数": "order",
    "序数": "order", "平方": "squared", "毫米": "mm", "厘米": "cm", "微米": "um", "位置": "position", "读数": "reading",
    "暗环": "ring", "亮环": "ring", "圆环": "ring", "左侧": "left", "右侧": "right", "左": "left", "右": "right",
    "环": "ring", "组": "series", "的": "of",
}  # fmt: skip


def canonical(header: str) -> str:
    """The name of `NAMES` that a header means, the same without its unit where it has none, or "" for another column.

    A column of deviations is "sd", with the kind of size between where the header names one: "sd_radius_mm".
    """
    words = [word for word in words_of(header) if word not in FILLERS]
    if "order" in words and all(word in ORDER_LETTERS or word == "order" for word in words):
        return "order"
    if len(words) == 1 and words[0] in _SERIES:
        return "series"
    is_deviation = any(word in DEVIATIONS for word in words)
    words = [word for word in words if word not in DEVIATIONS]
    unit = UNIT_WORDS.get(words[-1], "") if words else ""
    kinds = words[:-1] if unit else words
    if is_deviation:
        kinds = [LETTERS.get(kind, kind) for kind in kinds]
        return "_".join(filter(None, ["sd", *kinds, unit])) if all(kind in SIZES for kind in kinds) else ""
    return "_".join(filter(None, [*kinds, unit])) if len(kinds) == 1 and kinds[0] in SIZES else ""


def unit_of(header: str) -> str:
    """The unit that a header states after its name: "D (cm)", "D, cm", "D / cm", "D [cm]", "D_cm"; "" without one."""
    words = words_of(header)
    return UNIT_WORDS.get(words[-1], "") if len(words) > 1 else ""


def is_deviation(header: str) -> bool:
    """Whether a header speaks of deviations."""
    return any(word in DEVIATIONS for word in words_of(header))


def order_like(headers: Iterable[str]) -> str:
    """The first header that may be that of the orders; "ITS-NAME" without one."""
    return next((header for header in headers if header.strip().lower() in ORDER_LIKE), "ITS-NAME")


def size_advice(headers: Iterable[str]) -> str:
    """How to name a column of sizes: with the unit that its header states."""
    stated = [(header, unit_of(header)) for header in headers if unit_of(header) and not is_deviation(header)]
    if not stated:
        return "name one with its unit, such as diameter_mm=ITS-NAME for diameters in mm"
    header, unit = stated[0]
    return f"name one, such as diameter_{unit}={header} or radius_{unit}={header}"


def is_chinese(text: str) -> bool:
    """Whether a text holds words of a Chinese table."""
    return any(word in text for word in _CHINESE if len(word) > 1)


def words_of(header: str) -> list[str]:
    """A header's words, in lower case and in English, "squared" for signs of it."""
    text = header.translate(_SIGNS).lower()
    for chinese, word in _CHINESE.items():
        text = text.replace(chinese, f" {word} ")
    text = re.sub(r"\^\s*2", " squared ", text)
    words = [word for word in re.split(r"[\s_,;:/()\[\]{}.|（）、-]+", text) if word]
    return [_TRANSLATIONS.get(word, word) for word in words]
