"""What the errors of held numbers do to a measured one, all at once and whatever their size: draws and Sobol's indices.

A fit holds numbers (`known`) that are not exact. Each draw puts normal errors on all of them and fits the noise-free
image with these (`measurement`). The variance of what is found is split by Sobol's indices: of first order, the share
of a number by itself, and total, with what it does together with others (estimators of Saltelli et al. 2010 and Jansen
1999 on scrambled Sobol points). Slopes alone, as `sensitivity` has them, miss what goes with the square (a tilt about
zero), and what two errors do together.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from scipy.stats import norm, qmc

from fitting.parameters import Deviations, Knob, check_not_free, chosen, knobs, relative_or_absolute_sd
from fitting.studies import draws_file
from fitting.studies.fisher import FREE, fine_nodes
from fitting.studies.gauss_newton import problem, solve
from fitting.studies.refusal import NotConvergedError
from fitting.studies.sensitivities import free_beside, sensitivity
from newtonjax import __version__
from newtonjax.benches import scene_text
from newtonjax.scene import Camera, Scene

# Pixels of the images of a batch, about; draws at least; samples of the bootstrap.
_PIXELS, _LEAST, _RESAMPLES = 1 << 20, 32, 1000


@dataclass(frozen=True)
class Share:
    """What one number leaves uncertain.

    - `name`, `unit`, `sd`: of the number.
    - `slope_sd`: of the target, by its slope alone [unit of the target].
    - `first`, `total`: Sobol's indices, of first order and total; `first_range`, `total_range`: 95 % of each, by
      bootstrap over the draws (percentiles), which takes them for independent ones.
    """

    name: str
    unit: str
    sd: float
    slope_sd: float
    first: float
    first_range: tuple[float, float]
    total: float
    total_range: tuple[float, float]


@dataclass(frozen=True)
class Spread:
    """What `spread` found. `str()` is a table, the largest total index first.

    - `target`, `unit`, `value`: of the measured number; `free`: what is found beside it.
    - `sd`, `shift`: standard deviation of the target over the draws, and its mean less the value [unit]; `slope_sd`:
      the deviation that slopes alone predict.
    - `shares`: by number; `draws`: one row a fit, what was held [units], and `found`: the target there; `seed`.
    """

    target: str
    unit: str
    value: float
    free: tuple[str, ...]
    sd: float
    shift: float
    slope_sd: float
    shares: tuple[Share, ...]
    draws: dict[str, Float[np.ndarray, " fits"]]
    found: Float[np.ndarray, " fits"]
    seed: int

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        lines = [
            f"{self.target} = {self.value:.6g}{unit}: errors of held numbers leave sd {self.sd:.3g}{unit} and move the "
            f"mean by {self.shift:+.2g}{unit} ({len(self.found)} fits; by slopes alone sd {self.slope_sd:.3g}{unit})",
            f"{'':<14} {'known to':>10} {'unit':<6} {'first order':>11} {'its 95 %':>16} {'total':>7} {'its 95 %':>16}",
        ]
        for share in self.shares:
            first, total = (f"{low:.3f} to {high:.3f}" for low, high in (share.first_range, share.total_range))
            row = f"{share.name:<14} {share.sd:>10.3g} {share.unit:<6} {share.first:>11.3f} {first:>16}"
            lines.append(f"{row} {share.total:>7.3f} {total:>16}")
        if any(high - low > 1 for share in self.shares for low, high in (share.first_range, share.total_range)):
            lines.append("some shares are not told by so few draws: take more")
        return "\n".join(lines)


def spread(
    scene: Scene,
    camera: Camera,
    known: Deviations,
    target: str = "radius",
    free: Sequence[str] = FREE,
    *,
    draws: int = 128,
    seed: int = 0,
    noise: float | None = None,
    keep: str | Path | None = None,
    report: Callable[[int, int], object] | None = None,
) -> Spread:
    """How a measured number spreads, where the numbers that its fit holds are known to standard deviations only.

    Args:
      scene, camera: where; one gap with two faces. A camera of few pixels over the same field tells nearly the same.
      known: standard deviations of numbers of `knobs` that the fit holds, in their units or, as "0.1%", of their
        value. Their errors are normal and independent; of a number that is positive, at most a quarter of it.
      target: the number that is measured; free: what the fit finds beside it.
      draws: a power of two, 32 or more; with n numbers draws (n + 2) fits are made. seed: of draws and bootstrap.
      noise: as in `information`; it sets the weights of pixels, the images are free of noise.
      keep: a NetCDF file that holds every fit as soon as its batch is made; fits of the same study that it has already
        are not made again.
      report: called with the fits that are made and their number.

    Raises ValueError for numbers that the scene does not have, that the fit finds, or of no deviation, and for a file
    of another study; NotConvergedError, a ValueError, where a fit does not converge, with the numbers that it held.

    """
    every_knob = knobs(scene, camera)
    free = free_beside(target, free, every_knob)
    sds = errors(every_knob, known, free, draws)
    numbers = chosen(every_knob, tuple(known))
    slopes = {part.name: part.slope for part in sensitivity(scene, camera, target, free=free, noise=noise).neglected}
    centre = np.array([knob.value for knob in numbers.values()])
    rows = centre + np.array(list(sds.values())) * _unit_rows(len(sds), draws, seed)
    # Image and model on the same nodes: what these leave out cancels.
    method = fine_nodes(scene, camera, 1e-6, 5)
    study = {
        "scene": scene_text(scene, camera),
        "known": ", ".join(f"{name} {sd!r}" for name, sd in sds.items()),
        "fit": f"{', '.join(free)}; noise {noise}; {method}; {draws} draws of seed {seed}; newtonjax {__version__}",
    }
    file = None
    if keep is not None:
        units = {name: every_knob[name].unit for name in (*sds, target)}
        file = draws_file.Kept(Path(keep), dict(zip(sds, rows.T, strict=True)), target, units, study)
    fits = _Fits(scene, camera, tuple(sds), free, noise, method.nodes)
    targets = _made(fits, rows, file, report or (lambda *_: None))
    value = every_knob[target].value
    shares = _shares(targets.reshape(-1, draws), seed)
    parts = [
        Share(name, every_knob[name].unit, sd, abs(slopes[name]) * sd, *share)
        for (name, sd), share in zip(sds.items(), shares, strict=True)
    ]
    return Spread(
        target,
        every_knob[target].unit,
        value,
        tuple(name for name in free if name != target),
        float(np.std(targets[: 2 * draws], ddof=1)),
        float(np.mean(targets[: 2 * draws]) - value),
        float(np.linalg.norm([part.slope_sd for part in parts])),
        tuple(sorted(parts, key=lambda part: -part.total)),
        dict(zip(sds, rows.T, strict=True)),
        targets,
        seed,
    )


def errors(every_knob: dict[str, Knob], stated: Deviations, free: tuple[str, ...], draws: int) -> dict[str, float]:
    """Standard deviations by name [unit of the number]; refuses as `spread` does what it cannot study."""
    if not (isinstance(draws, int | np.integer) and draws >= _LEAST and draws & (draws - 1) == 0):
        raise ValueError(f"draws is {draws!r}; allowed: a power of two from {_LEAST} on, such as 128")
    check_not_free(stated, free)
    sds = {}
    for name, knob in chosen(every_knob, tuple(stated)).items():
        share, value = relative_or_absolute_sd(knob, stated[name])
        sds[name] = value * abs(knob.value) if share else value
        if not sds[name] > 0:
            raise ValueError(f"known: {name} is {stated[name]!r}, which leaves nothing open; allowed: above zero")
        if knob.positive and sds[name] > abs(knob.value) / 4:
            raise ValueError(f"known: {name} is {stated[name]!r}; allowed: at most a quarter of it, {knob.value:.6g}")
    return sds


def _unit_rows(count: int, draws: int, seed: int) -> Float[np.ndarray, "fits names"]:
    """Standard normal numbers: draws A, draws B, and for each number A with that number from B."""
    points = norm.ppf(qmc.Sobol(2 * count, rng=seed).random(draws))
    first, second = points[:, :count], points[:, count:]
    mixed = [np.where(np.arange(count) == k, second, first) for k in range(count)]
    return np.concatenate([first, second, *mixed])


def indices(targets: Float[np.ndarray, "... blocks draws"]) -> tuple[np.ndarray, np.ndarray]:
    """Sobol's indices, of first order and total [... numbers], from what was found at A, at B, and at the mixtures."""
    first, second, mixed = targets[..., :1, :], targets[..., 1:2, :], targets[..., 2:, :]
    mean, variance = (of(targets[..., :2, :], axis=(-2, -1))[..., None, None] for of in (np.mean, np.var))
    scale = np.where(variance > 0, variance, 1.0)[..., 0]
    first_order = np.mean((second - mean) * (mixed - first), axis=-1) / scale
    return first_order, np.mean((mixed - first) ** 2, axis=-1) / (2 * scale)


def _shares(targets: Float[np.ndarray, "blocks draws"], seed: int):
    """For each number its two indices, each with 95 % of it by bootstrap."""
    draws = targets.shape[1]
    sample = np.random.default_rng(seed).integers(draws, size=(_RESAMPLES, draws))
    ranges = [
        np.percentile(resampled, [2.5, 97.5], axis=0) for resampled in indices(np.moveaxis(targets[:, sample], 0, 1))
    ]
    for k, (first_order, total) in enumerate(zip(*indices(targets), strict=True)):
        first_range, total_range = (
            (float(low), float(high)) for low, high in (resampled[:, k] for resampled in ranges)
        )
        yield float(first_order), first_range, float(total), total_range


class _Fits:
    """Fits of the scene's own image with other numbers held, a batch at a time."""

    def __init__(self, scene, camera, names: tuple[str, ...], free: tuple[str, ...], noise, nodes: int):
        self.names, self.batch = names, max(1, min(32, _PIXELS // (camera.shape[0] * camera.shape[1])))
        numbers = chosen(knobs(scene, camera), (*free, *names))
        target, *_ = free
        self._target, self._held = numbers[target], [numbers[name] for name in names]
        self._problem = problem(scene, camera, list(numbers.values()), len(free), noise, nodes)

    def __call__(self, rows: Float[np.ndarray, "rows names"]) -> Float[np.ndarray, " rows"]:
        """The target at up to `batch` rows of held numbers; NaN where a fit does not converge."""
        values, scales = (
            np.array(each) for each in zip(*[(knob.value, knob.scale) for knob in self._held], strict=True)
        )
        solution = solve(self._problem, self._problem.image, (rows - values) / scales)
        return self._target.value + self._target.scale * solution.steps[:, 0]


def _made(fits: _Fits, rows, file: "draws_file.Kept | None", report) -> Float[np.ndarray, " fits"]:
    """The target at every row; batch by batch what is made is kept."""
    targets = np.zeros(0) if file is None else file.found
    while len(targets) < len(rows):
        batch = rows[len(targets) : len(targets) + fits.batch]
        values = fits(batch)
        if (failed := np.flatnonzero(~np.isfinite(values))).size:
            row = ", ".join(f"{name} {value:.6g}" for name, value in zip(fits.names, batch[failed[0]], strict=True))
            raise NotConvergedError(f"the fit with {row} (SI units) does not converge: give smaller deviations")
        targets = np.concatenate([targets, values])
        if file is not None:
            file.write(targets)
        report(len(targets), len(rows))
    return targets
