"""float64 where it is needed: as a context around eager calls, as an error inside the user's own transformations."""

import jax

from newtonjax.quantities import is_concrete


def x64():
    """A context in which JAX computes in float64; the user's configuration is left alone."""
    return jax.enable_x64(True)


def require_x64(what: str) -> None:
    """Raise RuntimeError inside a transformation that would round optical paths to float32."""
    if not jax.config.read("jax_enable_x64"):
        raise RuntimeError(
            f"{what} needs float64: a path of metres in float32 errs by a radian. "
            'Add jax.config.update("jax_enable_x64", True) before the first JAX call'
        )


def require_concrete(what: str, *trees) -> None:
    """Raise ValueError where a transformation hides the numbers that a choice needs."""
    if not is_concrete(*trees):
        raise ValueError(
            f"{what} needs numbers, but the scene or the camera is being traced by a JAX transformation; "
            "call it outside and pass its method to render"
        )
