"""Forms of a picture of few fringes, without a start: many draws on a small picture, the best followed, all at once.

d = E (1 + V cos 2πφ): one lamp lights both surfaces, so that background and contrast are one polynomial E, with one
visibility V <= 1. Of a picture of less than ten fringes on a few thousand pixels all draws together take a fraction of
a second, and what comes of them shows which other forms explain it as well.
"""

from typing import NamedTuple

import numpy as np

from fitting.irregularity.lit_disc import LitDisc
from fitting.irregularity.moments import products_at
from fitting.irregularity.zernike import noll, terms_at

TERMS = 15
# Draws, those that are followed, those that are followed to their ends, and steps of both.
_FOLLOWED, _FINISHED = 120, 40
_FIRST_STEPS, _LAST_STEPS = 6, 16
# Turns that the phase may move in a step.
_STEP = 0.4
_LEAST_VISIBILITY = 0.05


class Draws(NamedTuple):
    """What forms are drawn from: how many, power up to so many fringes, sizes of the terms beyond, turns rms."""

    number: int
    power: float
    tilts: tuple[float, ...]
    astigmatism: tuple[float, ...]
    third: tuple[float, ...]
    fourth: tuple[float, ...]


# Few fringes, and uneven surfaces.
SMOOTH = Draws(3000, 6.0, (0.1, 0.3, 1.2), (0.05, 0.2, 0.6), (0.02, 0.1, 0.25), (0.01, 0.05, 0.12))
UNEVEN = Draws(6000, 6.0, (0.1, 0.3), (0.2, 0.5, 0.8), (0.1, 0.3, 0.5), (0.05, 0.15, 0.3))


class Optima(NamedTuple):
    """Forms [n, terms], turns, best first, power positive; visibilities and sums of squares [n]; the pixels' number."""

    forms: np.ndarray
    visibilities: np.ndarray
    squares: np.ndarray
    pixels: int


def optima_of(disc: LitDisc, draws: Draws, seed: int = 0) -> Optima:
    """The optima that draws of forms come to on a small picture."""
    sample = _Sample(disc)
    forms = _drawn(draws, np.random.default_rng(seed))
    squares, pistons, contrasts = (
        np.concatenate(part) for part in zip(*map(sample.scores, _parts(forms)), strict=True)
    )
    best = np.argsort(squares)[:_FOLLOWED]
    forms = forms[best]
    forms[:, 0] = pistons[best]
    state = sample.start(forms, contrasts[best] / sample.mean)
    state = sample.followed(state, _FIRST_STEPS, _ridge() * sample.mean**2 * len(sample.light))
    state = sample.followed(state.chosen(_FINISHED), _LAST_STEPS, np.zeros(TERMS))
    state = state.chosen(_FINISHED)
    forms = state.forms.astype(float) * np.where(state.forms[:, 3] < 0, -1, 1)[:, None]
    forms[:, 0] -= np.round(forms[:, 0])
    return Optima(forms, state.visibilities.astype(float), state.squares.astype(float), len(sample.light))


def _parts(forms: np.ndarray) -> list[np.ndarray]:
    return np.array_split(forms, max(len(forms) // 1000, 1))


def _ridge() -> np.ndarray:
    """What keeps high terms small in the first steps, as a share of the light's square."""
    orders = np.array([noll(term)[0] for term in range(1, TERMS + 1)])
    return 0.02 * np.array([0.0, 0.0, 0.3, 1.0, 2.0])[orders] * (np.arange(1, TERMS + 1) != 4)


def _drawn(draws: Draws, rng: np.random.Generator) -> np.ndarray:
    """Forms [draws, terms]: small numbers are likelier than large ones."""
    count = draws.number
    forms = np.zeros((count, TERMS))
    forms[:, 3] = np.square(rng.uniform(0, 1, count)) * draws.power / (2 * np.sqrt(3))
    for places, sizes in (((1, 2), draws.tilts), ((4, 5), draws.astigmatism)):
        size = rng.choice(sizes, count) * rng.uniform(0, 1, count)
        angle = rng.uniform(0, 2 * np.pi, count)
        forms[:, places[0]], forms[:, places[1]] = size * np.cos(angle), size * np.sin(angle)
    for part, sizes in ((slice(6, 10), draws.third), (slice(10, 15), draws.fourth)):
        normal = rng.standard_normal((count, part.stop - part.start))
        forms[:, part] = rng.choice(sizes, count)[:, None] * normal
    return forms


class _State(NamedTuple):
    """Forms [n, terms], visibilities [n], illuminations [n, k] and what they leave: squares [n]."""

    forms: np.ndarray
    visibilities: np.ndarray
    light: np.ndarray
    squares: np.ndarray

    def chosen(self, count: int) -> "_State":
        best = np.argsort(self.squares)[:count]
        return _State(*(part[best] for part in self))


class _Sample:
    """The pixels of a small picture, with the terms of form and illumination there."""

    def __init__(self, disc: LitDisc):
        u, v = disc.points()
        self.light = disc.light[disc.used]
        self.mean = float(self.light.mean())
        self.values = terms_at(u, v, TERMS).astype(np.float32)
        self.even = products_at(u, v, 2).astype(np.float32)

    def scores(self, forms: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What B + M cos 2π(φ + piston) leaves, B of degree 2 and M a number; the pistons, and M [n]."""
        unit, _ = np.linalg.qr(self.even)
        angle = 2 * np.pi * (forms.astype(np.float32) @ self.values.T)
        cosine, sine = (wave - (wave @ unit) @ unit.T for wave in (np.cos(angle), np.sin(angle)))
        light = self.light - unit @ (unit.T @ self.light)
        cc, ss, cs = (np.einsum("sn,sn->s", *pair) for pair in ((cosine, cosine), (sine, sine), (cosine, sine)))
        dc, ds = cosine @ light, sine @ light
        determinant = np.maximum(cc * ss - cs * cs, 1e-6 * cc * ss + 1e-9)
        c, s = (ss * dc - cs * ds) / determinant, (cc * ds - cs * dc) / determinant
        return light @ light - c * dc - s * ds, np.arctan2(-s, c) / (2 * np.pi), np.hypot(c, s)

    def start(self, forms: np.ndarray, visibilities: np.ndarray) -> _State:
        """The state at each form."""
        return self._lit(forms.astype(np.float32), np.clip(visibilities, 0.1, 0.95).astype(np.float32))

    def _lit(self, forms: np.ndarray, visibilities: np.ndarray) -> _State:
        """The state with the illumination that fits best: along a valley it follows the form."""
        fringes = 1 + visibilities[:, None] * np.cos(2 * np.pi * (forms @ self.values.T))
        count = self.even.shape[1]
        products = (self.even[:, :, None] * self.even[:, None, :]).reshape(len(self.light), -1)
        normal = (np.square(fringes) @ products).reshape(-1, count, count)
        trace = np.trace(normal, axis1=1, axis2=2)[:, None, None]
        normal = normal + 1e-6 * trace * np.eye(count, dtype=np.float32)
        light = np.linalg.solve(normal, ((fringes * self.light) @ self.even)[:, :, None])[:, :, 0]
        return _State(forms, visibilities, light, self._residual(forms, visibilities, light)[1])

    def _residual(self, forms: np.ndarray, visibilities: np.ndarray, light: np.ndarray):
        angle = 2 * np.pi * (forms @ self.values.T)
        residual = self.light - (light @ self.even.T) * (1 + visibilities[:, None] * np.cos(angle))
        return residual, np.square(residual).sum(axis=1)

    def followed(self, state: _State, steps: int, ridge: np.ndarray) -> _State:
        """The states after some damped steps (Levenberg 1944, Marquardt 1963) on squares with a ridge [terms]."""
        damping = np.full(len(state.forms), 1e-2, np.float32)
        cost = state.squares + np.square(state.forms) @ ridge
        for _ in range(steps):
            trial = self._moved(state, damping, ridge)
            trial_cost = trial.squares + np.square(trial.forms) @ ridge
            better = trial_cost < cost
            parts = zip(trial, state, strict=True)
            state = _State(*(np.where(better[(...,) + (None,) * (x.ndim - 1)], x, y) for x, y in parts))
            cost = np.where(better, trial_cost, cost)
            damping = np.where(better, damping / 5, np.minimum(damping * 8, 1e4)).astype(np.float32)
        return state

    def _moved(self, state: _State, damping: np.ndarray, ridge: np.ndarray) -> _State:
        columns, residual = self._columns(state)
        across = columns.transpose(0, 2, 1)
        normal = (across @ columns).astype(float)
        slope = (across @ residual[:, :, None])[:, :, 0].astype(float)
        terms, every = np.arange(TERMS), np.arange(normal.shape[1])
        normal[:, terms, terms] += ridge
        slope[:, :TERMS] -= ridge * state.forms
        diagonal = np.einsum("sii->si", normal).copy()
        floor = 1e-9 * diagonal.max(axis=1, keepdims=True)
        normal[:, every, every] = diagonal * (1 + damping[:, None]) + floor
        step = np.linalg.solve(normal, slope[:, :, None])[:, :, 0].astype(np.float32)
        largest = np.abs(step[:, :TERMS] @ self.values.T).max(axis=1)
        step *= np.minimum(1, _STEP / np.maximum(largest, 1e-9))[:, None]
        forms = state.forms + step[:, :TERMS]
        visibilities = np.clip(state.visibilities + step[:, TERMS], _LEAST_VISIBILITY, 1.0)
        return self._lit(forms, visibilities)

    def _columns(self, state: _State) -> tuple[np.ndarray, np.ndarray]:
        """How the light changes with form, visibility and illumination [n, pixels, numbers]; the residual."""
        angle = 2 * np.pi * (state.forms @ self.values.T)
        cosine, even = np.cos(angle), state.light @ self.even.T
        visibility = state.visibilities[:, None]
        fringes = 1 + visibility * cosine
        rate = -2 * np.pi * visibility * even * np.sin(angle)
        parts = [rate[:, :, None] * self.values, (even * cosine)[:, :, None], fringes[:, :, None] * self.even]
        return np.concatenate(parts, axis=2), self.light - even * fringes
