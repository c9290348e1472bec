"""Words of reports in a sentence each, for who meets them for the first time."""

# By the word as it stands in reports.
_MEANINGS = {
    "fringe scale": "s²/(R λ), how fast the order of the rings grows with the square of the distance in pixels: all "
    "that a picture without a pixel size s tells of the radius R and the wavelength λ",
    "stretch": "by how much rings, or pixels, are longer along x than along y, as of a view at a slant",
    "shear": "the same along one diagonal against the other",
    "film": "a layer between lens and plate, such as dust or oil, that adds to the gap",
    "criterion": "a number for each model, the smaller the better: it says whether a part is worth its further numbers",
    "Tukey": "weights of pixels that fall to zero far from the model, so that dust and scratches do not count",
    "transfer": "how light became the numbers in the file: a camera's curve such as sRGB, or linear",
    "contact": "where the lens is pressed flat on the plate: there is no gap, and no ring",
    "budget": "what the standard deviation is made of; its rows add as squares",
    "vernier": "the small scale beside a main one, by which parts of its divisions are read",
    "distortion": "by how much the camera draws what is far from the middle too large or too small",
}


def explained(text: str) -> list[tuple[str, str]]:
    """The words of a report that are explained, with their meanings, in the order of this table."""
    small = text.lower()
    return [(word, meaning) for word, meaning in _MEANINGS.items() if word.lower() in small]


def section(text: str) -> str:
    """A last section for a report as text: a line for each of its words that are explained; empty without any."""
    lines = [f"    {word}: {meaning}" for word, meaning in explained(text)]
    return "\n".join(["\n[[Words]]", *lines]) if lines else ""
