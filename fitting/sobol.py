"""What the errors of held numbers do to a measured one, all at once and whatever their size: draws and Sobol's indices.

A fit holds numbers (`known`) that are not exact. Each draw puts normal errors on all of them and fits the noise-free
image with these (`measurement`). The variance of what is found is split by Sobol's indices (Saltelli et al. 2010, by
SciPy): the share of each number by itself, and in all, with what it does together with others. Slopes alone, as
`sensitivity` has them, miss what goes with the square (a tilt about zero), and what two errors do together.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy.stats import norm, sobol_indices

from fitting import draws_file
from fitting.fisher import FREE, fine_nodes
from fitting.implicit import measurement
from fitting.knobs import Knob, chosen, knobs
from fitting.known import Known, deviation, require_held
from fitting.refusal import UndeterminedError
from fitting.sensitivities import free_beside, sensitivity
from newtonjax.camera import Camera
from newtonjax.files import scene_text
from newtonjax.precision import x64
from newtonjax.rendering import render
from newtonjax.scene import Scene

# Pixels of the images of a batch, about; of the bootstrap of the indices: samples.
_PIXELS, _RESAMPLES = 1 << 20, 200


@dataclass(frozen=True)
class Share:
    """What one number leaves uncertain.

    - `name`, `unit`, `sd`: of the number.
    - `slope_sd`: of the target, by its slope alone [unit of the target].
    - `alone`, `together`: Sobol's indices, of first order and total; `alone_range`, `together_range`: 95 % of each,
      by bootstrap.
    """

    name: str
    unit: str
    sd: float
    slope_sd: float
    alone: float
    alone_range: tuple[float, float]
    together: float
    together_range: tuple[float, float]


@dataclass(frozen=True)
class Spread:
    """What `spread` found. `str()` is a table, the largest share first.

    - `target`, `unit`, `value`: of the measured number.
    - `sd`, `shift`: standard deviation of the draws, and their mean less the value [unit]; `slope_sd`: the deviation
      that slopes alone predict.
    - `shares`: by number; `draws`: one row a draw, what was held [units], and `found`: the target there.
    """

    target: str
    unit: str
    value: float
    sd: float
    shift: float
    slope_sd: float
    shares: tuple[Share, ...]
    draws: dict[str, Float[np.ndarray, " draws"]]
    found: Float[np.ndarray, " draws"]

    def __str__(self) -> str:
        lines = [
            f"{self.target} = {self.value:.6g} {self.unit}: held numbers leave sd {self.sd:.3g} {self.unit} and move "
            f"the mean by {self.shift:+.2g} ({len(self.found)} fits; by slopes alone: sd {self.slope_sd:.3g})",
            f"{'':<14} {'known to':>10} {'unit':<6} {'alone':>7} {'95 % of it':>16} {'in all':>7} {'95 % of it':>16}",
        ]
        for one in self.shares:
            alone, together = (f"{low:.3f} to {high:.3f}" for low, high in (one.alone_range, one.together_range))
            lines.append(
                f"{one.name:<14} {one.sd:>10.3g} {one.unit:<6} {one.alone:>7.3f} {alone:>16} {one.together:>7.3f} "
                f"{together:>16}"
            )
        return "\n".join(lines)


def spread(
    scene: Scene,
    camera: Camera,
    known: Known,
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
      known: standard deviations of numbers of `knobs.knobs` that the fit holds, in their units or, as "0.1%", of their
        value. Their errors are normal and independent.
      target: the number that is measured; free: what the fit finds beside it.
      draws: a power of two; with n numbers draws (n + 2) fits are made. seed: of the draws.
      noise: as in `information`; it sets the weights of pixels, the images are free of noise.
      keep: a NetCDF file that holds every draw as soon as its batch is made; draws of the same study that it has
        already are not made again.
      report: called with the fits that are made and their number.

    Raises ValueError for numbers that the scene does not have, that the fit finds, or of no deviation, and for a file
    of another study; UndeterminedError, a ValueError, where a fit does not converge, with the errors that it had.

    """
    there = knobs(scene, camera)
    free = free_beside(target, free, there)
    sds = errors(there, known, free, draws)
    numbers = chosen(there, tuple(known))
    local = sensitivity(scene, camera, target, free=free, noise=noise)
    slopes = {one.name: one.slope for one in local.neglected}
    units = {target: there[target].unit, **{name: knob.unit for name, knob in numbers.items()}}
    study = {
        "scene": scene_text(scene, camera),
        "known": ", ".join(f"{name} {sd!r}" for name, sd in sds.items()),
        "fit": f"{', '.join(free)}; noise {noise}; {draws} draws of seed {seed}",
    }
    with x64():
        fits = _Fits(scene, camera, tuple(known), free, noise)
        made = _Made(fits, target, None if keep is None else Path(keep), units, study, report or (lambda *_: None))
        made.total = draws * (len(known) + 2)
        indices = sobol_indices(
            func=made, n=draws, dists=[norm(numbers[name].value, sd) for name, sd in sds.items()], rng=seed
        )
    shares = _shares(indices, sds, units, slopes)
    independent = made.found[: 2 * draws]
    value = there[target].value
    return Spread(
        target,
        units[target],
        value,
        float(np.std(independent, ddof=1)),
        float(np.mean(independent) - value),
        float(np.linalg.norm([one.slope_sd for one in shares])),
        shares,
        dict(zip(known, np.array(made.rows).T, strict=True)),
        np.array(made.found),
    )


def errors(there: dict[str, Knob], known: Known, free: tuple[str, ...], draws: int) -> dict[str, float]:
    """Standard deviations by name [unit of the number]; refuses as `spread` does what it cannot study."""
    if not (isinstance(draws, int | np.integer) and draws >= 2 and draws & (draws - 1) == 0):
        raise ValueError(f"draws is {draws!r}; allowed: a power of two, such as 128")
    require_held(known, free)
    sds = {}
    for name, knob in chosen(there, tuple(known)).items():
        share, value = deviation(name, known[name])
        sds[name] = value * abs(knob.value) if share else value
        if not sds[name] > 0:
            raise ValueError(f"known: {name} is {known[name]!r}, which leaves nothing open; allowed: above zero")
    return sds


def _shares(indices, sds: dict[str, float], units: dict[str, str], slopes: dict[str, float]) -> tuple[Share, ...]:
    """Of what SciPy found, the largest first."""
    bounds = indices.bootstrap(confidence_level=0.95, n_resamples=_RESAMPLES)

    def pair(interval, k: int) -> tuple[float, float]:
        return float(np.atleast_1d(interval.low)[k]), float(np.atleast_1d(interval.high)[k])

    shares = [
        Share(
            name,
            units[name],
            sd,
            abs(slopes[name]) * sd,
            float(np.atleast_1d(indices.first_order)[k]),
            pair(bounds.first_order.confidence_interval, k),
            float(np.atleast_1d(indices.total_order)[k]),
            pair(bounds.total_order.confidence_interval, k),
        )
        for k, (name, sd) in enumerate(sds.items())
    ]
    return tuple(sorted(shares, key=lambda one: -one.together))


class _Fits:
    """Fits of the scene's own image with other numbers held, a batch at a time."""

    def __init__(self, scene, camera, names: tuple[str, ...], free: tuple[str, ...], noise):
        # Image and model on the same nodes: what these leave out cancels.
        method = fine_nodes(scene, camera, 1e-6, 5)
        measure = measurement(scene, camera, free, noise=noise, method=method)
        self.batch = max(1, min(32, _PIXELS // (camera.shape[0] * camera.shape[1])))
        image = render(scene, camera, method)

        def one(row):
            return measure(image, **dict(zip(names, row, strict=True))).numbers[free[0]]

        self._all = jax.vmap(one)  # of a function that is compiled: what it is compiled to is kept for the next study

    def __call__(self, rows: Float[np.ndarray, "rows names"]) -> Float[np.ndarray, " rows"]:
        """The target at up to `batch` rows of held numbers."""
        full = np.concatenate([rows, np.repeat(rows[:1], self.batch - len(rows), axis=0)])
        return np.asarray(self._all(jnp.asarray(full)))[: len(rows)]


class _Made:
    """The function that SciPy draws from: of columns of numbers, in order; what is made is kept."""

    def __init__(self, fits: _Fits, target, keep: Path | None, units, study, report):
        self.fits, self.target, self.keep = fits, target, keep
        self.units, self.study, self.report = units, study, report
        self.names = tuple(name for name in units if name != target)
        self.before = {} if keep is None else draws_file.read(keep, study)
        self.rows: list[np.ndarray] = []
        self.found: list[float] = []
        self.total = 0

    def __call__(self, numbers: Float[np.ndarray, "names rows"]) -> Float[np.ndarray, " rows"]:
        rows, begin = list(numbers.T), len(self.found)
        there = len(self.before.get(self.target, ()))
        while len(self.found) < begin + len(rows):
            at = len(self.found)
            batch = np.array(rows[at - begin : at - begin + self.fits.batch])
            known = at + len(batch) <= there
            values = self.before[self.target][at : at + len(batch)] if known else self.fits(batch)
            self.rows += list(batch)
            self.found += values.tolist()
            if self.keep is not None and not known:
                columns = dict(zip(self.names, np.array(self.rows).T, strict=True))
                draws_file.write(self.keep, {**columns, self.target: np.array(self.found)}, self.units, self.study)
            self.report(len(self.found), self.total)
            if (lost := np.flatnonzero(~np.isfinite(values))).size:
                row = ", ".join(f"{name} {value:.6g}" for name, value in zip(self.names, batch[lost[0]], strict=True))
                raise UndeterminedError(f"the fit with {row} does not converge: the errors are too large for it")
        return np.array(self.found[begin:])
