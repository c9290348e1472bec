"""The fits of `fitting.studies.gauss_newton` for JAX's transformations, which hide the numbers of an image."""

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from fitting.studies.electrons import Moves, photoelectrons
from fitting.studies.gauss_newton import ROUNDING, SETTLED, STAGES, STEPS, Problem, Slopes
from newtonjax.fields import split, synthesize
from newtonjax.methods import Chebyshev
from newtonjax.verbs import from_coefficients


def solve(problem: Problem, data, held) -> tuple[Array, Array, Array]:
    """Steps of the free numbers; misfit; 1 where the fit converged, else 0."""
    return _solve(*_arrays(problem), data, held, moves=problem.moves, nodes=problem.nodes)


def slopes(problem: Problem, data, steps, held) -> Slopes:
    """As `gauss_newton.slopes`."""
    return _slopes(*_arrays(problem), data, steps, held, moves=problem.moves, nodes=problem.nodes)


def _arrays(problem: Problem):
    return problem.scene, problem.camera, jnp.asarray(problem.scales), jnp.asarray(problem.weight)


@partial(jax.jit, static_argnames=("moves", "nodes"))
def _solve(scene, camera, scales, weight, data, held, *, moves: Moves, nodes: int):
    # As a program within the program it is traced once, for all its uses.
    of_steps, count = jax.jit(photoelectrons(scene, camera, moves, scales, Chebyshev(nodes))), len(moves) - len(held)

    def equations(at, off):
        return from_coefficients(of_steps, jnp.concatenate([at, off]), camera.shape, data, weight)

    stages = _stages(of_steps, held, count) if len(held) else jnp.array(0)
    whole = jnp.maximum(stages, 1).astype(float)

    def step(state):
        stage, at, taken = state
        made = equations(at, held * (stage / whole))
        matrix = made.matrix[:count, :count]
        move = _least(matrix, made.gradient[:count])
        at = at - move
        settled = jnp.abs(move).max() <= SETTLED * jnp.maximum(jnp.abs(at).max(), 1e-2)
        # The fringes of the next stage are met where this one's slopes put them: else it may miscount them.
        follow = _least(matrix, made.matrix[:count, count:] @ held) / whole
        at = jnp.where(settled & (stage < stages), at - follow, at)
        return stage + settled.astype(int), at, jnp.where(settled, 0, taken + 1)

    start = (jnp.array(0), jnp.zeros(count), jnp.array(0))
    stage, at, _ = jax.lax.while_loop(lambda s: (s[0] <= stages) & (s[2] < STEPS), step, start)
    made = equations(at, held)
    good = (stage > stages) & _is_determined(made.matrix[:count, :count])
    return jnp.where(good, at, jnp.nan), made.misfit, good.astype(float)


@partial(jax.jit, static_argnames=("moves", "nodes"))
def _slopes(scene, camera, scales, weight, data, steps, held, *, moves: Moves, nodes: int) -> Slopes:
    of_steps, count = jax.jit(photoelectrons(scene, camera, moves, scales, Chebyshev(nodes))), len(steps)

    def gradient(place):
        made = from_coefficients(of_steps, place, camera.shape, data, weight).gradient
        return made[:count], made

    place = jnp.concatenate([steps, held])
    matrix, made = jax.jacfwd(gradient, has_aux=True)(place)
    inverse = _least(matrix[:, :count], jnp.eye(count))
    table, push = jax.linearize(of_steps, place)
    image, push_image = jax.linearize(lambda table: synthesize(table, camera.shape), table)
    images = jax.vmap(lambda along: push_image(push(along)))(jnp.eye(len(place))[:count])
    by_image, by_held = jnp.tensordot(inverse, images, 1) * weight, -inverse @ matrix[:, count:]
    misfit_by_image = weight * (data - image) + jnp.tensordot(made[:count], by_image, 1)
    return Slopes(by_image, by_held, misfit_by_image, made[count:] + made[:count] @ by_held)


def _stages(of_steps, held, count: int):
    """In how many stages what is held moves the fringes by at most half a turn each."""
    still = jnp.zeros(count + len(held))
    changes = split(list(jax.jvp(of_steps, (still,), (still.at[count:].set(held),))[1]))[2]
    turns = jnp.max(jnp.stack([jnp.abs(change).sum() for change in changes]))
    return jnp.clip(jnp.ceil(2 * turns), 1, STAGES).astype(int)


def _is_determined(matrix) -> Bool[Array, ""]:
    """Whether normal equations tell every number."""
    size = jnp.diag(matrix)
    unit = 1 / jnp.sqrt(jnp.where(size > 0, size, 1.0))
    least = jnp.linalg.eigvalsh(matrix * jnp.outer(unit, unit))[0]
    return (least > ROUNDING * len(matrix)) & jnp.all(size > 0)


def _least(matrix, right):
    """Matrix x = right by least squares: of what is not determined it takes nothing."""
    size = jnp.sqrt(jnp.maximum(jnp.abs(jnp.diag(matrix)), 1e-300))
    by = size.reshape(-1, *[1] * (right.ndim - 1))
    return jnp.linalg.lstsq(matrix / jnp.outer(size, size), right / by, rcond=1e-12)[0] / by
