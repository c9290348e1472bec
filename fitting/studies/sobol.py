"""The effect of errors of given numbers on a measured one, all at once and of any size: draws and Sobol's indices.

A fit is given numbers that are not exact. Each draw puts normal errors on all of them and fits the noise-free image
with these (`measurement`). The variance of the measured number is split by Sobol's indices: of first order, the share
of a number by itself, and total, with what it does together with others (estimators of Saltelli et al. 2010 and Jansen
1999 on scrambled Sobol points). Slopes alone, as `sensitivity` has them, miss what goes with the square (a tilt about
zero), and what two errors do together.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.stats import norm, qmc

from fitting.parameters import (
    Deviations,
    Knob,
    Progress,
    check_not_free,
    chosen,
    knobs,
    progress_of,
    relative_or_absolute_sd,
    target_first,
)
from fitting.reasons import Reason
from fitting.studies.bench_origin import says_its_bench
from fitting.studies.draws_file import DrawsFile
from fitting.studies.fisher import fine_nodes
from fitting.studies.gauss_newton import problem, solve
from fitting.studies.refusal import NotConvergedError
from fitting.studies.sensitivities import sensitivity
from fitting.studies.spread_result import Share, Spread
from newtonjax import __version__
from newtonjax.benches import scene_text
from newtonjax.methods import Chebyshev
from newtonjax.numerics import path_of, require_whole, shown
from newtonjax.scene import Camera, Scene

# Pixels of the images of a batch, about; draws at least; samples of the bootstrap.
_PIXELS, _LEAST, _RESAMPLES = 1 << 20, 32, 1000


@says_its_bench
def spread(
    scene: Scene,
    camera: Camera,
    sd: Deviations,
    *,
    target: str | None = None,
    free: Sequence[str] | None = None,
    draws: int = 128,
    seed: int = 0,
    noise: float | None = None,
    path: str | Path | None = None,
    progress: Progress = None,
) -> Spread:
    """How a measured number scatters, where the numbers that its fit is given are known to standard deviations only.

    Args:
      scene, camera: where; one gap with two faces. A camera of few pixels over the same field gives nearly the same.
      sd: standard deviations of given numbers of the bench, in their units or, as "0.1%", of their
        value. Their errors are normal and independent; of a number that is positive, at most a quarter of it.
      target: the number that is measured; free: what the fit determines with it; defaults as in `sensitivity`.
      draws: a power of two, 32 or more; with n numbers draws (n + 2) fits are made. seed: of draws and bootstrap.
      noise [incident irradiance]: as in `information`; it sets the weights of pixels, the images are free of noise.
      path: a NetCDF file that holds every fit as soon as its batch is made; fits of the same study that it has already
        are not made again.
      progress: True for a bar on the terminal, or a function of (fits made, their number).

    Raises ValueError for numbers that the scene does not have, that are free, or of no deviation, and for a file
    of another study; NotConvergedError, a ValueError, where a fit does not converge, with the numbers given to it.

    """
    study = _Study(locals())
    target, knob = study.target, study.knobs[study.target]
    slopes_of_fit = sensitivity(scene, camera, target=target, free=study.free, noise=noise)
    slopes = {part.name: part.slope for part in slopes_of_fit.neglected}
    file = None if study.path is None else study.file(study.path)
    fits = _BatchedFits(scene, camera, tuple(study.sds), study.free, noise, study.method.nodes)
    with progress_of(progress, "fitting") as done:
        targets = _run_batches(fits, study.rows, file, done)
    shares = _shares(targets.reshape(-1, draws), seed)
    parts = [
        Share(name, study.knobs[name].unit, size, abs(slopes[name]) * size, *share)
        for (name, size), share in zip(study.sds.items(), shares, strict=True)
    ]
    warnings = []
    if any(high - low > 1 for share in parts for low, high in (share.first_range, share.total_range)):
        warnings.append(Reason.VARIANCE_NOT_RESOLVED())
    return Spread(
        target,
        knob.unit,
        knob.value,
        tuple(study.beside),
        float(np.std(targets[: 2 * draws], ddof=1)),
        float(np.mean(targets[: 2 * draws]) - knob.value),
        float(np.linalg.norm([part.slope_sd for part in parts])),
        tuple(sorted(parts, key=lambda part: -part.total)),
        dict(zip(study.sds, study.rows.T, strict=True)),
        targets,
        seed,
        warnings=warnings,
    )


def check_spread(*args: Any, **kwargs: Any) -> None:
    """Raise ValueError, before the work starts, where `spread` would for its numbers, or for the file that is there.

    The arguments are those of `spread`.
    """
    bound = inspect.signature(spread).bind(*args, **kwargs)
    bound.apply_defaults()
    study = _Study(bound.arguments)
    if study.path is not None and study.path.exists():
        study.file(study.path)


class _Study:
    """What the arguments of `spread`, by name, ask for: checked, with the given numbers of every fit.

    Raises ValueError as `spread` does.
    """

    def __init__(self, arguments: Mapping[str, Any]):
        self.scene, self.camera, self.noise = (arguments[name] for name in ("scene", "camera", "noise"))
        self.draws, self.seed = arguments["draws"], arguments["seed"]
        self.path = None if arguments["path"] is None else path_of(arguments["path"])
        self.knobs: dict[str, Knob] = knobs(self.scene, self.camera)
        require_whole("seed", self.seed, 0, 2**32 - 1)
        self.free = target_first(self.knobs, arguments["target"], arguments["free"])
        self.target, *self.beside = self.free
        self.sds = _checked_sds(self.knobs, arguments["sd"], self.free, self.draws)

    @cached_property
    def rows(self) -> Float[np.ndarray, "fits numbers"]:
        """The given numbers of every fit."""
        centre = np.array([self.knobs[name].value for name in self.sds])
        return centre + np.array(list(self.sds.values())) * _unit_rows(len(self.sds), self.draws, self.seed)

    @cached_property
    def method(self) -> Chebyshev:
        """Of image and model, on the same nodes: what these leave out cancels."""
        return fine_nodes(self.scene, self.camera, 1e-6, 5)

    def file(self, path: Path) -> DrawsFile:
        """The file of its draws. Raises ValueError for one that holds draws of another study."""
        known = ", ".join(f"{name} {size!r}" for name, size in self.sds.items())
        draws = f"{self.draws} draws of seed {self.seed}"
        fit = f"{', '.join(self.free)}; noise {self.noise}; {self.method}; {draws}; newtonjax {__version__}"
        study = {"scene": scene_text(self.scene, self.camera), "known": known, "fit": fit}
        units = {name: self.knobs[name].unit for name in (*self.sds, self.target)}
        columns = dict(zip(self.sds, self.rows.T, strict=True))
        return DrawsFile(path, columns, self.target, units, study)


def _checked_sds(every_knob: dict[str, Knob], sd: Deviations, free: tuple[str, ...], draws: int) -> dict[str, float]:
    """Standard deviations by name [unit of the number]; refuses as `spread` does what it cannot study."""
    if not (isinstance(draws, int | np.integer) and draws >= _LEAST and draws & (draws - 1) == 0):
        raise ValueError(f"draws is {shown(draws)}; allowed: a power of two from {_LEAST} on, such as 128")
    check_not_free(sd, free)
    sds = {}
    for name, knob in chosen(every_knob, tuple(sd)).items():
        is_relative, size = relative_or_absolute_sd(knob, sd[name])
        sds[name] = size * abs(knob.value) if is_relative else size
        if not sds[name] > 0:
            raise ValueError(f"sd: {name} is {sd[name]!r}; allowed: a positive value")
        if knob.positive and sds[name] > abs(knob.value) / 4:
            raise ValueError(f"sd: {name} is {sd[name]!r}; allowed: at most a quarter of it, {knob.value:.6g}")
    return sds


def _unit_rows(count: int, draws: int, seed: int) -> Float[np.ndarray, "fits names"]:
    """Standard normal numbers: draws A, draws B, and for each number A with that number from B."""
    points = norm.ppf(qmc.Sobol(2 * count, rng=seed).random(draws))
    first, second = points[:, :count], points[:, count:]
    mixed = [np.where(np.arange(count) == k, second, first) for k in range(count)]
    return np.concatenate([first, second, *mixed])


def indices(targets: Float[np.ndarray, "... blocks draws"]) -> tuple[np.ndarray, np.ndarray]:
    """Sobol's indices, of first order and total [... numbers], of the target at A, at B, and at the mixtures."""
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


class _BatchedFits:
    """Fits of the scene's own image with other numbers given, a batch at a time."""

    def __init__(self, scene, camera, names: tuple[str, ...], free: tuple[str, ...], noise, nodes: int):
        self.names, self.batch = names, max(1, min(32, _PIXELS // (camera.shape[0] * camera.shape[1])))
        numbers = chosen(knobs(scene, camera), (*free, *names))
        target, *_ = free
        self._target, self._given = numbers[target], [numbers[name] for name in names]
        self._problem = problem(scene, camera, list(numbers.values()), len(free), noise, nodes)

    def __call__(self, rows: Float[np.ndarray, "rows names"]) -> Float[np.ndarray, " rows"]:
        """The target at up to `batch` rows of given numbers.

        Raises NotConvergedError with the first ones whose fit has failed when one fails.
        """
        values, scales = (
            np.array(each) for each in zip(*[(knob.value, knob.scale) for knob in self._given], strict=True)
        )
        solution = solve(self._problem, self._problem.image, (rows - values) / scales, until_failure=True)
        if (failed := np.flatnonzero(solution.ended & ~solution.converged)).size:
            row = ", ".join(f"{name} {value:.6g}" for name, value in zip(self.names, rows[failed[0]], strict=True))
            raise NotConvergedError(Reason.DRAW_NOT_CONVERGED(values=row))
        return self._target.value + self._target.scale * solution.steps[:, 0]


def _run_batches(
    fits: _BatchedFits, rows, file: DrawsFile | None, done: Callable[[int, int], object]
) -> Float[np.ndarray, " fits"]:
    """The target at every row; every batch is written to the file."""
    targets = np.zeros(0) if file is None else file.targets
    while len(targets) < len(rows):
        batch = rows[len(targets) : len(targets) + fits.batch]
        values = fits(batch)
        targets = np.concatenate([targets, values])
        if file is not None:
            file.write(targets)
        done(len(targets), len(rows))
    return targets
