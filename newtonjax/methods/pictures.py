"""Images of known numbers, ready for their pixels: all of them, some rows at a time, or many images together."""

import abc
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.fields import image, parts, synthesize, synthesize_single
from newtonjax.numerics import x64
from newtonjax.scene import Camera, Scene, window


class AbstractPicture(abc.ABC):
    """What a method has worked out of a scene and a camera of known numbers, before it comes to the pixels."""

    @abc.abstractmethod
    def image(self) -> Float[Array, "rows columns *channels"]:
        """Every pixel; in float32 where JAX is set to it."""

    @abc.abstractmethod
    def blocks(self, rows: int) -> Iterator[tuple[int, Float[np.ndarray, "rows columns *channels"]]]:
        """First row and pixels of one block of rows after the other; the last one may have fewer rows."""

    @classmethod
    def images(
        cls, pictures: Sequence[Any], reduce: Callable[[Array], Any] | None, batch: int, done: Callable[[int], object]
    ) -> Any:
        """What is kept of each picture of this kind, in arrays with a first axis for them, in their precision.

        One after the other, whatever the batch; `done` is called with the number of pictures that are computed.
        """
        del batch
        return one_by_one((picture.image() for picture in pictures), len(pictures), reduce, done)


@dataclass(frozen=True, eq=False)
class AtPixels(AbstractPicture):
    """Pixels that are computed from the scene itself, `compute(scene, camera)`."""

    scene: Scene
    camera: Camera
    compute: Callable[[Scene, Camera], Float[Array, "rows columns *channels"]]

    def image(self) -> Float[Array, "rows columns *channels"]:
        return self._of(self.camera)

    def blocks(self, rows: int) -> Iterator[tuple[int, Float[np.ndarray, "rows columns *channels"]]]:
        for first, count in starts(self.camera.shape[0], rows):
            yield first, np.asarray(self._of(window(self.camera, first, count)))

    def _of(self, camera: Camera) -> Float[Array, "rows columns *channels"]:
        with x64():
            # As it stands: a program around it would be another one for each bench.
            pixels = self.compute(self.scene, camera)
        if jax.config.read("jax_enable_x64") or pixels.dtype == jnp.float32:
            return pixels
        with x64():
            return jax.block_until_ready(pixels.astype(jnp.float32))

    @classmethod
    def images(
        cls, pictures: Sequence[Any], reduce: Callable[[Array], Any] | None, batch: int, done: Callable[[int], object]
    ) -> Any:
        """One picture after the other, whatever the batch."""
        del batch
        return one_by_one((p.compute(p.scene, p.camera) for p in pictures), len(pictures), reduce, done)


@dataclass(frozen=True, eq=False)
class OnNodes(AbstractPicture):
    """Pixels that are summed from smooth fields.

    - `coefficients`: of background, moduli and phases [turns], in NumPy, as `fields.image` takes them.
    - `shape`: of the image.
    - `dtype`: in which pixels are computed; `result`: the type of an image.
    """

    coefficients: Float[np.ndarray, "fields nodes nodes"]
    shape: tuple[int, int]
    dtype: str
    result: str

    def image(self) -> Float[Array, "rows columns *channels"]:
        return image(self.coefficients, self.shape, self.dtype, self.result)

    def blocks(self, rows: int) -> Iterator[tuple[int, Float[np.ndarray, "rows columns *channels"]]]:
        of_full_size = parts(self.coefficients, self.shape, rows, self.dtype)
        for (first, count), (_, pixels) in zip(starts(self.shape[0], rows), of_full_size, strict=True):
            yield first, np.asarray(pixels)[-count:]

    @classmethod
    def images(
        cls, pictures: Sequence[Any], reduce: Callable[[Array], Any] | None, batch: int, done: Callable[[int], object]
    ) -> Any:
        """A batch of pictures side by side."""
        stacked = np.stack([picture.coefficients for picture in pictures])
        with x64():
            answers = images_on_nodes(stacked, pictures[0].shape, pictures[0].dtype, reduce, batch)
        done(len(pictures))
        return answers


@dataclass(frozen=True, eq=False)
class SideBySide(AbstractPicture):
    """The channels of an image as a picture each, and the level of each."""

    channels: tuple[AbstractPicture, ...]
    levels: tuple[float, ...]

    def image(self) -> Float[Array, "rows columns *channels"]:
        channels = zip(self.channels, self.levels, strict=True)
        return jnp.stack([level * part.image() for part, level in channels], axis=-1)

    def blocks(self, rows: int) -> Iterator[tuple[int, Float[np.ndarray, "rows columns *channels"]]]:
        for parts_of_rows in zip(*(part.blocks(rows) for part in self.channels), strict=True):
            pixels = [level * part for (_, part), level in zip(parts_of_rows, self.levels, strict=True)]
            yield parts_of_rows[0][0], np.stack(pixels, axis=-1)


@partial(jax.jit, static_argnames=("shape", "dtype", "reduce", "batch"))
def images_on_nodes(coefficients: Float[Array, "scenes fields nodes nodes"], shape, dtype, reduce, batch):
    """What is kept of each image of smooth fields: a program for a shape and a number of scenes."""
    of_fields = synthesize_single if dtype == "float32" else synthesize

    def of_scene(nodes):
        pixels = of_fields(nodes, shape)
        return pixels if reduce is None else reduce(pixels)

    return jax.lax.map(of_scene, coefficients, batch_size=batch)


def one_by_one(
    images: Iterator[Array], count: int, reduce: Callable[[Array], Any] | None, done: Callable[[int], object]
) -> Any:
    """What is kept of images that are computed one after the other."""
    of_image = (lambda pixels: pixels) if reduce is None else jax.jit(reduce)
    with x64():
        return _stacked(_counted((of_image(image) for image in images), done), count)


def starts(total: int, rows: int) -> Iterator[tuple[int, int]]:
    """First row and number of rows of every block."""
    return ((first, min(rows, total - first)) for first in range(0, total, rows))


def _counted(answers: Iterator[Any], done: Callable[[int], object]) -> Iterator[Any]:
    for number, answer in enumerate(answers, 1):
        done(number)
        yield answer


def _stacked(answers: Iterator[Any], count: int) -> Any:
    """Trees of arrays of one kind, with a first axis for all of them."""
    first = next(answers)
    total = jax.tree.map(lambda leaf: np.empty((count, *jnp.shape(leaf)), leaf.dtype), first)
    for number, answer in enumerate(chain([first], answers)):
        for rows, leaf in zip(jax.tree.leaves(total), jax.tree.leaves(answer), strict=True):
            rows[number] = leaf
    return jax.tree.map(jnp.asarray, total)
