"""The fits of `fitting.studies.gauss_newton` for JAX's transformations, which hide the numbers of an image."""

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from fitting.studies.electrons import Moves, photoelectrons
from fitting.studies.gauss_newton import ROUNDING, SETTLED, STAGES, STEPS, UNSEEN, Problem, Slopes
from newtonjax.fields import product_sums, synthesize
from newtonjax.methods import Chebyshev
from newtonjax.verbs import from_changes, with_changes


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
    of_steps, free = photoelectrons(scene, camera, moves, scales, Chebyshev(nodes)), len(moves) - len(held)

    def step(state):
        stage, stages, at, steps_here, *_ = state
        place = jnp.concatenate([at, held * (stage / jnp.maximum(stages, 1))])
        # The one text of the rays, which are what there is to compile.
        table, changes = with_changes(of_steps, place)
        normal = from_changes(table, changes, camera.shape, data, weight)
        stages = jnp.where(stage + steps_here == 0, _stages(changes[free:], held), stages)
        count, matrix = jnp.maximum(stages, 1).astype(float), normal.matrix[:free, :free]
        along_held = normal.matrix[:free, free:] @ held
        move, follow = _least(matrix, jnp.stack([normal.gradient[:free], along_held], axis=1)).T
        at = at - move
        settled = jnp.abs(move).max() <= SETTLED * jnp.maximum(jnp.abs(at).max(), 1e-2)
        settled |= move @ matrix @ move <= UNSEEN**2
        # The fringes of the next stage are met where this one's slopes put them: else it may miscount them.
        at = jnp.where(settled & (stage < stages), at - follow / count, at)
        return (stage + settled.astype(int), stages, at, jnp.where(settled, 0, steps_here + 1), matrix, normal.misfit)

    def goes_on(state):
        stage, stages, _, steps_here, *_ = state
        return (stage <= stages) & (steps_here < STEPS)

    start = (jnp.array(0), jnp.array(0), jnp.zeros(free), jnp.array(0), jnp.zeros((free, free)), jnp.zeros(()))
    stage, stages, at, _, matrix, misfit = jax.lax.while_loop(goes_on, step, start)
    converged = (stage > stages) & _is_determined(matrix)
    return jnp.where(converged, at, jnp.nan), misfit, converged.astype(float)


@partial(jax.jit, static_argnames=("moves", "nodes"))
def _slopes(scene, camera, scales, weight, data, steps, held, *, moves: Moves, nodes: int) -> Slopes:
    of_steps, free = photoelectrons(scene, camera, moves, scales, Chebyshev(nodes)), len(steps)

    def changes_at(place):
        table, changes = with_changes(of_steps, place)
        return changes, (table, changes)

    second, (table, changes) = jax.jacfwd(changes_at, has_aux=True)(jnp.concatenate([steps, held]))
    by_table, bend = jax.linearize(lambda table: product_sums(table, camera.shape, data, weight).slopes, table)
    image, push = jax.linearize(lambda table: synthesize(table, camera.shape), table)
    gradient = jnp.tensordot(changes, by_table, 3)
    # Of the free numbers' gradient by every number.
    matrix = jnp.tensordot(changes[:free], jax.vmap(bend)(changes), [(1, 2, 3), (1, 2, 3)])
    matrix = matrix + jnp.einsum("afklb,fkl->ab", second[:free], by_table)
    inverse = _least(matrix[:, :free], jnp.eye(free))
    by_image, by_held = jnp.tensordot(inverse, jax.vmap(push)(changes[:free]), 1) * weight, -inverse @ matrix[:, free:]
    # What is left of the gradient, rounding, moves the misfit with the steps: at the minimum itself it is 0.
    misfit_by_image = weight * (data - image) + jnp.tensordot(gradient[:free], by_image, 1)
    return Slopes(by_image, by_held, misfit_by_image, gradient[free:] + gradient[:free] @ by_held)


def _stages(changes: Float[Array, "held 3 nodes nodes"], held: Float[Array, " held"]) -> Int[Array, ""]:
    """In how many stages what is held moves the fringes by at most half a turn each; in none where nothing is held."""
    turns = jnp.abs(jnp.tensordot(held, changes[:, 2], 1)).sum()
    return jnp.clip(jnp.ceil(2 * turns), min(len(held), 1), STAGES).astype(int)


def _is_determined(matrix) -> Bool[Array, ""]:
    """Whether normal equations determine every number."""
    size = jnp.diag(matrix)
    unit = 1 / jnp.sqrt(jnp.where(size > 0, size, 1.0))
    least = jnp.linalg.eigvalsh(matrix * jnp.outer(unit, unit))[0]
    return (least > ROUNDING * len(matrix)) & jnp.all(size > 0)


def _least(matrix, right):
    """Matrix x = right by least squares: of what is not determined it takes nothing."""
    size = jnp.sqrt(jnp.maximum(jnp.abs(jnp.diag(matrix)), 1e-300))
    by = size.reshape(-1, *[1] * (right.ndim - 1))
    return jnp.linalg.lstsq(matrix / jnp.outer(size, size), right / by, rcond=1e-12)[0] / by
