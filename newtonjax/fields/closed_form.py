"""The fringes of equal thickness in closed form: constant amplitudes, the phase of the gap."""

from typing import Any

from jaxtyping import Float

from newtonjax.fields.at_points import Fields
from newtonjax.numerics import as_complex, module_of, namespace
from newtonjax.rays import amplitudes
from newtonjax.scene import Profile, Scene, Surface, gap_opd, itinerary, source_of


def axis_amplitude(scene: Scene, word: str) -> Float[Any, ""]:
    """Amplitude of a beam at normal incidence, its square the flux over the launched one.

    A transmitted beam's sqrt(T) is sqrt(1 - r²), written 2 sqrt(n1 n2) / (n1 + n2).
    """
    path = itinerary(word, len(scene.surfaces))
    xp = namespace(scene.media)
    total = xp.ones(())
    for action, before, beyond in zip(path.action, path.before, path.beyond, strict=True):
        n1, n2 = scene.media[before], scene.media[beyond]
        r_s, _, t_s, _ = amplitudes(n1, n2, 1.0, 1.0)
        total = total * (r_s if action else t_s * xp.sqrt(n2 / n1))
    return total


def closed_amplitudes(scene: Scene) -> tuple[Float[Any, ""], Float[Any, ""]]:
    """Background of equal-thickness fringes, and the product of two amplitudes that their envelope is in one line."""
    short, long = (axis_amplitude(scene, word) for word in sorted(scene.beams, key=len))
    return short**2 + long**2, 2 * short * long


def closed_fields(scene: Scene, x: Float[Any, "..."], y: Float[Any, "..."], profile: Profile = Surface.sag) -> Fields:
    """The fields of equal-thickness fringes at points (x, y) of the gap [m]; constant amplitudes."""
    background, mutual = closed_amplitudes(scene)
    path = gap_opd(scene, x, y, profile)
    xp = module_of(path)
    ones = xp.ones((1,) * path.ndim)
    envelope, phase = source_of(scene.light).fringes(as_complex(mutual * ones), path)
    return Fields(
        background=background * ones,
        envelope=envelope[None],
        phase=phase[None],
        rounding=xp.zeros_like(ones),
        arrives=ones > 0,
    )
