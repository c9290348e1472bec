"""Images larger than memory: `blocks` renders them some rows at a time."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from newtonjax.fields import parts
from newtonjax.methods import AbstractMethod, Chebyshev, Splat, Traced, require_method, unreached
from newtonjax.numerics import afresh, require_concrete, require_memory, require_whole
from newtonjax.planning import planned
from newtonjax.scene import Camera, Scene, middle, require_bench
from newtonjax.verbs.rendering import at_nodes, pixels_as_set, render

# Pixels of a block where no number of rows is asked for: 32 MiB in float64.
_PIXELS = 2**22
# Of memory a pixel of a block while it is computed and handed over.
_BYTES = 32


@dataclass(frozen=True)
class Blocks:
    """An image as an iterable of (first row, rows of the image), which may be gone through more than once.

    - `scene`, `camera`: of the whole image; `method`: with which it is computed.
    - `rows`: of a block; the last one may have fewer.
    - `coefficients`: of the fields where the method is nodes, as `render` has them; else None.
    """

    scene: Scene
    camera: Camera
    method: AbstractMethod
    rows: int
    coefficients: Float[np.ndarray, "fields nodes nodes"] | None = field(default=None, repr=False, compare=False)

    def __iter__(self) -> Iterator[tuple[int, Float[np.ndarray, "rows columns"]]]:
        total = self.camera.shape[0]
        starts = ((first, min(self.rows, total - first)) for first in range(0, total, self.rows))
        if isinstance(self.method, Chebyshev) and self.coefficients is not None:
            return self._from_nodes(self.method, self.coefficients, starts)
        windows = ((first, self._window(first, rows)) for first, rows in starts)
        return ((first, np.asarray(render(self.scene, window, self.method))) for first, window in windows)

    def _window(self, first: int, rows: int) -> Camera:
        centre = middle(self.camera.shape) if self.camera.centre_px is None else np.asarray(self.camera.centre_px)
        return replace(self.camera, shape=(rows, self.camera.shape[1]), centre_px=(centre[0], centre[1] - first))

    def _from_nodes(self, method: Chebyshev, coefficients, starts):
        made = parts(coefficients, self.camera.shape, self.rows, method.dtype or "float64")
        for (first, rows), (_, part) in zip(starts, made, strict=True):
            yield first, np.asarray(part)[-rows:]


def blocks(
    scene: Scene,
    camera: Camera,
    method: AbstractMethod | None = None,
    tolerance: float = 1e-3,
    rows: int | None = None,
) -> Blocks:
    """The image of `render` as blocks of rows, for images that memory does not hold.

    Method, tolerance and precision are those of `render`; the whole image has one method, and rays are traced at its
    nodes once, if the plan has not done so. `rows`: of a block; by default as many as make 32 MiB.

        for first, part in nj.blocks(scene, camera):
            file[first : first + len(part)] = part

    Raises ValueError as `render` does, for fewer than one row, for `Splat`, whose pairs lie all over the image, for a
    block that memory does not hold, and for traced values.
    """
    require_bench(scene, camera)
    require_method(method)
    require_concrete("blocks", scene, camera)
    require_whole("rows", rows)
    if isinstance(method, Splat):
        raise ValueError("Splat pairs rays over the whole image; give blocks another method")
    scene, camera = afresh(scene, camera)
    coefficients = None
    if method is None:
        chosen, coefficients = planned(scene, camera, tolerance)
        scene, method = chosen.scene, chosen.method
    method.check(scene)
    rows = max(_PIXELS // camera.shape[1], 1) if rows is None else rows
    rows = min(rows, camera.shape[0])
    _require_room(camera.shape, rows, method)
    if isinstance(method, Traced) and method.chunk > rows * camera.shape[1]:
        method = Traced(chunk=rows * camera.shape[1])
    method = pixels_as_set(method)
    if isinstance(method, Chebyshev) and coefficients is None:
        coefficients, reached = at_nodes(scene, camera, method)
        if not reached:
            raise unreached(method)
    return Blocks(scene, camera, method, rows, coefficients)


def _require_room(shape: tuple[int, int], rows: int, method: AbstractMethod) -> None:
    """Raise ValueError where memory holds no block, or not the basis functions of all rows and columns."""
    basis = 16 * method.nodes * sum(shape) if isinstance(method, Chebyshev) else 0
    what = f"a block of {rows} rows of an image of {shape[0]} x {shape[1]} pixels"
    require_memory(what, basis + _BYTES * rows * shape[1], "allowed: fewer rows in a block, or a smaller shape")
