"""Frames of videos as arrays of their codes (FFmpeg, by PyAV; the extra `video`)."""

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

NAMES, HEADS = ("video",), ()
SUFFIXES = (".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".mts", ".wmv", ".3gp")


def layout(path: Path) -> tuple[tuple[int, int], int, int]:
    """Shape [px], bytes a pixel and the number of frames of a file, none of which is decoded."""
    with _opened(path) as (_, stream):
        shape = stream.codec_context.height, stream.codec_context.width
    return shape, 3, len(_times(path, _stamp(path)))


def load(path: Path, number: int) -> np.ndarray:
    """Codes [rows, columns] or [rows, columns, 3] of a frame, the first one number 0, turned as the file says."""
    time = _times(path, _stamp(path))[number]
    with _opened(path) as (file, stream):
        file.seek(time, stream=stream)
        for frame in file.decode(stream):
            if frame.pts is None or frame.pts > time:
                break  # no way to look for a time, or none to this one
            if frame.pts == time:
                return _codes(frame)
    with _opened(path) as (file, stream):
        for count, frame in enumerate(file.decode(stream)):
            if count == number:
                return _codes(frame)
    raise ValueError(f"it ends before frame {number + 1}")


def each_frame(path: Path) -> Iterator[np.ndarray | Exception]:
    """Codes of one frame after the other; where they cannot be decoded, what was raised, and no more."""
    frames = _decoded(path)
    while True:
        try:
            yield next(frames)
        except StopIteration:
            return
        except Exception as error:  # a decoder that stumbled does not find its way back
            yield error
            return


def _decoded(path: Path) -> Iterator[np.ndarray]:
    with _opened(path) as (file, stream):
        yield from map(_codes, file.decode(stream))


@contextmanager
def _opened(path: Path) -> Generator[tuple[Any, Any], None, None]:
    """A file and its first stream of pictures. Raises ValueError where there is none, or no decoder."""
    try:
        import av  # pyright: ignore[reportMissingImports]  # an extra
    except ImportError as error:
        raise ValueError("videos need av; install it: pip install 'newtonjax[video]'") from error
    with av.open(str(path)) as file:
        if not file.streams.video:
            raise ValueError("it has no pictures")
        yield file, file.streams.video[0]


@lru_cache(maxsize=4)
def _times(path: Path, _: tuple[int, int]) -> list[int]:
    """When each frame is shown, in order, in the file's own unit: of the packets, which are not decoded.

    Kept, for all of a file is read for it, and a batch asks for each of its frames.
    """
    with _opened(path) as (file, stream):
        times = [packet.dts if packet.pts is None else packet.pts for packet in file.demux(stream) if packet.size]
    return sorted(0 if time is None else time for time in times)


def _stamp(path: Path) -> tuple[int, int]:
    status = path.stat()
    return status.st_size, status.st_mtime_ns


def _codes(frame: Any) -> np.ndarray:
    """Grey with all its bits, colours with eight: those with more have the same curve, and 16 bits count as linear."""
    if not frame.format.name.startswith("gray"):
        codes = frame.to_ndarray(format="rgb24")
    elif frame.format.components[0].bits > 8:
        codes = frame.to_ndarray(format="gray16le")
    else:
        codes = frame.to_ndarray(format="gray")
    # FFmpeg's angle is counterclockwise, as `rot90` turns.
    return np.rot90(codes, round(frame.rotation / 90))
