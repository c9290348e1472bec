"""Images larger than memory: `blocks` renders them some rows at a time."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import jax
import numpy as np
from jaxtyping import Float

from newtonjax import chebyshev
from newtonjax.camera import Camera, middle
from newtonjax.checks import require_bench, require_method, require_whole, unreached
from newtonjax.methods import AbstractMethod, Chebyshev, Traced
from newtonjax.planning import plan
from newtonjax.precision import afresh, require_concrete, x64
from newtonjax.rendering import pixels_as_set, render
from newtonjax.scene import Scene
from newtonjax.splatting import Splat
from newtonjax.strips import strips, synthesize_strips
from newtonjax.synthesis import synthesize_on

# Pixels of a block where no number of rows is asked for: 32 MiB in float64.
_PIXELS = 2**22


@dataclass(frozen=True)
class Blocks:
    """An image as an iterable of (first row, rows of the image), which may be gone through more than once.

    - `scene`, `camera`: of the whole image; `method`: with which it is computed.
    - `rows`: of a block; the last one may have fewer.
    """

    scene: Scene
    camera: Camera
    method: AbstractMethod
    rows: int

    def __iter__(self) -> Iterator[tuple[int, Float[np.ndarray, "rows columns"]]]:
        total = self.camera.shape[0]
        starts = [(first, min(self.rows, total - first)) for first in range(0, total, self.rows)]
        if isinstance(self.method, Chebyshev):
            return self._from_nodes(self.method, starts)
        windows = ((first, self._window(first, rows)) for first, rows in starts)
        return ((first, np.asarray(render(self.scene, window, self.method))) for first, window in windows)

    def _window(self, first: int, rows: int) -> Camera:
        centre = middle(self.camera.shape) if self.camera.centre_px is None else np.asarray(self.camera.centre_px)
        return replace(self.camera, shape=(rows, self.camera.shape[1]), centre_px=(centre[0], centre[1] - first))

    def _from_nodes(self, method: Chebyshev, starts) -> Iterator[tuple[int, Float[np.ndarray, "rows columns"]]]:
        with x64():
            coefficients, reached = _coefficients(self.scene, self.camera, method)
        if not reached:
            raise unreached(method)
        total, columns = self.camera.shape
        along_x = chebyshev.basis(columns, method.nodes)
        for first, rows in starts:
            with x64():
                if method.dtype == "float32":
                    matrix, u = strips(rows, method.nodes, first, total)
                    made = _single(coefficients, matrix, u, along_x)[:rows]
                else:
                    made = _double(coefficients, chebyshev.basis(total, method.nodes, first, rows), along_x)
            yield first, np.asarray(made)


def blocks(
    scene: Scene,
    camera: Camera,
    method: AbstractMethod | None = None,
    tolerance: float = 1e-3,
    rows: int | None = None,
) -> Blocks:
    """The image of `render` as blocks of rows, for images that memory does not hold.

    Method, tolerance and precision are those of `render`; the whole image has one method, and rays are traced at its
    nodes once. `rows`: of a block; by default as many as make 32 MiB.

        for first, part in nj.blocks(scene, camera):
            file[first : first + len(part)] = part

    Raises ValueError as `render` does, for fewer than one row, for `Splat`, whose pairs lie all over the image, and for
    traced values.
    """
    require_bench(scene, camera)
    require_method(method)
    require_concrete("blocks", scene, camera)
    require_whole("rows", rows)
    if isinstance(method, Splat):
        raise ValueError("Splat pairs rays over the whole image; give blocks another method")
    scene, camera = afresh(scene, camera)
    if method is None:
        chosen = plan(scene, camera, tolerance)
        scene, method = chosen.scene, chosen.method
    method.check(scene)
    rows = max(_PIXELS // camera.shape[1], 1) if rows is None else rows
    if isinstance(method, Traced) and method.chunk > rows * camera.shape[1]:
        method = Traced(chunk=rows * camera.shape[1])
    return Blocks(scene, camera, pixels_as_set(method), min(rows, camera.shape[0]))


@partial(jax.jit, static_argnames="method")
def _coefficients(scene: Scene, camera: Camera, method: Chebyshev):
    fields = method.fields(scene, camera)
    return method.coefficients(fields), fields.arrives.all()


_single = jax.jit(synthesize_strips)
_double = jax.jit(synthesize_on)
