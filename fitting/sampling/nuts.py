"""The No-U-Turn sampler on a fit's posterior (blackjax; the extra `nuts`)."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np


def run(density: Callable, starts: np.ndarray, steps: int, seed: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Points [steps, chains, dimensions], their log-densities and the mean acceptance, warm-up (a quarter) left out.

    `density`: of a point, for JAX; `starts`: a point for each chain [chains, dimensions].

    The points are in units of the fit's own deviations, so that the mass matrix is one's own from the start; the step
    size is adapted (Hoffman and Gelman 2014, section 3.2).
    """
    try:
        import blackjax  # pyright: ignore[reportMissingImports]  # an extra
    except ImportError as error:
        raise ValueError("sampler='nuts' needs blackjax; install it: pip install 'newtonjax[nuts]'") from error
    warm, chains = max(steps // 4, 50), len(starts)
    keys = jax.random.split(jax.random.key(seed), 3)
    # blackjax's types are of its abstract algorithms, which lack what NUTS has.
    adapted: Any = blackjax.window_adaptation(blackjax.nuts, density)

    @jax.jit
    def all_chains(keys, starts):
        def one(key, start):
            first, second = jax.random.split(key)
            (state, numbers), _ = adapted.run(first, start, num_steps=warm)
            kernel: Any = blackjax.nuts(density, **numbers).step

            def step(state, key):
                state, info = kernel(key, state)
                return state, (state.position, state.logdensity, info.acceptance_rate)

            return jax.lax.scan(step, state, jax.random.split(second, steps - steps // 4))[1]

        return jax.vmap(one)(keys, starts)

    # blackjax adds numbers of unlike types, which a program may have forbidden.
    with jax.numpy_dtype_promotion("standard"):
        points, density, acceptance = all_chains(jax.random.split(keys[1], chains), jnp.asarray(starts))
    return np.swapaxes(np.asarray(points), 0, 1), np.asarray(density).T, float(jnp.mean(acceptance))
