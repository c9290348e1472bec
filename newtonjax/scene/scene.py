"""A scene: a stack of surfaces and media, its light, the screen, and the beams that are followed."""

from dataclasses import replace

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from newtonjax.numerics import Scalar, as_vector, finite, is_concrete, is_real, positive, require, require_whole, shown
from newtonjax.scene.beams import enumerate_beams, itinerary, word_of
from newtonjax.scene.coatings import AllOrders
from newtonjax.scene.elements import CollectingLens, Shield, check_way
from newtonjax.scene.light import Light
from newtonjax.scene.surfaces import Surface


def _words(beams, name: str = "beams") -> tuple[str, ...]:
    if not (isinstance(beams, tuple | list) and all(isinstance(beam, str) for beam in beams)):
        raise ValueError(f"{name} is {shown(beams)}; allowed: a tuple of words such as 'T0 T1 T2 T3'")
    return tuple(beams)


class Scene(eqx.Module):
    """What light meets, in metres and radians. Every number in it may be traced, differentiated and batched.

    - `surfaces`: in the order in which the light first meets them; it falls along -z.
    - `media`: refractive indices (real), one more than surfaces: `media[k]` lies before surface k.
    - `light`: the source.
    - `screen`: the plane on which the image is taken, a `Surface` of curvature 0 whose turned x and y directions are
      the image's. It may be virtual (a plane inside the stack seen through the glass): rays are drawn back to it.
    - `beams`: words (see `newtonjax.scene.beams`) of the beams that meet on the screen. Static.
    - `shield`: with a round hole that light must pass on its way to the screen; None where there is none.
    - `collecting_lens`: an ideal lens on that way, which images some plane on the screen; None where there is none.
    - `all_orders`: all reflections between the faces of the gap in which `beams` differ by one round trip, and their
      coatings; None for the `beams` alone.
    """

    surfaces: tuple[Surface, ...] = eqx.field(
        converter=lambda parts: tuple(parts) if isinstance(parts, list) else parts
    )
    media: Float[Array | np.ndarray, " media"] = eqx.field(converter=as_vector)
    light: Light
    screen: Surface
    beams: tuple[str, ...] = eqx.field(static=True, converter=_words)
    shield: Shield | None = None
    collecting_lens: CollectingLens | None = None
    all_orders: AllOrders | None = None

    def __check_init__(self):
        self._check_kinds()
        if np.ndim(self.media) and len(self.media) != len(self.surfaces) + 1:
            raise ValueError(
                f"media has {len(self.media)} refractive indices for {len(self.surfaces)} surfaces; "
                "allowed: one more than there are surfaces"
            )
        if not self.beams:
            raise ValueError("beams is empty; allowed: at least one word such as 'T0 T1 T2 T3'")
        if len(set(self.beams)) < len(self.beams):
            raise ValueError(f"beams {self.beams} holds a word twice; each beam may be named once")
        views = {itinerary(word, len(self.surfaces)).view for word in self.beams}
        if len(views) > 1:
            raise ValueError(f"beams {self.beams} leave on both sides; one screen sees one side only")
        require("media", self.media, "positive refractive indices", positive)
        if is_concrete(self.screen.curvature) and np.any(np.asarray(self.screen.curvature) != 0):
            raise ValueError(f"screen.curvature is {self.screen.curvature}; allowed: 0, the screen is a plane")
        beside = self.shield, self.collecting_lens
        if any(part is not None for part in beside) and is_concrete(self.surfaces, self.screen, beside):
            check_way(self)

    def _check_kinds(self) -> None:
        if not (isinstance(self.surfaces, tuple) and all(isinstance(part, Surface) for part in self.surfaces)):
            raise ValueError(f"surfaces is {shown(self.surfaces)}; allowed: a tuple of Surface")
        if isinstance(self.media, tuple | list) or np.ndim(self.media) == 0:
            raise ValueError(f"media is {shown(self.media)}; allowed: refractive indices, one more than surfaces")
        of_kinds = (
            ("light", self.light, Light),
            ("screen", self.screen, Surface),
            ("shield", self.shield, Shield | None),
            ("collecting_lens", self.collecting_lens, CollectingLens | None),
            ("all_orders", self.all_orders, AllOrders | None),
        )
        for name, part, kind in of_kinds:
            if not isinstance(part, kind):
                raise ValueError(f"{name} is {shown(part)}; allowed: {getattr(kind, '__name__', kind)}")

    @property
    def view(self) -> str:
        """The side on which the screen stands: "transmitted" or "reflected"."""
        return itinerary(self.beams[0], len(self.surfaces)).view

    @property
    def wavelength(self) -> Scalar:
        """The vacuum wavelength [m]."""
        return self.light.wavelength


def choose_beams(
    scene: Scene,
    *,
    number: int | None = None,
    energy: float | None = None,
    names: tuple[str, ...] | None = None,
    reflections: int = 3,
) -> Scene:
    """The scene with other beams, chosen among all with at most so many reflections, on its own side.

    Exactly one choice: the `number` strongest, all of at least an `energy` (fraction of the incident flux on the
    axis), or by `names` ("direct", "R2-R1") or whole words, with any number of reflections.

    Raises ValueError for another number of choices, for an unknown name, for none left, and where the media are
    traced but the choice needs their values.
    """
    if not isinstance(scene, Scene):
        raise ValueError(f"scene is {shown(scene)}; allowed: a Scene, such as newton_rings(1.0)")
    require_whole("number", number)
    if energy is not None and not (is_concrete(energy) and is_real(energy) and np.ndim(energy) == 0 and finite(energy)):
        raise ValueError(f"energy is {shown(energy)}; allowed: one number, a fraction of the incident flux")
    if sum(choice is not None for choice in (number, energy, names)) != 1:
        raise ValueError("choose_beams takes exactly one of number, energy and names")
    if names is not None:
        names = _words(names, "names")
        chosen = replace(scene, beams=tuple(word_of(name, len(scene.surfaces)) for name in names))
        if chosen.view != scene.view:
            raise ValueError(f"beams {', '.join(names)} leave on the other side: the scene's view is {scene.view!r}")
        return chosen
    if not is_concrete(scene.media):
        raise ValueError("the media are traced, so that beam energies have no value yet; choose the beams outside")
    candidates = enumerate_beams(scene.media, scene.view, reflections)
    chosen = candidates[:number] if energy is None else tuple(beam for beam in candidates if beam.energy >= energy)
    if not chosen:
        raise ValueError(f"no beam is left of {len(candidates)}; the strongest has energy {candidates[0].energy:.3g}")
    return replace(scene, beams=tuple(beam.word for beam in chosen))
