"""Images larger than memory: `blocks` renders them some rows at a time."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from newtonjax.methods import AbstractMethod, AbstractPicture, require_method
from newtonjax.numerics import require_concrete, require_memory, require_whole
from newtonjax.scene import Camera, Scene, require_bench
from newtonjax.verbs.rendering import choose

# Pixels of a block where no number of rows is asked for: 32 MiB in float64.
_PIXELS = 2**22
# Of memory a pixel of a block while it is computed and handed over.
_BYTES = 32


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
    _picture: AbstractPicture = field(repr=False, compare=False)

    def __iter__(self) -> Iterator[tuple[int, Float[np.ndarray, "rows columns *channels"]]]:
        return self._picture.blocks(self.rows)


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
    if method is not None:
        method.require_parts("blocks")
    scene, method, picture = choose(scene, camera, method, tolerance)
    rows = max(_PIXELS // camera.shape[1], 1) if rows is None else rows
    rows = min(rows, camera.shape[0])
    what = f"a block of {rows} rows of an image of {camera.shape[0]} x {camera.shape[1]} pixels"
    needed = method.shared_bytes(camera.shape) + _BYTES * rows * camera.shape[1]
    require_memory(what, needed, "allowed: fewer rows in a block, or a smaller shape")
    return Blocks(scene, camera, method, rows, method.picture(scene, camera) if picture is None else picture)
