"""Beams as words: which surfaces light meets, in order, and whether it is transmitted (T) or reflected (R).

A word such as "T0 T1 R2 R1 T2 T3" is read from the source: through surfaces 0 and 1, reflected at 2 and at 1,
then out through 2 and 3. Surfaces and media are numbered in the order in which the light first meets them.
"""

import re
from dataclasses import dataclass

import numpy as np

from newtonjax.numerics import positive, require, require_whole, shown

_ACTION = re.compile(r"([TR])(\d+)")
TRANSMIT, REFLECT, REST = 0, 1, 2
_MOST = 12


@dataclass(frozen=True)
class Beam:
    """One way through a stack: its word, a short name, the side where it leaves, and its energy on the axis.

    `name` joins the reflections ("R2-R1"; "direct" without any). `energy` is the fraction of the incident flux at
    normal incidence (Fresnel), before any other beam interferes.
    """

    word: str
    name: str
    view: str
    energy: float


@dataclass(frozen=True)
class Itinerary:
    """A word as integers: per interaction the surface, the action, and the media on this and on the far side."""

    surface: tuple[int, ...]
    action: tuple[int, ...]
    before: tuple[int, ...]
    beyond: tuple[int, ...]
    view: str


def itinerary(word: str, surfaces: int) -> Itinerary:
    """Read a word for a stack of so many surfaces.

    Raises ValueError where the word is malformed, skips a surface or ends inside the stack.
    """
    surface, action, before, beyond = [], [], [], []
    medium, down = 0, True
    for token in word.split():
        match = _ACTION.fullmatch(token)
        if not match:
            raise ValueError(
                f"beam {shown(word)}: {shown(token)} is no interaction; allowed: T or R and a surface, as in 'T0 R1 T0'"
            )
        met, expected = int(match[2]), medium if down else medium - 1
        if met != expected or not 0 <= expected < surfaces:
            expected_face = (
                f"surface {expected}" if 0 <= expected < surfaces else "no surface: the light has left the stack"
            )
            raise ValueError(
                f"beam {shown(word)}: at {shown(token)} the light meets {expected_face}, not surface {met}"
            )
        surface.append(met)
        before.append(medium)
        beyond.append(medium + 1 if down else medium - 1)
        if match[1] == "R":
            action.append(REFLECT)
            down = not down
        else:
            action.append(TRANSMIT)
            medium = beyond[-1]
    if not surface or not ((medium == 0 and not down) or (medium == surfaces and down)):
        raise ValueError(
            f"beam {shown(word)} ends inside the stack of {surfaces} surfaces; it must leave above or below"
        )
    return Itinerary(*map(tuple, (surface, action, before, beyond)), view="transmitted" if down else "reflected")


def name_of(word: str) -> str:
    """The reflections of a word, joined by hyphens; "direct" without any."""
    return "-".join(token for token in word.split() if token[0] == "R") or "direct"


def word_of(name: str, surfaces: int) -> str:
    """The word of a beam's short name (see `name_of`) in a stack of so many surfaces; a whole word stays as it is.

    Raises ValueError for a name that light cannot follow.
    """
    if not isinstance(name, str):
        raise ValueError(f"a beam is {shown(name)}; allowed: a name such as direct or R2-R1, or a word")
    name = name.strip()
    if " " in name or name.startswith("T"):
        return name
    if not re.fullmatch(r"direct|R\d+(-R\d+)*", name):
        raise ValueError(
            f"beam {shown(name)} is unknown; give its reflections, such as R1 or R2-R1, direct, or 'all' alone"
        )
    turns = [] if name == "direct" else [int(turn[1:]) for turn in name.split("-")]
    word, medium, down = [], 0, True
    while 0 <= (met := medium if down else medium - 1) < surfaces:
        if turns and met == turns[0]:
            word.append(f"R{turns.pop(0)}")
            down = not down
        else:
            word.append(f"T{met}")
            medium += 1 if down else -1
    if turns:
        raise ValueError(
            f"beam {shown(name)} is unknown: light leaves the stack of {surfaces} surfaces before it meets "
            f"R{turns[0]}; name a beam by its reflections in their order, such as direct, R1 or R2-R1"
        )
    return " ".join(word)


def _walk(surfaces: int, reflections: int, word: tuple[str, ...], medium: int, down: bool):
    met = medium if down else medium - 1
    if not 0 <= met < surfaces:
        yield " ".join(word)
        return
    yield from _walk(surfaces, reflections, (*word, f"T{met}"), medium + (1 if down else -1), down)
    if reflections:
        yield from _walk(surfaces, reflections - 1, (*word, f"R{met}"), medium, not down)


def words(surfaces: int, reflections: int, view: str) -> tuple[str, ...]:
    """Every word of a stack with at most so many reflections that leaves on one side.

    `view` is "transmitted" (below the last surface) or "reflected" (above the first).
    """
    if not isinstance(view, str) or view not in ("transmitted", "reflected"):
        raise ValueError(f"view is {shown(view)}; allowed: 'transmitted' or 'reflected'")
    parity = 0 if view == "transmitted" else 1
    every_word = _walk(surfaces, reflections, (), 0, True)
    return tuple(word for word in every_word if word.count("R") % 2 == parity)


def energy_on_axis(word: str, media) -> float:
    """Fraction of the incident flux that takes this way at normal incidence: Π R, T with R = ((n1-n2)/(n1+n2))²."""
    path = itinerary(word, len(media) - 1)
    energy = 1.0
    for surface, action in zip(path.surface, path.action, strict=True):
        n1, n2 = float(media[surface]), float(media[surface + 1])
        reflectance = ((n1 - n2) / (n1 + n2)) ** 2
        energy *= reflectance if action == REFLECT else 1 - reflectance
    return energy


def enumerate_beams(media, view: str = "reflected", reflections: int = 3) -> tuple[Beam, ...]:
    """All beams with at most so many reflections that leave on one side, strongest first.

    Args:
      media: refractive indices in the order in which light meets them, one more than there are surfaces.
      view: "transmitted" or "reflected".

    Raises ValueError for media that are none, another view, and reflections outside of 0 to 12: their number grows
    by a factor with each.

    """
    require_whole("reflections", reflections, 0, _MOST)
    sizes = len(media) if isinstance(media, tuple | list) else np.size(media) if np.ndim(media) == 1 else 0
    if sizes < 2:
        raise ValueError(f"media is {shown(media)}; allowed: refractive indices, one more than there are surfaces")
    require("media", media, "positive refractive indices", positive)
    of_view = words(len(media) - 1, reflections, view)
    beams = (Beam(word, name_of(word), view, energy_on_axis(word, media)) for word in of_view)
    return tuple(sorted(beams, key=lambda beam: -beam.energy))


def tables(beams: tuple[str, ...], surfaces: int, interactions: int | None = None) -> dict[str, np.ndarray]:
    """Integer tables [beam, interaction] for a scan, padded with rests to one length; None is that of the longest."""
    paths = [itinerary(word, surfaces) for word in beams]
    length = max(len(path.surface) for path in paths) if interactions is None else interactions

    def pad(values, filler):
        return tuple(values) + (filler,) * (length - len(values))

    return {
        "surface": np.array([pad(path.surface, path.surface[-1]) for path in paths]),
        "action": np.array([pad(path.action, REST) for path in paths]),
        "before": np.array([pad(path.before, exit_medium(path, surfaces)) for path in paths]),
        "beyond": np.array([pad(path.beyond, exit_medium(path, surfaces)) for path in paths]),
    }


def exit_medium(path: Itinerary, surfaces: int) -> int:
    """The medium in which the screen stands."""
    return surfaces if path.view == "transmitted" else 0
