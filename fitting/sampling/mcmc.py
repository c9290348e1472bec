"""Draws from the posterior of a fit: emcee's ensemble sampler on the moments, all walkers in one call; or NUTS."""

import hashlib
import signal
import threading
from collections.abc import Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import emcee
import jax
import numpy as np

from fitting.parameters import Progress, progress_of
from fitting.photograph import FitResult
from fitting.sampling.chain import Chain, chain_of
from fitting.sampling.posterior_function import LogPosterior, evidence_of, log_posterior
from fitting.sampling.starts import starting_points
from newtonjax.numerics import path_of, require_choice, require_whole, x64

# Differential evolution (ter Braak 2006), with a jump between modes in every tenth step: a third of the stretch move's
# autocorrelation time in six dimensions (measured: 22 steps against 79). Not emcee's snooker move, whose acceptance
# takes half of the exponent that ter Braak and Vrugt (2008, eq. 8) give: it draws deviations 4 % too small.
MOVES = [(emcee.moves.DEMove(), 0.9), (emcee.moves.DEMove(gamma0=1.0), 0.1)]
# Held while a step is written to a chain's file: a program that ends then leaves a file that cannot be read.
WRITING = threading.Lock()


class OtherChainError(ValueError):
    """A file holds the chain of another fit."""


def sample(
    result: FitResult,
    *,
    walkers: int | None = None,
    steps: int = 2000,
    seed: int = 0,
    sampler: str = "emcee",
    path: str | Path | None = None,
    progress: Progress = None,
    priors: Mapping[str, Any] | None = None,
) -> Chain:
    """Draw from the posterior of a fit.

    Free are the numbers that the fit measured, and every given quantity that has a standard deviation, which is its
    normal prior; priors of the rest are flat. Background and contrast are integrated over. The noise's variance is the
    fit's, correlation included. The first quarter of the steps is burn-in and dropped. Ctrl-C keeps what is there.

    Args:
      result: of `fitting.fit`.
      walkers: of the ensemble, 32 unless given; or chains of NUTS, 4.
      steps: of every walker, burn-in included.
      seed: of the random numbers.
      sampler: "emcee", or "nuts" (Hoffman and Gelman 2014; the extra `nuts`).
      path: an HDF5 file (emcee's backend) for every step; an existing file of the same fit is continued.
      progress: True for a bar on the terminal, or a function of (steps done, their number).
      priors: of what is drawn, by the names that the report prints, in place of the fit's own: (value, standard
        deviation), the deviation also as a percentage; a frozen distribution of scipy.stats, or any object with
        `logpdf` or `log_prob` (NumPyro's); or a function of the value that gives the logarithm of a density. A prior
        is one of the named number: of "radius" in metres. Where the image contradicts it, `warnings` says so.

    Raises ValueError for a result without a fit, too few walkers or steps, a file of another fit, what is no prior,
    and priors that allow nothing near the fit.

    """
    evidence_of(result)
    require_choice("sampler", sampler, ("emcee", "nuts"))
    if sampler == "nuts" and path is not None:
        raise ValueError("path is for sampler='emcee'; leave it out with sampler='nuts'")
    require_whole("steps", steps, 8)
    require_whole("walkers", walkers, 1)
    require_whole("seed", seed, 0, 2**32 - 1)
    if sampler == "nuts" and walkers == 1:
        raise ValueError("walkers is 1; allowed: at least 2 chains")
    with x64():
        density = log_posterior(result, priors=priors)
        if sampler == "nuts":
            from fitting.sampling.nuts import run

            points = starting_points(density, 4 if walkers is None else walkers, seed, spread=0.5)
            return chain_of(density, *run(density.at_point, points, steps, seed))
        walkers, least = 32 if walkers is None else walkers, 2 * density.dimensions + 2
        if walkers < least:
            raise ValueError(f"walkers is {walkers}; allowed: at least {least} here")
        with progress_of(progress, "drawing from the posterior") as done:
            ensemble = _ensemble(density, walkers, steps, seed, path, done)
        burned = ensemble.iteration // 4
        points, log_prob = (np.asarray(get(discard=burned)) for get in (ensemble.get_chain, ensemble.get_log_prob))
        if len(points) < 8:
            raise ValueError(f"only {ensemble.iteration} steps were taken; let it run longer")
        return chain_of(density, points, log_prob, float(np.mean(ensemble.acceptance_fraction)))


def _ensemble(density: LogPosterior, walkers: int, steps: int, seed: int, path, done) -> emcee.EnsembleSampler:
    """The sampler after its steps, or those that there was time for."""
    # The sampler moves half of the walkers at a time.
    at_once = (walkers + 1) // 2
    backend = None if path is None else _backend(path_of(path), density, walkers, at_once)
    ensemble = emcee.EnsembleSampler(
        walkers,
        density.dimensions,
        partial(density, at_once=at_once),
        moves=MOVES,
        backend=backend,
        vectorize=True,
    )
    if backend is not None and ensemble.iteration:
        state = backend.get_last_sample()
    else:
        ensemble.random_state = np.random.RandomState(seed).get_state()
        state = starting_points(density, walkers, seed, at_once=at_once)
    try:
        with _between_steps() as interrupted:
            for _ in ensemble.sample(state, iterations=max(steps - ensemble.iteration, 0)):
                done(ensemble.iteration, steps)
                if interrupted():
                    raise KeyboardInterrupt
    except KeyboardInterrupt:
        if ensemble.iteration < 16:
            raise
    return ensemble


@contextmanager
def _between_steps():
    """Keep Ctrl-C until a step is done: in the middle of one emcee prints a traceback. Yields whether it was pressed.

    Only the main thread has signals; elsewhere nothing changes.
    """
    pressed = []
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    before = signal.signal(signal.SIGINT, lambda *_: pressed.append(True))
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, before)


class _WholeSteps(emcee.backends.HDFBackend):
    """A chain's file; `WRITING` is held while a step is written."""

    def save_step(self, state, accepted):
        with WRITING:
            super().save_step(state, accepted)


def _backend(file: Path, density: LogPosterior, walkers: int, at_once: int) -> emcee.backends.HDFBackend:
    """The chain's file, made anew or found to be this fit's. Raises ValueError where it is another's, or no chain."""
    import h5py

    numbers = [leaf for leaf in jax.tree.leaves(density.target) if isinstance(leaf, jax.Array | np.ndarray)]
    if density.priors:
        # A function is known by what it gives.
        numbers.append(density.log_priors(np.eye(density.dimensions), at_once))
    mark = hashlib.sha256(b"".join(np.asarray(leaf).tobytes() for leaf in numbers)).hexdigest()[:16]
    backend = _WholeSteps(str(file))
    if file.exists():
        try:
            with h5py.File(file) as there:
                before = there.attrs["fit"], tuple(there["mcmc/chain"].shape[1:])  # pyright: ignore[reportAttributeAccessIssue]  # h5py's types leave open what a name holds
        except (OSError, KeyError, AttributeError) as error:
            raise ValueError(f"{file} is not a chain written by newtonjax; give another path") from error
        if before != (mark, (walkers, density.dimensions)):
            raise OtherChainError(f"{file} holds the chain of another fit or of other walkers; give another path")
        return backend
    backend.reset(walkers, density.dimensions)
    with h5py.File(file, "a") as there:
        there.attrs["fit"] = mark
    return backend
