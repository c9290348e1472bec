"""From frequencies without signs to forms: signs by growing and by models, then the slopes of all terms."""

import numpy as np

from fitting.irregularity.tiles import Tiles
from fitting.irregularity.zernike import REPORTED, TERMS, at_points, slopes

_FIRST = 6
_ROUNDS = 6
# Turns over a window beyond which a tile's slope counts for no more: its sign or its peak is wrong.
_CUT = 1.5
# Terms of the energy of signs, and how many of the seeds are turned about lines and followed.
_ENERGY_TERMS, _TURNED, _FOLLOWED = 15, 6, 10
# Of forms that differ, so many of the best are returned; they differ by more than so many turns rms.
_CANDIDATES, _APART = 5, 0.3


def forms(tiles: Tiles, terms: int = TERMS) -> list[np.ndarray]:
    """Forms [terms], turns, that the slopes of tiles suggest, best first; the piston is open."""
    if len(tiles.u) < _FIRST:
        return []
    # [n, terms - 1, 2]: slopes of all terms but the piston, in turns over a window.
    rise = tiles.window * np.stack([at_points(part[1:terms], tiles.u, tiles.v) for part in slopes()], axis=2)
    slope = tiles.window * tiles.slopes
    signs = np.vstack([_grown(tiles), _modelled(tiles)])
    signs = _quadratic(signs, rise[:, : _FIRST - 1], slope, tiles.weights)
    energy = _energy(rise[:, : min(_ENERGY_TERMS, terms) - 1], slope, tiles.weights)
    signs = _descended(signs, energy)
    signs = _descended(np.vstack([signs, _turned(signs[:_TURNED], tiles)]), energy)
    pairs = [_all_terms(candidate, rise, slope, tiles.weights) for candidate in signs[:_FOLLOWED]]
    candidates: list[np.ndarray] = []
    for _, form in sorted(pairs, key=lambda pair: pair[0]):
        apart = [min(np.linalg.norm(form - candidate), np.linalg.norm(form + candidate)) for candidate in candidates]
        if len(candidates) < _CANDIDATES and all(distance > _APART for distance in apart):
            candidates.append(form)
    return candidates


def _quadratic(signs: np.ndarray, rise: np.ndarray, slope: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Signs [seeds, n] made those of the nearest form of six terms, in turns."""
    count = rise.shape[1]
    root = np.sqrt(weights)[:, None]
    inverse = np.linalg.pinv(np.concatenate([root * rise[:, :, k] for k in (0, 1)]))
    targets = root * slope
    for _ in range(_ROUNDS):
        right = np.hstack([signs * targets[:, 0], signs * targets[:, 1]])
        predicted = np.einsum("njk,sj->snk", rise, (right @ inverse.T).reshape(-1, count))
        signs = np.where(np.einsum("snk,nk->sn", predicted, slope) >= 0, 1.0, -1.0)
    return signs


def _energy(rise: np.ndarray, slope: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The matrix Q [n, n] of what the best form of these terms leaves over of signs s: sᵀ Q s."""
    count = len(slope)
    # Slow fringes are biased by the rim of their window.
    root = np.sqrt(weights * np.minimum(1.0, np.square(slope).sum(axis=1) / 6.0))
    design = np.concatenate([root[:, None] * rise[:, :, k] for k in (0, 1)])
    ridge = np.diag(_ridge(rise.shape[1] + 1)) * weights.sum()
    hat = design @ np.linalg.solve(design.T @ design + ridge, design.T)
    outer = np.eye(2 * count) - hat
    x, y = root * slope[:, 0], root * slope[:, 1]
    return (
        np.outer(x, x) * outer[:count, :count]
        + np.outer(y, y) * outer[count:, count:]
        + np.outer(x, y) * outer[:count, count:]
        + np.outer(y, x) * outer[count:, :count]
    )


def _descended(signs: np.ndarray, energy: np.ndarray) -> np.ndarray:
    """Signs [seeds, n] after flips of single tiles while these lower the energy; different ones, the least first."""
    signs, rows = signs.copy(), np.arange(len(signs))
    field = signs @ energy
    for _ in range(3 * signs.shape[1]):
        gain = signs * field - np.diag(energy)
        best = gain.argmax(axis=1)
        active = gain[rows, best] > 1e-9
        if not active.any():
            break
        changing, flipped = rows[active], best[active]
        field[changing] -= 2 * signs[changing, flipped][:, None] * energy[flipped]
        signs[changing, flipped] *= -1
    signs = np.unique(signs * signs[:, :1], axis=0)
    return signs[np.argsort(np.einsum("sn,nm,sm->s", signs, energy, signs, optimize=True))]


def _turned(signs: np.ndarray, tiles: Tiles) -> np.ndarray:
    """Signs with those beyond a line turned over, for lines across the pupil: folds the other way."""
    lines = [
        np.where(tiles.u * np.cos(angle) + tiles.v * np.sin(angle) > place, -1.0, 1.0)
        for angle in np.pi * np.arange(8) / 8
        for place in (-0.66, -0.33, 0.0, 0.33, 0.66)
    ]
    return (signs[:, None, :] * np.array(lines)[None]).reshape(-1, signs.shape[1])


def _all_terms(signs: np.ndarray, rise: np.ndarray, slope: np.ndarray, weights: np.ndarray) -> tuple[float, np.ndarray]:
    """The form of all terms in the end, order by order with a ridge and weights against outliers, and its cost."""
    terms = rise.shape[1] + 1
    residual = np.full(len(weights), 0.3)
    p = np.zeros(terms - 1)
    for order in (count for count in REPORTED if count <= terms):
        ridge = _ridge(order) * weights.sum()
        for _ in range(2):
            robust = weights / np.maximum(residual, 0.1)
            design = np.concatenate([np.sqrt(robust)[:, None] * rise[:, : order - 1, k] for k in (0, 1)])
            right = np.concatenate([np.sqrt(robust) * signs * slope[:, k] for k in (0, 1)])
            normal = design.T @ design + np.diag(ridge)
            p = np.zeros(terms - 1)
            p[: order - 1] = np.linalg.solve(normal, design.T @ right)
            predicted = np.einsum("njk,j->nk", rise, p)
            signs = np.where((predicted * slope).sum(axis=1) >= 0, 1.0, -1.0)
            residual = np.linalg.norm(predicted - signs[:, None] * slope, axis=1)
    cost = float((weights * np.minimum(residual, _CUT)).sum())
    return cost, np.concatenate([[0.0], p])


def _ridge(terms: int) -> np.ndarray:
    order = np.ceil((np.sqrt(8 * np.arange(2, terms + 1) + 1) - 3) / 2)
    return 1e-3 * (order / 2) ** 3


def _grown(tiles: Tiles) -> np.ndarray:
    """Signs [1, n] from the densest tile outwards, each that which continues the slopes beside it linearly."""
    place = np.column_stack([tiles.u, tiles.v])
    near = np.linalg.norm(place[:, None] - place[None], axis=2)
    reach = 1.6 * tiles.window / 2
    signs = np.zeros(len(place))
    density = np.linalg.norm(tiles.slopes, axis=1) * tiles.weights
    signs[int(density.argmax())] = 1.0
    while not signs.all():
        settled = signs != 0
        support = np.where(settled[None, :] & (near < reach), 1.0, 0.0).sum(axis=1) * np.where(settled, 0, 1)
        best = int((support + 1e-3 * density / density.max()).argmax()) if support.any() else None
        if best is None:
            gaps = np.where(settled[:, None] & ~settled[None, :], near, np.inf)
            best = int(gaps.min(axis=0).argmin())
        predicted = _continued(best, near[best], place, signs[:, None] * tiles.slopes, settled, tiles)
        signs[best] = 1.0 if predicted @ tiles.slopes[best] >= 0 else -1.0
    return signs[None]


def _continued(
    target: int, distance: np.ndarray, place: np.ndarray, slope: np.ndarray, settled: np.ndarray, tiles: Tiles
) -> np.ndarray:
    """The slope at a tile by a weighted linear fit to those whose sign is settled."""
    weight = np.where(settled, tiles.weights * np.exp(-0.5 * np.square(distance / tiles.window)), 0.0)
    design = np.column_stack([np.ones(len(place)), place - place[target]])
    ridge = np.diag([1e-6, 0.3 * tiles.window**2, 0.3 * tiles.window**2]) * weight.sum()
    return np.linalg.solve(design.T @ (weight[:, None] * design) + ridge, design.T @ (weight[:, None] * slope))[0]


def _modelled(tiles: Tiles) -> np.ndarray:
    """Signs [seeds, n] by slopes of simple forms: bowls and saddles about points, slopes, folds about lines."""
    u, v = tiles.u, tiles.v
    models = []
    for u0 in (-0.6, 0.0, 0.6):
        for v0 in (-0.6, 0.0, 0.6):
            models += [(u - u0, v - v0), (u - u0, v0 - v), (v - v0, u - u0)]
    for angle in np.pi * np.arange(4) / 4:
        across = np.array([np.cos(angle), np.sin(angle)])
        models.append(np.outer(across, np.ones(len(u))))
        for line in (-0.5, 0.0, 0.5):
            models.append(np.outer(across, u * across[0] + v * across[1] - line))
    rises = np.array([np.stack(model) for model in models])
    return np.where(np.einsum("skn,nk->sn", rises, tiles.slopes) >= 0, 1.0, -1.0)
