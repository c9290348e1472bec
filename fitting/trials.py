"""Fits with parts beside the plain one: warps of the map from image to object, and contacts."""

from itertools import combinations

import numpy as np

from fitting import least_squares as ls
from fitting.illumination import FEW, Fitted, converge, fringes_seen, numbers_of
from fitting.phase_map import followed
from fitting.photo import Photograph
from fitting.smoothing import pixels_of

# Parts that bend the map from the image to the object, with the largest numbers that can be meant: cos θ = 0.67, and
# 15 % at the rim of the field (eyepieces reach 10 %).
WARPS = {"oblique view": 0.4, "distortion": 0.15, "fifth order": 0.05}
# A trial that has not settled after so many rounds is judged as it is; the chosen one is fitted again.
_ROUNDS = 4
# Squared radii of contacts to start from, and the largest one that can be meant [half diagonals squared].
DISCS, _WIDEST = (0.003, 0.01, 0.03, 0.08), 0.3


def bent(found: Fitted, photograph: Photograph, wishes: dict[str, bool]) -> Fitted:
    """The fit with as many warps as it bears: a number beyond what can be meant is none of a camera."""
    allowed = [part for part in WARPS if wishes.get(part, True)]
    for parts in (s for n in range(len(allowed), 0, -1) for s in combinations(allowed, n) if nested(s)):
        for start in (followed(found, photograph, parts), numbers_of(found)):
            full = _trial(found, photograph, parts, start)
            if _sane(full, photograph):
                return full
    return found


def touching(
    found: Fitted, full: Fitted, photograph: Photograph, pinned: float, wishes: dict[str, bool]
) -> list[Fitted]:
    """Fits with a contact: pinned, and with a film, as far as they are wished and there is one.

    Pinned, the phase beyond the disc allows a contact radius a turn. With a film that ladder is gone, so the search
    goes there first, from discs of several sizes, and takes the nearest rung in the end.
    """
    tried = []
    for square in DISCS:
        trial = numbers_of(found).copy()
        trial[3], trial[7] = trial[3] + 2 * trial[0] * square, square
        tried.append(_trial(found, photograph, (*full.parts, "contact", "film"), trial))
    tried = [fit for fit in tried if _is_disc(fit) and _sane(fit, photograph)]
    if not tried:
        return []
    loose = min(tried, key=lambda fit: float(fit.solution.chi2))
    trial = numbers_of(loose).copy()
    nearest = pinned + np.round(trial[3] - pinned)
    trial[7] += (nearest - trial[3]) / (2 * trial[0])
    trial[3] = nearest
    tight = _trial(found, photograph, (*full.parts, "contact"), trial)
    fits = [tight] if _is_disc(tight) and _sane(tight, photograph) and not wishes.get("film") else []
    return fits + [loose] * wishes.get("film", True)


def _trial(found: Fitted, photograph: Photograph, parts: tuple[str, ...], numbers: np.ndarray) -> Fitted:
    """A fit with parts to every pixel of the mask alike: outliers are those of the model that is chosen in the end."""
    few = fringes_seen(found.solution.image[2], photograph.mask) < FEW
    shape = found.shape if few else (ls.BACKGROUND, ls.CONTRAST)
    return converge(found.model, photograph, numbers, photograph.mask.astype(float), found.fixed, parts, shape, _ROUNDS)


def _sane(found: Fitted, photograph: Photograph) -> bool:
    """Whether the warps are a camera's: a distortion counts as what it moves at the lit field's rim."""
    numbers = numbers_of(found)
    far = rim(photograph.lit)
    sizes = [np.hypot(*numbers[4:6]), numbers[6] * far, numbers[8] * far**2]
    return bool(np.isfinite(numbers).all()) and all(
        abs(size) < most for size, most in zip(sizes, WARPS.values(), strict=True)
    )


def rim(lit: np.ndarray) -> float:
    """Largest squared distance of the lit field from the image's middle [half diagonals squared]."""
    x, y = pixels_of(lit)
    middle_y, middle_x = ((n - 1) / 2 for n in lit.shape)
    return float(((x - middle_x) ** 2 + (y - middle_y) ** 2).max()) / (middle_x**2 + middle_y**2)


def _is_disc(fit: Fitted) -> bool:
    return bool(0 < numbers_of(fit)[7] < _WIDEST)


def nested(parts) -> bool:
    return "distortion" in parts or "fifth order" not in parts
