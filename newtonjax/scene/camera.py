"""The camera: which points of the screen are pixels, and what a photograph adds to an image."""

import operator
from dataclasses import replace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Key, UInt8, UInt16

from newtonjax.numerics import (
    Scalar,
    Vector2,
    as_scalar,
    as_vector,
    finite,
    image_memory,
    is_concrete,
    is_real,
    module_of,
    namespace,
    nodes,
    positive,
    refuse_after_fork,
    require,
    require_choice,
    require_one,
    require_size,
    require_whole,
    shown,
)
from newtonjax.scene.camera_lens import CameraLens, in_window, passed_by, seen_from
from newtonjax.scene.codes import MOSAICS, developed, filtered
from newtonjax.scene.response import Response

# Bytes a pixel while noise is drawn, measured.
_EXPOSING = 110
# Photoelectrons that a pixel counts at most: far beyond any full well, and within 32 bits.
_MOST = 1e9


def _whole(shape) -> tuple[int, int]:
    try:
        rows, columns = (operator.index(n) for n in shape)
    except (TypeError, ValueError):
        raise ValueError(f"shape is {shown(shape)}; allowed: (rows, columns), two whole numbers") from None
    return rows, columns


def _bits(bits) -> int:
    if not (isinstance(bits, int | np.integer) and 8 <= bits <= 16):
        raise ValueError(f"bits is {shown(bits)}; allowed: 8 to 16")
    return int(bits)


class Camera(eqx.Module):
    """A grid of square pixels on the screen, and the noise of the sensor behind it.

    - `shape`: (rows, columns). Static.
    - `pixel_size`: distance of pixel centres on the screen [m].
    - `centre_px`: (x, y) of the screen's origin in pixels, pixel centres at integers; None is the image's middle.
    - `exposure`: photoelectrons that unit irradiance (the incident light's) puts into a pixel.
    - `full_well`: photoelectrons at which a pixel saturates, the largest code.
    - `read_noise`: standard deviation [photoelectrons].
    - `bits`: 8 to 16, the depth of the code. Static.
    - `aperture`: side of the square of a pixel that takes light [pixels], over which images are means: 1 is all of it;
      None for the light at its centre.
    - `blur`: standard deviation of a Gaussian blur by the lens, in pixels; None for a sharp image.
    - `response`: of its channels to wavelengths; None for one channel that takes all wavelengths alike. With one,
      images have the shape (rows, columns, channels).
    - `lens`: that distorts, sees the screen at a slant, or has a size for each colour; None for an even grid.
    - `full_scale`: photoelectrons of the largest code; None for `full_well`, which then is the largest code. Above
      it, photographs are clipped below the end of the scale.
    - `black_level`: code of no light, below the largest; None for 0.
    - `mosaic`: colour filters of the first four pixels, row by row: "RGGB", "BGGR", "GRBG", "GBRG"; None for all
      channels in every pixel. Photographs have the others from their neighbours, by bilinear means. Static.
    - `transfer`: "linear" codes, or "srgb" ones (IEC 61966-2-1), which count from the black level. Static.
    - `jpeg`: quality, 1 to 100, of a JPEG of 8-bit codes that a photograph comes from; None for none. Static.
    """

    shape: tuple[int, int] = eqx.field(static=True, converter=_whole)
    pixel_size: Scalar = eqx.field(converter=as_scalar)
    centre_px: Vector2 | None = eqx.field(converter=lambda c: None if c is None else as_vector(c), default=None)
    exposure: Scalar = eqx.field(converter=as_scalar, default=10_000.0)
    full_well: Scalar = eqx.field(converter=as_scalar, default=12_000.0)
    read_noise: Scalar = eqx.field(converter=as_scalar, default=5.0)
    bits: int = eqx.field(static=True, converter=_bits, default=8)
    aperture: Scalar | None = eqx.field(converter=as_scalar, default=None)
    blur: Scalar | None = eqx.field(converter=as_scalar, default=None)
    response: Response | None = None
    lens: CameraLens | None = None
    full_scale: Scalar | None = eqx.field(converter=as_scalar, default=None)
    black_level: Scalar | None = eqx.field(converter=as_scalar, default=None)
    mosaic: str | None = eqx.field(static=True, default=None)
    transfer: str = eqx.field(static=True, default="linear")
    jpeg: int | None = eqx.field(static=True, default=None)

    def __check_init__(self):
        if not isinstance(self.response, Response | None):
            raise ValueError(f"response is {shown(self.response)}; allowed: a Response such as cie_1931(), or None")
        for name, value in (("aperture", self.aperture), ("blur", self.blur)):
            if value is not None:
                require_one(name, value, "0 to 100 pixels, or None", lambda v: np.all((v >= 0) & (v <= 100)))
        if min(self.shape) < 1:
            raise ValueError(f"shape is {self.shape}; allowed: (rows, columns), both at least 1")
        require_one("pixel_size", self.pixel_size, "a positive length in metres", positive)
        if self.centre_px is not None:
            require("centre_px", self.centre_px, "two finite numbers, (x, y) in pixels", finite)
            require_size("centre_px", self.centre_px, 2, "two finite numbers, (x, y) in pixels")
        require_one("exposure", self.exposure, "a positive number of photoelectrons", positive)
        require_one("full_well", self.full_well, "a positive number of photoelectrons", positive)
        require_one("read_noise", self.read_noise, "0 or more photoelectrons", lambda v: finite(v) and np.all(v >= 0))
        self._check_codes()
        self._check_lens()

    def _check_codes(self):
        if self.full_scale is not None:
            require_one("full_scale", self.full_scale, "a positive number of photoelectrons, or None", positive)
        if self.black_level is not None:
            top = 2**self.bits - 1
            allowed = f"0 to below {top}, the largest code, or None"
            require_one("black_level", self.black_level, allowed, lambda v: np.all((v >= 0) & (v < top)))
        require_choice("transfer", self.transfer, ("linear", "srgb"))
        if self.mosaic is not None:
            require_choice("mosaic", self.mosaic, MOSAICS)
            if self.response is None or len(self.response.curves) != len("RGB"):
                raise ValueError(f"mosaic {self.mosaic} without a response of three channels; give both")
        require_whole("jpeg", self.jpeg, 1, 100)
        if self.jpeg is not None and self.bits != 8:
            raise ValueError(f"jpeg with codes of {self.bits} bits; allowed: bits=8")

    def _check_lens(self):
        if not isinstance(self.lens, CameraLens | None):
            raise ValueError(f"lens is {shown(self.lens)}; allowed: a CameraLens, or None")
        sizes = None if self.lens is None else self.lens.magnifications
        channels = 1 if self.response is None else len(self.response.curves)
        if sizes is not None and len(sizes) != channels:
            raise ValueError(f"lens.magnifications are {len(sizes)}; allowed: {channels}, one for each channel")

    def axes(self) -> tuple[Float[Any, " columns"], Float[Any, " rows"]]:
        """Screen coordinates x of columns and y of rows [m] on the grid without a lens; NumPy for known numbers."""
        xp = namespace(self.pixel_size, self.centre_px)
        rows, columns = self.shape
        return _on_screen(self, xp.arange(columns, dtype=float), xp.arange(rows, dtype=float))

    def ends(self) -> tuple[Float[Any, "2"], Float[Any, "2"]]:
        """What `axes` has at its ends [m]: x of the first and the last column, y of the first and the last row."""
        return _ends(self)

    @property
    def takes_means(self) -> bool:
        """Whether a pixel is more than the light at its centre."""
        return self.aperture is not None or self.blur is not None

    @property
    def image_shape(self) -> tuple[int, ...]:
        """Of its images: rows, columns, and channels where it has a response."""
        return self.shape if self.response is None else (*self.shape, len(self.response.curves))

    def expose(
        self, image: Float[Array | np.ndarray, "rows columns *channels"], key: Key[Array, ""]
    ) -> UInt8[Array, "rows columns *channels"] | UInt16[Array, "rows columns *channels"]:
        """A photograph of an image: shot noise (Poisson), read noise (normal), saturation, and codes.

        Returns uint8 for 8 bits, else uint16; code = round(electrons / full_well (2^bits - 1)), clipped, of a camera
        that has no more than that. Of others in this order: what the lens loses to its rim, filters of the mosaic,
        noise, full well, scale and black level, rounding, the mosaic's other colours, transfer, JPEG. Raises ValueError
        for an image of another shape or with what is not finite, for what is no key, for a JPEG within a
        transformation, and where the noise takes more memory than there is.
        """
        if not is_real(image):
            raise ValueError(f"image is {shown(image)}; allowed: an array of finite irradiances")
        if np.shape(image) != self.image_shape:
            raise ValueError(f"the image has shape {np.shape(image)}; allowed: the camera's, {self.image_shape}")
        _check_key(key)
        if is_concrete(image, key):
            refuse_after_fork()
            image_memory(self.shape, _EXPOSING)
            require("image", image, "an array of finite irradiances", finite)
        light = jnp.asarray(image, dtype=float)
        if self.lens is not None:
            light = light * _falloff(self, light.ndim)
        if self.mosaic is not None:
            light = filtered(light, self.mosaic)
        shot, read = jax.random.split(key)
        mean = jnp.clip(light * self.exposure, 0.0, _MOST)
        arrived = jax.random.poisson(shot, mean).astype(mean.dtype)
        electrons = arrived + self.read_noise * jax.random.normal(read, mean.shape)
        return developed(electrons, self)


def _check_key(key) -> None:
    """Raise ValueError for what is neither one key of `jax.random` nor the two numbers of an old one."""
    shape = getattr(key, "shape", None)
    is_new = isinstance(key, jax.Array) and jnp.issubdtype(key.dtype, jax.dtypes.prng_key) and shape == ()
    if not (is_new or (getattr(key, "dtype", None) == np.uint32 and shape == (2,))):
        raise ValueError(f"key is {shown(key)}; allowed: a key such as jax.random.key(0)")


# Functions, not methods: equinox makes a module of a method each time that it is named, in 20 microseconds.
def _on_screen(camera: Camera, columns, rows):
    """Screen coordinates of columns and of rows [m]."""
    cx, cy = middle(camera.shape) if camera.centre_px is None else (camera.centre_px[0], camera.centre_px[1])
    return (columns - cx) * camera.pixel_size, (rows - cy) * camera.pixel_size


def _ends(camera: Camera) -> tuple[Float[Any, "2"], Float[Any, "2"]]:
    rows, columns = camera.shape
    return _on_screen(camera, np.array([0.0, columns - 1]), np.array([0.0, rows - 1]))


def _half_diagonal(camera: Camera) -> float:
    rows, columns = camera.shape
    return float(np.hypot(rows - 1, columns - 1)) / 2 or 1.0


def _from_axis(camera: Camera, lens: CameraLens, columns, rows):
    """Coordinates of columns and rows [px] from the lens's axis, and the axis."""
    axis = middle(camera.shape) if lens.axis_px is None else lens.axis_px
    return columns - axis[0], rows - axis[1], axis


def points_of(camera: Camera, columns, rows) -> tuple[Any, Any]:
    """Screen coordinates [m] at which pixels look, by their columns and rows, which need not be whole."""
    lens = camera.lens
    if lens is None:
        return _on_screen(camera, columns, rows)
    x, y, axis = _from_axis(camera, lens, columns, rows)
    x, y = seen_from(lens, _half_diagonal(camera), x, y)
    return _on_screen(camera, x + axis[0], y + axis[1])


def _falloff(camera: Camera, axes: int) -> Any:
    """The share of the light that the lens passes to each pixel, [rows, columns] or with an axis for channels."""
    lens: Any = camera.lens
    rows, columns = camera.shape
    along_x = jnp.arange(columns, dtype=float)
    along_y = jnp.arange(rows, dtype=float)[:, None]
    x, y, _ = _from_axis(camera, lens, along_x, along_y)
    share = passed_by(lens, _half_diagonal(camera), x, y)
    return jnp.broadcast_to(share, camera.shape).reshape(*camera.shape, *[1] * (axes - 2))


def grey(camera: Camera) -> Camera:
    """The camera with one channel that takes all wavelengths alike."""
    lens = camera.lens
    if lens is not None and lens.magnifications is not None:
        lens = replace(lens, magnifications=None)
    return replace(camera, response=None, mosaic=None, lens=lens)


def of_channel(camera: Camera, channel: int) -> Camera:
    """`grey`, its pixels looking where those of one channel do: of a larger image they look nearer to the axis."""
    lens = camera.lens
    if lens is None or lens.magnifications is None:
        return grey(camera)
    sizes: Any = lens.magnifications
    return replace(grey(camera), lens=replace(lens, magnifications=sizes[channel : channel + 1]))


def has_lateral_colour(camera: Camera) -> bool:
    """Whether its channels look at different points."""
    return camera.response is not None and camera.lens is not None and camera.lens.magnifications is not None


def window(camera: Camera, first: int, rows: int) -> Camera:
    """The camera that sees some rows of a camera's image."""
    centre = middle(camera.shape) if camera.centre_px is None else np.asarray(camera.centre_px)
    lens = None if camera.lens is None else in_window(camera.lens, camera.shape, first, rows)
    return replace(camera, shape=(rows, camera.shape[1]), centre_px=(centre[0], centre[1] - first), lens=lens)


def corners(camera: Camera) -> Float[Any, "4 2"]:
    """Screen points [m] of the centres of the pixels in the frame's corners."""
    rows, columns = camera.shape
    x, y = np.meshgrid([0.0, columns - 1], [0.0, rows - 1])
    x, y = points_of(camera, x.T.ravel(), y.T.ravel())
    return module_of(x).stack([x, y], axis=1)


def middle(shape: tuple[int, int]) -> tuple[float, float]:
    """(x, y) of the middle of an image in pixels."""
    return (shape[1] - 1) / 2, (shape[0] - 1) / 2


def node_points(camera: Camera, count: int) -> Float[Any, "n 2"]:
    """Screen points [m] of the grid of nodes over the image, row by row; NumPy where the camera's numbers are known."""
    x, y = points_of(camera, *node_pixels(camera.shape, count))
    return module_of(x).stack([x, y], axis=1)


def node_pixels(shape: tuple[int, int], count: int) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Columns and rows of the grid of nodes over an image, row by row."""
    at = nodes(count)
    y, x = np.meshgrid((shape[0] - 1) / 2 * (1 + at), (shape[1] - 1) / 2 * (1 + at), indexing="ij")
    return x.ravel(), y.ravel()
