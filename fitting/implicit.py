"""The measured radius as a differentiable function of an image and of what is assumed about the bench.

A weighted least-squares fit ends where its gradient g(θ; image, assumed) = Jᵀ W (I - d) is zero; there
dθ = -(∂g/∂θ)⁻¹ dg, whatever led to it (the implicit function theorem; Blondel et al. 2022, Efficient and Modular
Implicit Differentiation). The second derivatives of the image are in ∂g/∂θ: it is exact for noisy images too.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from fitting.electrons import Moves, photoelectrons, weights
from fitting.fisher import FREE, fine_nodes
from fitting.knobs import chosen, knobs
from newtonjax.camera import Camera
from newtonjax.fringes import split
from newtonjax.methods import Chebyshev
from newtonjax.normal import from_coefficients
from newtonjax.precision import require_x64, x64
from newtonjax.quantities import Scalar, is_concrete
from newtonjax.scene import Scene
from newtonjax.synthesis import synthesize

# Stages by which what is assumed moves from the scene's numbers to those given: one for every half turn of the fringes,
# and at most these. Steps of Gauss and Newton in each.
_STAGES, _STEPS = 8, 12
# Of a stage the last step, over what the numbers have moved.
_SETTLED = 1e-9


class Measured(NamedTuple):
    """What a fit found.

    - `numbers`: by name, in their units; NaN where the fit did not converge, or the image does not tell them all.
    - `misfit`: half the sum of squared residuals over the pixels' noise; half the pixels' number where noise is all.
    - `converged`: to numbers that the image tells.
    """

    numbers: dict[str, Float[Array, ""]]
    misfit: Float[Array, ""]
    converged: Bool[Array, ""]


def measurement(
    scene: Scene,
    camera: Camera,
    free: Sequence[str] = FREE,
    *,
    noise: float | None = None,
    method: Chebyshev | None = None,
) -> Callable[..., Measured]:
    """A function that measures images of a bench, differentiable in the image and in what is assumed of the bench.

    It is called as `measure(image, wavelength=..., pixel_size=..., ...)`: the image [rows, columns] in incident
    irradiance, as `render` gives it or as the camera's photoelectrons over its exposure, and any numbers of
    `knobs.knobs` that are not free, where they are not the scene's, in their units. It may be transformed by `jax.jit`,
    `jax.vmap`, `jax.grad` and `jax.jacfwd`, with JAX in float64.

    Args:
      scene, camera: where the search starts, and all that is assumed; one gap with two faces.
      free: the numbers that are found.
      noise: as in `information`; the weights are those of the scene's own image.
      method: the nodes; None for as many as keep 1e-8 of the intensity, and 17 at least.

    The search is local, by Gauss and Newton's method: the image's fringes must be within half a turn of the scene's.
    What is assumed may move them by more, since the fit follows it in stages. `fit` finds rings from nothing.

    Raises ValueError for numbers that the scene does not have or that come twice, here and when called; when called,
    for an image of another shape, and RuntimeError within a transformation in float32.

    """
    there = knobs(scene, camera)
    known = chosen(there, tuple(free))
    method = fine_nodes(scene, camera) if method is None else method

    def measure(image, **assumed) -> Measured:
        if np.shape(image) != camera.shape:
            raise ValueError(f"the image has shape {np.shape(image)}; allowed: the camera's, {camera.shape}")
        if twice := set(assumed) & set(free):
            raise ValueError(f"{', '.join(sorted(twice))} is free: it is found, not assumed")
        given = {**known, **chosen(there, tuple(assumed))} if assumed else known
        moves = tuple((knob.name, knob.move) for knob in given.values())
        scales = np.array([knob.scale for knob in given.values()])

        def found():
            off = [(value - given[name].value) / given[name].scale for name, value in assumed.items()]
            shift = jnp.stack([jnp.asarray(one, float) for one in off]) if off else jnp.zeros(0)
            steps, misfit, converged = _solve(
                scene, camera, jnp.asarray(image, float), shift, jnp.asarray(scales), noise, moves, method
            )
            values = [knob.value + step * knob.scale for knob, step in zip(known.values(), steps, strict=True)]
            return Measured(dict(zip(known, values, strict=True)), misfit, converged)

        if is_concrete(image, assumed):
            with x64():
                return found()
        require_x64("measurement")
        return found()

    return measure


@partial(jax.jit, static_argnames=("moves", "method"))
def _solve(scene, camera, image, shift, scales, noise: Scalar | None, moves: Moves, method: Chebyshev):
    """Steps of the free numbers, which come first, in their scales; misfit; whether the fit converged."""
    # As a program within the program it is traced once, for all its uses and derivatives.
    of_steps, count = jax.jit(photoelectrons(scene, camera, moves, scales, method)), len(moves) - len(shift)
    weight = weights(synthesize(of_steps(jnp.zeros(len(moves))), camera.shape), camera, noise)
    data = image * camera.exposure

    def equations(at, off):
        return from_coefficients(of_steps, jnp.concatenate([at, off]), camera.shape, data, weight)

    def gradient(at):
        return equations(at, shift).gradient[:count]

    stages = _stages(of_steps, jax.lax.stop_gradient(shift), count) if len(shift) else jnp.array(0)

    def search(_, at):
        whole = jnp.maximum(stages, 1).astype(float)

        def step(state):
            stage, at, taken = state
            made = equations(at, shift * (stage / whole))
            matrix = made.matrix[:count, :count]
            move = _least(matrix, made.gradient[:count])
            at = at - move
            settled = jnp.abs(move).max() <= _SETTLED * jnp.maximum(jnp.abs(at).max(), 1e-2)
            # The fringes of the next stage are met where this one's slopes put them: else it may miscount them.
            follow = _least(matrix, made.matrix[:count, count:] @ shift) / whole
            at = jnp.where(settled & (stage < stages), at - follow, at)
            return stage + settled.astype(int), at, jnp.where(settled, 0, taken + 1)

        start = (jnp.array(0), at, jnp.array(0))
        stage, at, _ = jax.lax.while_loop(lambda s: (s[0] <= stages) & (s[2] < _STEPS), step, start)
        return at, (stage > stages).astype(float)  # whose tangent, unlike a Boolean's, is a plain zero

    at, converged = jax.lax.custom_root(gradient, jnp.zeros(count), search, _solved, has_aux=True)
    made = equations(at, shift)
    good = (converged > 0) & _determined(made.matrix[:count, :count])
    return at * jnp.where(good, 1.0, jnp.nan), made.misfit, good  # a factor, so that derivatives are NaN too


def _stages(of_steps, shift, count: int):
    """In how many stages what is assumed moves the fringes by at most half a turn each."""
    still = jnp.zeros(count + len(shift))
    changes = split(list(jax.jvp(of_steps, (still,), (still.at[count:].set(shift),))[1]))[2]
    turns = jnp.max(jnp.stack([jnp.abs(change).sum() for change in changes]))
    return jnp.clip(jnp.ceil(2 * turns), 1, _STAGES).astype(int)


def _solved(linear, right):
    """The solution of a linear system that is given as a function."""
    return _least(jax.jacfwd(linear)(jnp.zeros_like(right)), right)


def _determined(matrix) -> Bool[Array, ""]:
    """Whether normal equations tell every number: of unit diagonal, their least eigenvalue is no rounding."""
    size = jnp.diag(matrix)
    unit = 1 / jnp.sqrt(jnp.where(size > 0, size, 1.0))
    least = jnp.linalg.eigvalsh(jax.lax.stop_gradient(matrix * jnp.outer(unit, unit)))[0]
    return (least > 1e-13 * len(matrix)) & jnp.all(size > 0)


def _least(matrix, right):
    """Matrix x = right by least squares: of what is not determined it takes nothing."""
    size = jnp.sqrt(jnp.maximum(jnp.abs(jnp.diag(matrix)), 1e-300))
    return jnp.linalg.lstsq(matrix / jnp.outer(size, size), right / size, rcond=1e-12)[0] / size
