"""Videos: frames as they were written, the same one by one and in a row, and one line where their reader is missing."""

import sys

import numpy as np
import pytest

import fitting
from fitting.batches import photographs
from fitting.photo import frames_of, read, video_files
from fitting.photo.image_file import load
from fitting.shell.cli import main

FRAMES, SHAPE = 40, (120, 160)


@pytest.fixture(scope="module")
def av():
    return pytest.importorskip("av", reason="the extra video is not installed")


def frame(number: int) -> np.ndarray:
    """Rings that open, whose centre moves, as codes of 8 bits."""
    y, x = np.indices(SHAPE)
    squared = ((x - 80.0 - 0.1 * number) ** 2 + (y - 60.0) ** 2) * 1e-3
    return np.round(128 + 90 * np.cos(2 * np.pi * (squared + 0.02 * number))).astype(np.uint8)


def write(av, path, codec: str, pixels: str, turned: float = 0.0, frames: int = FRAMES) -> None:
    """A video of these frames, with a key frame every 12, and frames that are coded by later ones."""
    with av.open(str(path), "w") as file:
        stream = file.add_stream(codec, rate=25)
        stream.height, stream.width, stream.pix_fmt = *SHAPE, pixels
        stream.codec_context.gop_size = 12
        if turned:
            stream.set_display_rotation(turned)
        for number in range(frames):
            codes = frame(number)
            if pixels == "gray16le":
                picture = av.VideoFrame.from_ndarray(codes.astype(np.uint16) * 256 + number, format="gray16le")
            else:
                picture = av.VideoFrame.from_ndarray(codes, format="gray").reformat(format=pixels)
            file.mux(stream.encode(picture))
        file.mux(stream.encode())


CODECS = {"a.mp4": "libx264", "a.mkv": "libx264", "a.avi": "mjpeg", "a.mpg": "mpeg1video"}


@pytest.mark.parametrize(("name", "codec"), CODECS.items())
def test_each_frame_of_a_video_is_the_one_that_was_written(av, tmp_path, name, codec):
    path = tmp_path / name
    write(av, path, codec, "yuvj420p" if codec == "mjpeg" else "yuv420p")
    in_a_row = list(frames_of(path))
    assert len(in_a_row) == FRAMES == load(path).pages
    for number, codes in enumerate(in_a_row):
        misfit = [np.abs(codes[..., 1].astype(float) - frame(other)).mean() for other in range(FRAMES)]
        assert np.argmin(misfit) == number
    for number in (0, 5, 11, 12, 29, FRAMES - 1):
        assert np.array_equal(load(path, number + 1).codes, in_a_row[number])


def test_a_lossless_grey_video_keeps_all_bits(av, tmp_path):
    path = tmp_path / "camera.mkv"
    write(av, path, "ffv1", "gray16le")
    expected = frame(17).astype(np.uint16) * 256 + 17
    assert np.array_equal(load(path, 18).codes, expected)


def test_a_video_is_turned_as_the_file_says(av, tmp_path):
    for name, turned in (("up.mp4", 0.0), ("held.mp4", 90.0)):
        write(av, tmp_path / name, "libx264", "yuv420p", turned)
    upright, held = (load(tmp_path / name, 8).codes for name in ("up.mp4", "held.mp4"))
    assert held.shape[:2] == SHAPE[::-1]
    assert np.array_equal(held, np.rot90(upright))


def test_stack_and_batch_measure_each_frame(av, tmp_path, capsys):
    path = tmp_path / "rings.mp4"
    write(av, path, "libx264", "yuv420p", frames=4)
    given = {"wavelength": 589.3e-9, "pixel_size": 30e-6, "view": "reflected"}
    rows = [row for row in fitting.fit_stack(path, **given) if row.status == "ok"]
    assert len(rows) == 4
    expected = 30e-6**2 / (1e-3 * 589.3e-9)
    assert all(abs(row.radius - expected) < 0.02 * expected for row in rows)
    options = ["--wavelength", "589.3nm", "--pixel-size", "30um", "--view", "reflected", "--workers", "1"]
    assert main(["batch", str(tmp_path), *options, "--output-dir", str(tmp_path / "rows")]) == 0
    assert "4 photographs" in capsys.readouterr().out
    assert len((tmp_path / "rows/summary.csv").read_text().splitlines()) == 4 + 1


def test_without_the_extra_one_line_names_it(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "av", None)
    path = tmp_path / "film.mp4"
    path.write_bytes(b"\0\0\0\x20ftypisom" + b"\0" * 64)
    with pytest.raises(ValueError, match=r"film\.mp4 .*pip install 'newtonjax\[video\]'") as refusal:
        fitting.fit_stack(path, wavelength=589.3e-9)
    assert "\n" not in str(refusal.value)
    with pytest.raises(ValueError, match=r"pip install 'newtonjax\[video\]'"):
        read(path)
    assert main(["fit", str(path), "--wavelength", "sodium"]) == 2
    message = capsys.readouterr().err
    assert "pip install 'newtonjax[video]'" in message
    assert message.count("\n") == 1


@pytest.mark.parametrize("damage", ["no video at all", "cut"])
def test_a_damaged_video_is_refused_in_one_line(av, tmp_path, damage):
    path = tmp_path / "film.mp4"
    path.write_bytes(b"no video at all" * 9)
    if damage == "cut":
        write(av, path, "libx264", "yuv420p")
        path.write_bytes(path.read_bytes()[:4000])
    with pytest.raises(ValueError, match=r"film\.mp4 cannot be read as an image \(") as refusal:
        load(path)
    assert "\n" not in str(refusal.value)


def test_a_folder_s_videos_are_recognized_by_their_names(tmp_path):
    for suffix in video_files.SUFFIXES:
        (tmp_path / f"film{suffix}").touch()
    assert len(photographs([tmp_path])) == len(video_files.SUFFIXES)
