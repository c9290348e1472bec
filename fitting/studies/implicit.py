"""The measured radius as a differentiable function of an image and of what is assumed about the bench.

A weighted least-squares fit ends where its gradient g(θ; image, assumed) = Jᵀ W (I - d) is zero; there
dθ = -(∂g/∂θ)⁻¹ dg, whatever led to it (the implicit function theorem; Blondel et al. 2022, Efficient and Modular
Implicit Differentiation). The second derivatives of the image are in ∂g/∂θ: it is exact for noisy images too.
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from fitting.parameters import chosen, free_names, knobs
from fitting.studies import gauss_newton, traced_fit
from fitting.studies.fisher import fine_nodes
from fitting.studies.gauss_newton import Problem, Solution, problem
from newtonjax.methods import Chebyshev, require_method
from newtonjax.numerics import is_concrete, require_x64, x64
from newtonjax.scene import Camera, Scene


class Measurement(NamedTuple):
    """The numbers that a fit determined.

    - `numbers`: by name, in their units; NaN where the fit did not converge, or the image does not determine them all.
    - `chi2`: the sum of squared residuals over the pixels' variance; the number of pixels where noise is all.
    - `converged`: to numbers that the image determines.
    """

    numbers: dict[str, Float[Array, ""]]
    chi2: Float[Array, ""]
    converged: Bool[Array, ""]


def measurement(
    scene: Scene,
    camera: Camera,
    *,
    free: Sequence[str] | None = None,
    noise: float | None = None,
    method: Chebyshev | None = None,
) -> Callable[..., Measurement]:
    """A function that measures images of a bench, differentiable in the image and in what is assumed of the bench.

    It is called as `measure(image, wavelength=..., pixel_size=..., ...)`: the image [rows, columns] in incident
    irradiance, as `render` gives it or as the camera's photoelectrons over its exposure, and any numbers of
    `knobs` that are not free, where they are not the scene's, in their units. It may be transformed by
    `jax.jit`, `jax.vmap`, `jax.grad` and `jax.jacfwd`, with JAX in float64.

    Args:
      scene, camera: where the search starts, and all that is assumed; one gap with two faces.
      free: the numbers that are determined; None for what `fit` determines of such a scene, as in `information`.
      noise [incident irradiance]: as in `information`; the weights are those of the scene's own image.
      method: the nodes; None for as many as keep 1e-8 of the intensity, and 17 at least.

    The search is local, by Gauss and Newton's method: the image's fringes must be within half a turn of the scene's.
    What is assumed may move them by more, since the fit follows it in stages. `fit` finds rings without a start.

    Raises ValueError for numbers that the scene does not have or that come twice, here and when called; when called,
    for an image of another shape, and RuntimeError within a transformation in float32.

    """
    numbers = knobs(scene, camera)
    require_method(method, Chebyshev)
    free_knobs = chosen(numbers, free_names(numbers, free))
    nodes = (fine_nodes(scene, camera) if method is None else method).nodes

    @cache
    def fit_with(held: tuple[str, ...]) -> Problem:
        return problem(
            scene, camera, list(chosen(numbers, (*free_knobs, *held)).values()), len(free_knobs), noise, nodes
        )

    def measure(image, **assumed) -> Measurement:
        if np.shape(image) != camera.shape:
            raise ValueError(f"the image has shape {np.shape(image)}; allowed: the camera's, {camera.shape}")
        if twice := set(assumed) & set(free_knobs):
            raise ValueError(f"{', '.join(sorted(twice))} is free: it is determined, not assumed")
        held = chosen(numbers, tuple(assumed)) if assumed else {}
        fit = fit_with(tuple(assumed))
        deviations = [(value - held[name].value) / held[name].scale for name, value in assumed.items()]
        if is_concrete(image, assumed):
            solution = gauss_newton.solve(
                fit, np.asarray(image, float) * camera.exposure, np.array([deviations], float).reshape(1, -1)
            )
            with x64():
                return measured(*_first(solution))
        require_x64("measurement")
        shift = jnp.stack([jnp.asarray(deviation, float) for deviation in deviations]) if deviations else jnp.zeros(0)
        steps, misfit, converged = _differentiable(fit)(jnp.asarray(image, float) * camera.exposure, shift)
        return measured(steps, misfit, converged > 0)

    def measured(steps, misfit, converged) -> Measurement:
        values = [knob.value + step * knob.scale for knob, step in zip(free_knobs.values(), steps, strict=True)]
        numbers = dict(zip(free_knobs, map(_array, values), strict=True))
        return Measurement(numbers, _array(2 * misfit), _array(converged))

    return measure


def _first(solution: Solution) -> tuple:
    """Steps, misfit and whether it converged, of the first fit."""
    return solution.steps[0], solution.misfit[0], solution.converged[0]


def _array(number) -> Array:
    """A JAX array of a number; of NumPy's without a program, which `asarray` would take."""
    return number if isinstance(number, jax.Array) else jax.device_put(np.asarray(number))


def _differentiable(fit: Problem) -> Callable:
    """From image [photoelectrons] and steps of what is held to steps, misfit and whether the fit converged, 1 or 0.

    Of known numbers all is made in NumPy, derivatives too; where a transformation hides the numbers all is traced.
    """

    def at_once(data, held):
        return _first(gauss_newton.solve(fit, data, held[None]))

    def arrays(steps, misfit, converged):
        return _array(steps), _array(misfit), _array(converged * 1.0)

    @jax.custom_jvp
    def fitted(data, held):
        if is_concrete(data, held):
            return arrays(*at_once(np.asarray(data), np.asarray(held)))
        return traced_fit.solve(fit, data, held)

    @fitted.defjvp
    def derivatives(primals, tangents):
        if is_concrete(primals):
            data, held = (np.asarray(part) for part in primals)
            steps, misfit, converged = at_once(data, held)
            by = gauss_newton.slopes(fit, data, np.nan_to_num(steps), held)
        else:
            steps, misfit, converged = fitted(*primals)
            by = traced_fit.slopes(fit, primals[0], steps, primals[1])
        image, held = tangents
        change = jnp.tensordot(by.steps_by_image, image, 2) + jnp.matmul(by.steps_by_held, held)
        misfit_change = jnp.vdot(by.misfit_by_image, image) + jnp.vdot(by.misfit_by_held, held)
        # A factor, so that derivatives are NaN where there is no answer.
        change = change * jnp.where(converged > 0, 1.0, jnp.nan)
        return arrays(steps, misfit, converged), (change, misfit_change, jnp.zeros(()))

    return fitted
