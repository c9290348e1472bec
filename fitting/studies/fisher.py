"""What an image can tell: Fisher's information of a scene's and a camera's numbers, and the bounds that follow.

For independent normal pixels of variance σ² and mean μ(θ) it is F = Σ (∂μ/∂θ) (∂μ/∂θ)ᵀ / σ², and no unbiased estimate
of a number scatters less than sqrt (F⁻¹)_kk (Cramér 1946, Rao 1945; Kay 1993, Fundamentals of Statistical Signal
Processing, section 3.7). It is summed through the nodes of the image, not over its pixels. What the codes of a dim
image tell is not normal, and is more: with read noise well below a code the bounds are up to 1 % too large where the
brightest pixel has 34 codes, 10 % at 3, and 60 % below one (tests/studies/test_information.py sums over the codes).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from fitting.parameters import Knob, chosen, knobs
from fitting.studies.electrons import moved, tables, weights
from fitting.studies.pixel_sums import equations
from fitting.studies.undetermined import in_words
from newtonjax.fields import error_from_nodes, jet_fields
from newtonjax.methods import Chebyshev, require_method, unreached
from newtonjax.numerics import jets
from newtonjax.scene import Camera, Scene

FREE = ("radius", "gap", "centre_x", "centre_y", "exposure", "contrast")
# A combination is called undetermined where its information is this small a share of what its parts have by themselves.
_WEAK = 1e-8
# Shares that rounding makes of nothing.
_ROUNDING = 1e-13
# Nodes to a side that are tried, at most.
_MOST_NODES = 129


@dataclass(frozen=True)
class Information:
    """Fisher's information of numbers `names`, and what follows from it. `str()` is a table.

    - `units`, `values`, `scales`: by number; `matrix`: of the image alone, per unit squared.
    - `priors`: standard deviations of what is known from elsewhere [units].
    - `undetermined`: combinations that the image does not tell, in words.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Float[np.ndarray, " n"]
    scales: Float[np.ndarray, " n"]
    matrix: Float[np.ndarray, "n n"]
    priors: Mapping[str, float] = field(default_factory=dict)
    positive: tuple[bool, ...] = ()

    def at(self, name: str) -> int:
        """Where a number stands. Raises ValueError for one that is not free."""
        if name not in self.names:
            raise ValueError(f"{name!r} is not free here; free are {', '.join(self.names)}")
        return self.names.index(name)

    def given(self, **priors: float) -> "Information":
        """The same with standard deviations of some numbers from elsewhere [units]; 0 holds a number.

        Raises ValueError for a number that is not free, and for negative deviations.
        """
        for name, sd in priors.items():
            self.at(name)
            if not isinstance(sd, int | float | np.number) or not sd >= 0:
                raise ValueError(f"the standard deviation of {name} is {sd}; allowed: zero or more, in its unit")
        return Information(**{**self.__dict__, "priors": {**self.priors, **priors}})

    @property
    def covariance(self) -> Float[np.ndarray, "n n"]:
        """Bound on the covariance of unbiased estimates [units]; a variance is infinite where nothing determines it."""
        scaled = self._scaled()
        held = np.array([self.priors.get(name) == 0 for name in self.names])
        bound = np.zeros_like(scaled)
        if held.all():
            return bound
        # To unit diagonal with the priors in it: then a prior, however tight, hides nothing of the others.
        size = np.diag(scaled)
        unit = 1 / np.sqrt(np.where(size > 0, size, 1.0))
        size, axes = np.linalg.eigh((scaled * np.outer(unit, unit))[np.ix_(~held, ~held)])
        determined = size > _ROUNDING * len(size)
        inverse = (axes[:, determined] / size[determined]) @ axes[:, determined].T
        undetermined = (axes[:, ~determined] ** 2).sum(axis=1) > 1e-10
        inverse[undetermined, undetermined] = np.inf
        bound[np.ix_(~held, ~held)] = inverse
        step = self._steps() * unit
        return bound * np.outer(step, step)

    def sd(self, name: str) -> float:
        """Bound on the standard deviation with all other numbers unknown, but for priors [unit]."""
        k = self.at(name)
        return float(np.sqrt(self.covariance[k, k]))

    def conditional_sd(self, name: str) -> float:
        """Bound on the standard deviation with all other numbers known [unit]."""
        k = self.at(name)
        prior = self.priors.get(name)
        if prior == 0:
            return 0.0
        information = self.matrix[k, k] + (0.0 if prior is None else prior**-2)
        return float(information**-0.5) if information > 0 else np.inf

    def bought(self, name: str) -> dict[str, float]:
        """The bound on a number [unit] if each of the others were known exactly."""
        return {known_name: self.given(**{known_name: 0.0}).sd(name) for known_name in self.names if known_name != name}

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Combinations of numbers that the image, with the priors, does not tell."""
        unit = 1 / np.sqrt(np.maximum(np.diag(self._scaled()), 1e-300))
        held = np.array([self.priors.get(name) == 0 for name in self.names])
        visible = np.diag(self._scaled()) > 0
        words = [f"{self.names[k]}: the image does not change with it" for k in np.flatnonzero(~visible & ~held)]
        visible &= ~held
        if visible.sum() < 2:
            return tuple(words)
        normal = (self._scaled() * np.outer(unit, unit))[np.ix_(visible, visible)]
        size, axes = np.linalg.eigh(normal)
        weak = size < _WEAK
        if not weak.any():
            return tuple(words)
        references = np.where(self._ratio(), np.abs(self.values), self.scales)
        names = [name for name, is_visible in zip(self.names, visible, strict=True) if is_visible]
        relative = (unit * self._steps() / references)[visible]
        return (*words, *in_words(names, self._ratio()[visible], relative, axes[:, weak]))

    def _ratio(self) -> np.ndarray:
        return np.array(self.positive or (False,) * len(self.names))

    def _steps(self) -> np.ndarray:
        """Each number by itself, as the image tells it [units]; its scale where the image does not."""
        size = np.diag(self.matrix)
        return np.where(size > 0, 1 / np.sqrt(np.where(size > 0, size, 1.0)), self.scales)

    def _scaled(self) -> np.ndarray:
        step = self._steps()
        prior = [self.priors.get(name, np.inf) for name in self.names]
        from_priors = [(s / p) ** 2 if p else 0.0 for s, p in zip(step, prior, strict=True)]
        return self.matrix * np.outer(step, step) + np.diag(from_priors)

    def __str__(self) -> str:
        rows = [f"{'':<14} {'value':>12} {'sd':>10} {'others known':>13} {'unit':<14}"]
        for k, name in enumerate(self.names):
            rows.append(
                f"{name:<14} {self.values[k]:>12.6g} {self.sd(name):>10.3g} {self.conditional_sd(name):>13.3g} "
                f"{self.units[k]:<14}".rstrip()
            )
        return "\n".join([*rows, *(f"undetermined: {text}" for text in self.undetermined)])


def information(
    scene: Scene,
    camera: Camera,
    free: Sequence[str] = FREE,
    *,
    priors: Mapping[str, float] | None = None,
    noise: float | None = None,
    method: Chebyshev | None = None,
) -> Information:
    """Fisher's information of an image in numbers of its scene and camera.

    Args:
      scene, camera: where; one gap with two faces.
      free: which numbers are not known: those of `parameters.knobs`, "stray" and "contrast" among them.
      priors: standard deviations of some of them from elsewhere, in their units.
      noise: of every pixel, as a standard deviation in incident irradiance; None for the camera's own: shot noise at
        its exposure, read noise, and the rounding of its code, full_well / (2^bits - 1) / sqrt 12. Saturated pixels
        tell nothing.
      method: the nodes; None for as many as keep 1e-8 of the intensity, and 17 at least.

    Raises ValueError for numbers that the scene does not have or that come twice, and where beams miss a node.

    """
    require_method(method, Chebyshev)
    names = (free,) if isinstance(free, str) else tuple(free)
    numbers = tuple(chosen(knobs(scene, camera), names).values())
    nodes = fine_nodes(scene, camera).nodes if method is None else method.nodes
    scales = np.array([number.scale for number in numbers])
    table, changes = derivatives(scene, camera, numbers, nodes)
    normal = equations(table, changes, camera.shape, lambda image, _: weights(image, camera, noise))
    result = Information(
        names,
        tuple(number.unit for number in numbers),
        np.array([number.value for number in numbers]),
        scales,
        normal.matrix / np.outer(scales, scales),
        {},
        tuple(number.positive for number in numbers),
    )
    return result.given(**(priors or {}))


def derivatives(
    scene: Scene, camera: Camera, numbers: Sequence[Knob], nodes: int
) -> tuple[Float[np.ndarray, "3 nodes nodes"], Float[np.ndarray, "numbers 3 nodes nodes"]]:
    """Coefficients of an image's fields (`studies.tables`), and their derivatives by steps in the numbers' scales.

    Raises ValueError where beams miss a node.
    """
    still = jets.variable(np.zeros(len(numbers)), np.eye(len(numbers)), 1, 2)
    moves = tuple((number.name, number.move) for number in numbers)
    bench = moved(scene, camera, moves, still, [number.scale for number in numbers])
    table, reached = tables([bench], nodes, 2)
    if not reached.all():
        raise unreached(Chebyshev(nodes))
    return table.value[0], table.parts[0, 1:, 0]


def fine_nodes(scene: Scene, camera: Camera, keeps: float = 1e-8, least: int = 17) -> Chebyshev:
    """As many nodes as keep a share of the intensity, and a number of them at least.

    Raises ValueError where beams miss the image, and where 129 to a side do not.
    """
    count = least
    while True:
        fields = jet_fields.values_of(jet_fields.at_nodes([(scene, camera)], count, 1))
        # But for the rounding of the phases [turns].
        exact = fields._replace(rounding=np.zeros_like(fields.rounding))
        error = float(error_from_nodes(exact, count).intensity)
        # What rounding leaves in every coefficient of the phases, more nodes do not mend.
        allowed = keeps + 400 * float(fields.rounding.max())
        if error <= allowed:
            return Chebyshev(count)
        if not np.isfinite(error):
            raise ValueError("a beam does not reach the whole image; this takes smooth fields: take a smaller field")
        if count == _MOST_NODES:
            raise ValueError(
                f"{count} nodes to a side leave {error:.2g} of the intensity; this takes {keeps:.0e}: "
                "take a smaller field"
            )
        count = min(2 * count - 1, _MOST_NODES)
