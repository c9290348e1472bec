"""The No-U-Turn sampler on a fit's posterior (blackjax; the extra `nuts`)."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from fitting.sampling.density import Posterior


def run(target: Posterior, chains: int, steps: int, seed: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Points [steps, chains, dimensions], their log-densities and the mean acceptance, warm-up (a quarter) left out.

    The points are in units of the fit's own deviations, so that the mass matrix is one's own from the start; the step
    size is adapted (Hoffman and Gelman 2014, section 3.2).
    """
    try:
        import blackjax  # pyright: ignore[reportMissingImports]  # an extra
    except ImportError as error:
        raise ValueError("sampler='nuts' needs blackjax; install it: pip install 'newtonjax[nuts]'") from error
    if chains < 2:
        raise ValueError(f"walkers is {chains}; allowed: at least 2 chains")
    warm = max(steps // 4, 50)
    keys = jax.random.split(jax.random.key(seed), 3)
    starts = 0.5 * jax.random.normal(keys[0], (chains, target.dimensions))
    # blackjax's types are of its abstract algorithms, which lack what NUTS has.
    adapted: Any = blackjax.window_adaptation(blackjax.nuts, target)

    @jax.jit
    def all_chains(keys, starts):
        def one(key, start):
            first, second = jax.random.split(key)
            (state, numbers), _ = adapted.run(first, start, num_steps=warm)
            kernel: Any = blackjax.nuts(target, **numbers).step

            def step(state, key):
                state, info = kernel(key, state)
                return state, (state.position, state.logdensity, info.acceptance_rate)

            return jax.lax.scan(step, state, jax.random.split(second, steps - steps // 4))[1]

        return jax.vmap(one)(keys, starts)

    # blackjax adds numbers of unlike types, which a program may have forbidden.
    with jax.numpy_dtype_promotion("standard"):
        points, density, acceptance = all_chains(jax.random.split(keys[1], chains), starts)
    return np.swapaxes(np.asarray(points), 0, 1), np.asarray(density).T, float(jnp.mean(acceptance))
