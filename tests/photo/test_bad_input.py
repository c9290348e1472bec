"""Files that are no photographs: one clear line each, the right exit status, nothing half-written."""

import errno
import os
import struct
import zlib
from io import BytesIO

import imageio.v3 as iio
import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from PIL import Image
from rings_data import rings
from shell import refusal

import fitting
from fitting.photo.image_file import load


def encoded(extension: str) -> bytes:
    codes = np.uint8(255 * np.clip(rings(shape=(48, 64)), 0, 1))
    file = BytesIO(iio.imwrite("<bytes>", codes, extension=extension))
    return file.getvalue()


FILES = {extension: encoded(extension) for extension in (".png", ".jpg", ".tif", ".webp", ".bmp")}


@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.sampled_from(sorted(FILES)), st.integers(0, 6000), st.lists(st.tuples(st.integers(0, 6000), st.integers(0, 255)))
)
@example(".tif", 178, [(10, 1)])
def test_a_damaged_file_is_read_or_refused_in_one_line(tmp_path, extension, length, changes):
    """Cut off anywhere and with any bytes changed: an array with pixels, or a ValueError that names the file."""
    content = bytearray(FILES[extension][: max(length, 1)])
    for place, value in changes:
        content[place % len(content)] = value
    path = tmp_path / f"photo{extension}"
    path.write_bytes(content)
    try:
        said = "" if load(path).codes.size > 0 else "nothing was read"
    except ValueError as error:
        said = str(error)
    assert not said or (str(path) in said and "\n" not in said)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=400))
def test_bytes_of_any_kind_are_read_or_refused(tmp_path, content):
    path = tmp_path / "photo.png"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"cannot be read as an image|is empty"):
        load(path)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is empty"),
        (FILES[".png"][:60], "cannot be read as an image"),
        (b"%PDF-1.7 no picture", "cannot be read as an image"),
        (iio.imwrite("<bytes>", np.zeros((1, 1), np.uint8), extension=".png"), "16 pixels up"),
    ],
    ids=["empty", "truncated", "another kind", "one pixel"],
)
def test_files_that_hold_no_photograph_are_refused_in_one_line(tmp_path, capsys, content, said):
    path = tmp_path / "photo.png"
    path.write_bytes(content)
    assert said in refusal(capsys, "fit", path, "--wavelength", "sodium", "--json", tmp_path / "out.json")
    assert not (tmp_path / "out.json").exists()


def test_a_folder_in_place_of_a_photograph_is_refused(tmp_path, capsys):
    assert "is a folder, whose photographs newtonjax batch measures" in refusal(
        capsys, "fit", tmp_path, "--wavelength", "sodium"
    )


def test_an_image_too_large_for_memory_is_refused_before_it_is_unpacked(tmp_path, capsys):
    """A head of 20000 x 20000 pixels and nothing behind it."""
    import struct
    import zlib

    head = struct.pack(">IIBBBBB", 20_000, 20_000, 8, 2, 0, 0, 0)
    chunk = b"IHDR" + head
    png = b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
    path = tmp_path / "large.png"
    path.write_bytes(png)
    assert "large.png" in refusal(capsys, "fit", path, "--wavelength", "sodium")


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may read everything")
def test_a_photograph_without_permission_is_refused(tmp_path, capsys):
    path = tmp_path / "photo.png"
    path.write_bytes(FILES[".png"])
    path.chmod(0)
    assert "photo.png" in refusal(capsys, "fit", path, "--wavelength", "sodium")


def test_a_full_disk_at_the_report_leaves_nothing_half_written(tmp_path, monkeypatch):
    from fitting.parameters import output

    def full(self, data):
        raise OSError(errno.ENOSPC, "No space left on device", str(self))

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    with pytest.raises(OSError, match="No space left"):
        output.write(tmp_path / "report.txt", "text", force=False)
    assert list(tmp_path.iterdir()) == []


def test_a_small_file_that_says_it_is_huge_is_refused_before_it_is_decoded(tmp_path):
    def chunk(name: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    head = struct.pack(">IIBBBBB", 30_000, 30_000, 8, 0, 0, 0, 0)
    bomb = tmp_path / "bomb.png"
    bomb.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(100))))
    with pytest.raises(ValueError, match=r"says that it holds 30000 x 30000 pixels; allowed: 2e\+08 pixels; crop"):
        fitting.read(bomb)


@pytest.mark.parametrize("name", ["picture.png", "picture.tif"])
def test_pictures_up_to_the_number_of_pixels_that_the_user_names_are_read(tmp_path, monkeypatch, name):
    path = tmp_path / name
    Image.fromarray(np.arange(1024, dtype=np.uint8).reshape(32, 32)).save(path)
    monkeypatch.setenv("NEWTONJAX_LARGEST_PICTURE", "1000")
    with pytest.raises(ValueError, match=r"32 x 32 pixels; allowed: 1e\+03 pixels; .*NEWTONJAX_LARGEST_PICTURE=1\.1e"):
        fitting.read(path)
    monkeypatch.setenv("NEWTONJAX_LARGEST_PICTURE", "1024")
    assert fitting.read(path).codes.shape == (32, 32)
