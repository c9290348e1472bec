"""Photographs: from a file or an array to linear light, a mask, and what was decided on the way."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from fitting.photo.arrays import Planes, below, clearest_channel, planes_of
from fitting.photo.codes import Codes, Curve, lit_field, not_wild, reasons_left_out, saturation, thin
from fitting.photo.image_file import SMALLER, load
from fitting.photo.masks import checked_mask
from fitting.reasons import Reason
from newtonjax.numerics import require_memory, shown

_CHANNELS = ("red", "green", "blue")


@dataclass(frozen=True)
class Photograph:
    """A photograph made ready for a fit: the codes of one channel, from which light is made in bands or as a whole.

    - `codes`: of the channel that was taken, with the curve that makes them linear light, largest unmasked about 1.
    - `mask` [rows, columns]: True where a pixel may be used.
    - `lit` [rows, columns]: as `mask`, with saturated pixels: bright they are, and a search that took them for nothing
      would find the rings of the mask.
    - `channel`: which was taken; `transfer`: how codes became light; `warnings`: what a person should know.
    - `dim` [rows, columns]: beyond `lit`, but within the field stop: usable but for its weak light; None for nothing.
    - `left_out`: pixels that are not in `mask`, by reason.
    - `has_two_levels`: whether pixels are light or dark and nothing between; `is_uniform`: whether all usable ones have
      one code.
    """

    codes: Codes
    mask: np.ndarray
    lit: np.ndarray
    channel: str
    transfer: str
    warnings: list[str] = field(default_factory=list)
    has_two_levels: bool = False
    is_uniform: bool = False
    dim: np.ndarray | None = None
    left_out: dict[str, int] = field(default_factory=dict)

    @cached_property
    def image(self) -> np.ndarray:
        """Linear light of every pixel, float64 [rows, columns]; made when first asked for."""
        return self.codes.light()


def read(
    image: str | Path | np.ndarray,
    transfer: str | float | None = None,
    mask: str | Path | np.ndarray | None = None,
    page: int | None = None,
    channel: str | None = None,
) -> Photograph:
    """A photograph from a file or an array [rows, columns] or [rows, columns, channels].

    Without `transfer`, 8-bit codes (also in wider integers, with a warning) are taken as sRGB, others as linear; it may
    be "linear", "srgb" or an exponent. Of a colour image `channel` ("red", "green" or "blue") is taken, or without it
    the one with most fringe contrast over noise that is not saturated. Masked are pixels that are saturated (at the top
    of the type, or where codes pile up below it), outside of the lit field, transparent, masked in the array, far
    outside of all others (hot or dead), and where `mask` is False.
    Of a file with several pictures `page` says which, from 1 on; the first is taken, with a warning, where it does not.

    Raises FileNotFoundError, and ValueError for what is no image or needs more memory than there is.
    """
    planes, warnings = _ready(image, transfer, page)
    number = clearest_channel(planes) if channel is None else _number_of(channel, planes)
    label = _labels(planes)[number]
    # The other channels of a file are not kept until the end.
    planes = _single(planes, number)
    return _photograph(planes, label, transfer, mask, warnings)


def read_channels(
    image: str | Path | np.ndarray,
    transfer: str | float | None = None,
    mask: str | Path | np.ndarray | None = None,
    page: int | None = None,
) -> tuple[Photograph, ...]:
    """All channels of an image: red, green and blue, or grey alone; arguments and errors as `read`."""
    planes, warnings = _ready(image, transfer, page)
    photographs = []
    for number, label in enumerate(_labels(planes)):
        single = _single(planes._replace(visible=planes.visible.copy()), number)
        photographs.append(_photograph(single, label, transfer, mask, list(warnings)))
    return tuple(photographs)


def _ready(image, transfer: str | float | None, page: int | None) -> tuple[Planes, list[str]]:
    """The channels of an image, its integers taken for codes of 8 bits where they can be."""
    planes, warnings = _planes(image, page)
    if planes.may_be_bytes and (transfer is None or (isinstance(transfer, str) and transfer == "srgb")):
        planes = planes._replace(top=255.0)
        if transfer is None:
            kind = planes.codes.dtype
            warnings.append(Reason.READ_AS_8_BIT(kind=kind))
    rows, columns = planes.codes.shape[:2]
    itemsize = planes.codes.itemsize
    # One channel, a mask, the lit field, and what passes by while these are made.
    require_memory(f"a photograph of {rows} x {columns} pixels", float(rows) * columns * (itemsize + 5), SMALLER)
    return planes, warnings


def _number_of(channel: str, planes: Planes) -> int:
    """Which channel is meant. Raises ValueError for a name that the image does not have."""
    labels = _labels(planes)
    if not (isinstance(channel, str) and channel in labels):
        raise ValueError(f"channel is {shown(channel)}; allowed for this image: {', '.join(labels)}")
    return labels.index(channel)


def _labels(planes: Planes) -> tuple[str, ...]:
    return _CHANNELS if planes.channels == 3 else ("grey",)


def _single(planes: Planes, number: int) -> Planes:
    """One channel of an image, as a copy."""
    # A copy of its own, for an array of the caller's may change later; in this machine's order of bytes.
    kind = planes.codes.dtype.newbyteorder("=")
    codes = np.array(planes.codes[:, :, number : number + 1], kind, order="C")
    return planes._replace(codes=codes, channels=1)


def _photograph(planes: Planes, label: str, transfer: str | float | None, mask, warnings: list[str]) -> Photograph:
    """The first channel of an image, made ready."""
    plane, top = planes.codes[:, :, 0], planes.top
    exponent, name = _transfer(transfer, top)
    codes = Codes(plane, Curve(top if np.isfinite(top) else 1.0, exponent))
    lit, has_two_levels = planes.visible, planes.has_two_levels
    if not np.issubdtype(plane.dtype, np.integer):
        lit &= np.isfinite(plane)
    lit &= not_wild(codes, lit)
    if mask is not None:
        lit &= checked_mask(mask, plane.shape)
    # Of two levels one is no saturation.
    follows = below(plane, np.inf if has_two_levels else saturation(plane, top))
    bright, dim = lit_field(codes)
    dim = None if dim is None else dim & lit & follows
    allowed, lit = lit, lit & bright
    usable = lit & follows
    left_out = reasons_left_out(allowed, lit, usable, dim)
    is_uniform = codes.is_uniform(usable)
    share = 1.0 - float(np.mean(follows))
    if share > 0.02:
        warnings.append(Reason.SATURATED(share=share))
    sample = thin(usable)
    light = codes.light_where(usable[sample], sample)
    unit = float(np.percentile(light, 99.5)) if light.size else 0.0
    codes = Codes(plane, replace(codes.curve, unit=unit or 1.0))
    return Photograph(codes, usable, lit, label, name, warnings, has_two_levels, is_uniform, dim, left_out)


def read_again(source: np.ndarray, like: Photograph) -> Photograph:
    """Another frame of the same view, read as `like` was: its channel, curve, unit of light and lit field.

    Masked are pixels that are saturated, far outside of all others or no numbers in this frame. Raises ValueError for
    an image of another shape or type.
    """
    planes = planes_of(source)
    if planes.visible.shape != like.codes.shape:
        raise ValueError(f"the frame has the shape {planes.visible.shape}, others {like.codes.shape}")
    channel = _CHANNELS.index(like.channel) if like.channel in _CHANNELS else 0
    kind, channels = planes.codes.dtype.newbyteorder("="), planes.codes.shape[2]
    if kind != like.codes.codes.dtype or channel >= channels:
        kinds = f"{kind} with {channels} channels"
        raise ValueError(f"the frame is {kinds}, others {like.codes.codes.dtype} of which {like.channel} is used")
    plane = np.array(planes.codes[:, :, channel], like.codes.codes.dtype, order="C")
    lit = like.lit & planes.visible
    if not np.issubdtype(plane.dtype, np.integer):
        lit &= np.isfinite(plane)
    codes = Codes(plane, like.codes.curve)
    lit &= not_wild(codes, lit)
    top = like.codes.curve.top if np.issubdtype(plane.dtype, np.integer) else np.inf
    usable = lit & below(plane, np.inf if like.has_two_levels else saturation(plane, top))
    is_uniform = codes.is_uniform(usable)
    return replace(like, codes=codes, lit=lit, mask=usable, warnings=[], is_uniform=is_uniform)


def _planes(source: str | Path | np.ndarray, page: int | None) -> tuple[Planes, list[str]]:
    """The channels of a file or an array, and what is to be said of them."""
    warnings = []
    if isinstance(source, str | Path):
        picture = load(source, page)
        planes = planes_of(picture.codes)
        if page is None and picture.pages > 1:
            warnings.append(Reason.FIRST_PAGE(pages=picture.pages))
    elif page is None:
        planes = planes_of(source)
    else:
        raise ValueError(f"page is {shown(page)} and the image an array; a page goes with a file: leave it out")
    if planes.has_two_levels:
        warnings.append(Reason.TWO_LEVELS())
    return planes, warnings


def _transfer(transfer: str | float | None, top: float) -> tuple[float | None, str]:
    """The curve's exponent, None for sRGB, and its name."""
    if transfer is None:
        transfer = "srgb" if top <= 255 else "linear"
    if isinstance(transfer, str) and transfer in ("linear", "srgb"):
        return (1.0 if transfer == "linear" else None), str(transfer)
    try:
        exponent = float(transfer) if isinstance(transfer, str | float | int | np.number) else np.nan
    except (TypeError, ValueError, OverflowError):
        exponent = np.nan
    if not 0.1 <= exponent <= 10:
        raise ValueError(f"transfer is {shown(transfer)}; allowed: 'linear', 'srgb', or an exponent from 0.1 to 10")
    return exponent, f"exponent {exponent:g}"
