"""Kinds of files: the codes that come back are those that were written, with all bits, from the page that is named."""

import struct
import zlib

import numpy as np
import png
import pytest
import tifffile
from PIL import Image
from rings_data import rings

import fitting
from fitting.photo import frames_of, pillow_files, read
from fitting.photo.image_file import load

pytestmark = pytest.mark.usefixtures("untyped")
LIGHT = 0.9 * rings(noise=0.01).clip(0, 1) + 0.05
GREY = np.round(LIGHT * 60_000).astype(np.uint16)
COLOURS = np.stack([GREY, GREY // 2, GREY[::-1]], axis=2)
PLANAR = np.moveaxis(COLOURS, 2, 0)
GIVEN = {"wavelength": 589.3e-9, "pixel_size": 5e-6, "view": "reflected"}


def colours_by_pillow(path, compression: str, predictor: bool) -> None:
    """A TIFF of 16-bit colours, which Pillow cannot write: its grey TIFF of their bytes, with another directory."""
    differences = np.diff(COLOURS, axis=1, prepend=np.zeros_like(COLOURS[:, :1]))
    codes = differences if predictor else COLOURS
    Image.fromarray(codes.astype("<u2").view(np.uint8).reshape(len(codes), -1)).save(path, compression=compression)
    content = bytearray(path.read_bytes())
    (place,) = struct.unpack_from("<I", content, 4)
    (count,) = struct.unpack_from("<H", content, place)
    entries = {}
    for k in range(count):
        entry = bytes(content[place + 2 + 12 * k : place + 14 + 12 * k])
        entries[struct.unpack_from("<H", entry)[0]] = entry
    bits = len(content)
    content += struct.pack("<3H", 16, 16, 16)
    for tag, number in ((256, codes.shape[1]), (262, 2), (277, 3), (317, 2 if predictor else 1)):
        entries[tag] = struct.pack("<HHII", tag, 4, 1, number)
    entries[258] = struct.pack("<HHII", 258, 3, 3, bits)
    content[4:8] = struct.pack("<I", len(content))
    content += struct.pack("<H", len(entries)) + b"".join(entries[tag] for tag in sorted(entries)) + bytes(4)
    path.write_bytes(content)


@pytest.mark.parametrize("predictor", [False, True])
@pytest.mark.parametrize("compression", ["tiff_lzw", "packbits", "tiff_adobe_deflate", "tiff_deflate"])
def test_compressed_tiffs_of_sixteen_bit_colours_keep_every_bit(tmp_path, compression, predictor):
    colours_by_pillow(tmp_path / "rings.tif", compression, predictor)
    assert np.array_equal(load(tmp_path / "rings.tif").codes, COLOURS)


@pytest.mark.parametrize("compression", [None, "tiff_lzw", "packbits", "tiff_adobe_deflate"])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
def test_grey_tiffs_keep_every_bit(tmp_path, compression, kind):
    codes = LIGHT.astype(kind) if kind == np.float32 else (GREY // (256 if kind == np.uint8 else 1)).astype(kind)
    Image.fromarray(codes).save(tmp_path / "rings.tif", compression=compression)
    assert np.array_equal(load(tmp_path / "rings.tif").codes, codes)


TIFFS = {
    "colours": (COLOURS, COLOURS, {}),
    "big": (COLOURS, COLOURS, {"bigtiff": True}),
    "big-endian": (COLOURS, COLOURS, {"byteorder": ">", "compression": "zlib"}),
    "tiles of differences": (COLOURS, COLOURS, {"tile": (64, 48), "compression": "zlib", "predictor": 2}),
    "planes": (PLANAR, COLOURS, {"planarconfig": "separate"}),
    "packed planes": (PLANAR, COLOURS, {"planarconfig": "separate", "compression": "zlib"}),
    "opacity": (np.dstack([COLOURS, GREY]), np.dstack([COLOURS, GREY]), {"extrasamples": ["unassalpha"]}),
    "a fourth sample": (np.dstack([COLOURS, GREY]), COLOURS, {"extrasamples": ["unspecified"]}),
    "doubles": (LIGHT, LIGHT, {"photometric": "minisblack", "compression": "zlib"}),
    "halves": (LIGHT.astype(np.float16), LIGHT.astype(np.float16), {"photometric": "minisblack"}),
    "white is zero": (65_535 - GREY, GREY, {"photometric": "miniswhite"}),
    "turned": (GREY, GREY[::-1].T, {"photometric": "minisblack", "extratags": [(274, 3, 1, 6, True)]}),
}


@pytest.mark.parametrize("name", sorted(TIFFS))
def test_tiffs_of_every_layout_keep_every_bit(tmp_path, name):
    written, codes, options = TIFFS[name]
    tifffile.imwrite(tmp_path / "rings.tif", written, **{"photometric": "rgb", **options})
    assert np.array_equal(load(tmp_path / "rings.tif").codes, codes)


@pytest.mark.parametrize("alpha", [False, True])
def test_sixteen_bit_colours_and_opacity_of_a_png_keep_every_bit(tmp_path, alpha):
    codes = np.dstack([GREY, np.full_like(GREY, 65_535)]) if alpha else COLOURS
    writer = png.Writer(256, 256, greyscale=alpha, alpha=alpha, bitdepth=16)
    with (tmp_path / "rings.png").open("wb") as file:
        writer.write(file, codes.reshape(256, -1).tolist())
    assert np.array_equal(load(tmp_path / "rings.png").codes, codes)


def deep_colours(path, exif: bytes = b"") -> None:
    """A PNG of 16-bit colours, with EXIF data in front of its pixels."""
    with path.open("wb") as file:
        png.Writer(256, 256, greyscale=False, bitdepth=16).write(file, COLOURS.reshape(256, -1).tolist())
    content = path.read_bytes()
    chunk = b"eXIf" + exif
    added = struct.pack(">I", len(exif)) + chunk + struct.pack(">I", zlib.crc32(chunk)) if exif else b""
    path.write_bytes(content[:33] + added + content[33:])


def test_sixteen_bit_colours_of_a_png_are_turned_as_their_exif_data_say(tmp_path):
    turned = Image.Exif()
    turned[0x0112] = 6
    deep_colours(tmp_path / "rings.png", turned.tobytes()[6:])
    assert np.array_equal(load(tmp_path / "rings.png").codes, COLOURS[::-1].swapaxes(0, 1))
    Image.fromarray(COLOURS.astype(np.uint8)).save(tmp_path / "plain.png", exif=turned)
    assert np.array_equal(load(tmp_path / "plain.png").codes, COLOURS.astype(np.uint8)[::-1].swapaxes(0, 1))


def test_frames_of_a_png_keep_every_bit_and_its_opacity(tmp_path):
    Image.fromarray(GREY).save(tmp_path / "grey.png")
    deep_colours(tmp_path / "deep.png")
    clear = np.dstack([GREY.astype(np.uint8)] * 3 + [np.uint8(255 * (GREY > 20_000))])
    first, *others = (Image.fromarray(np.roll(clear, k, axis=0)) for k in range(3))
    first.save(tmp_path / "clear.png", save_all=True, append_images=others, blend=0)
    assert np.array_equal(list(frames_of(tmp_path / "grey.png")), [GREY])
    assert np.array_equal(list(frames_of(tmp_path / "deep.png")), [COLOURS])
    for k, frame in enumerate(frames_of(tmp_path / "clear.png")):
        assert np.array_equal(frame, np.roll(clear, k, axis=0))


def test_a_later_frame_of_a_png_of_sixteen_bit_colours_is_refused(tmp_path, monkeypatch):
    """Pillow alone reads such frames, with 8 bits; not the first one in the place of another."""
    deep_colours(tmp_path / "film.png")
    monkeypatch.setattr(pillow_files, "layout", lambda _: ((256, 256), 6, 2))
    with pytest.raises(ValueError, match="the first frame alone can be read"):
        load(tmp_path / "film.png", 2)
    codes, refusal = frames_of(tmp_path / "film.png")
    assert np.array_equal(codes, COLOURS)
    assert "the first frame alone" in str(refusal)


@pytest.mark.parametrize("suffix", [".png", ".gif", ".tif"])
def test_a_palette_becomes_its_colours(tmp_path, suffix):
    image = Image.fromarray((GREY // 257).astype(np.uint8)).convert("P")
    image.save(tmp_path / f"rings{suffix}")
    codes = load(tmp_path / f"rings{suffix}").codes
    assert np.array_equal(codes[:, :, 0] if codes.ndim == 3 else codes, np.asarray(image.convert("L")))


def test_arrays_in_files_of_numpy_are_photographs(tmp_path):
    np.save(tmp_path / "one.npy", np.asfortranarray(COLOURS))
    np.save(tmp_path / "stack.npy", np.stack([GREY, GREY[::-1]]))
    np.savez_compressed(tmp_path / "lone.npz", LIGHT)
    np.savez(tmp_path / "named.npz", mask=GREY > 9, image=LIGHT)
    assert np.array_equal(load(tmp_path / "one.npy").codes, COLOURS)
    assert np.array_equal(load(tmp_path / "stack.npy", 2).codes, GREY[::-1])
    assert np.array_equal(load(tmp_path / "lone.npz").codes, LIGHT)
    assert np.array_equal(load(tmp_path / "named.npz").codes, LIGHT)
    assert np.array_equal(list(frames_of(tmp_path / "stack.npy")), [GREY, GREY[::-1]])


@pytest.mark.parametrize("picture", [GREY, COLOURS])
def test_a_stack_of_one_picture_is_one(tmp_path, picture):
    np.save(tmp_path / "stack.npy", picture[None])
    assert np.array_equal(load(tmp_path / "stack.npy").codes, picture)
    assert np.array_equal(read(tmp_path / "stack.npy").image, read(picture).image)
    assert np.array_equal(list(frames_of(tmp_path / "stack.npy")), [picture])


def test_a_mask_in_a_jpeg_is_where_it_is_white_not_where_its_edges_ring(tmp_path):
    white = np.zeros(LIGHT.shape, bool)
    white[40:200, 30:222] = True
    Image.fromarray(255 * white.astype(np.uint8)).save(tmp_path / "mask.jpg", quality=60)
    assert (load(tmp_path / "mask.jpg").codes[~white] > 0).any()
    Image.fromarray(white.astype(np.uint8)).save(tmp_path / "mask.png")
    for name in ("mask.jpg", "mask.png"):
        assert np.array_equal(read(LIGHT, mask=tmp_path / name).mask, read(LIGHT, mask=white).mask)


def test_an_image_of_one_bit_that_is_uniform_is_refused(tmp_path):
    Image.fromarray(np.ones((64, 64), bool)).save(tmp_path / "white.png")
    for image in (tmp_path / "white.png", np.zeros((64, 64), bool)):
        result = fitting.fit(image, **GIVEN)
        assert (result.status, result.message) == ("refused", "the image is uniform: there are no fringes")


@pytest.mark.parametrize(
    ("name", "arrays", "words"),
    [
        ("two.npz", {"a": LIGHT, "b": LIGHT}, r"holds a, b; allowed: one array, or one that is named image"),
        ("objects.npy", np.array([[None] * 20] * 20), r"cannot be read as an image \(.*objects"),
        ("complex.npy", LIGHT + 0j, r"of type complex128; allowed: an array of real numbers"),
    ],
)
def test_arrays_that_are_no_photograph_are_refused_in_one_line(tmp_path, name, arrays, words):
    path = tmp_path / name
    if name.endswith("npz"):
        np.savez(path, **arrays)
    else:
        np.save(path, arrays)
    with pytest.raises(ValueError, match=words) as refusal:
        read(path)
    assert "\n" not in str(refusal.value)


FRAMES = [np.roll(np.dstack([GREY // 257] * 3).astype(np.uint8), 20 * k, axis=0) for k in range(3)]


@pytest.mark.parametrize("suffix", [".tif", ".png", ".gif", ".webp"])
def test_a_page_is_read_by_its_number_and_one_that_nobody_named_is_told(tmp_path, suffix):
    path = tmp_path / f"film{suffix}"
    first, *others = map(Image.fromarray, FRAMES)
    first.save(path, save_all=True, append_images=others, **({"lossless": True} if suffix == ".webp" else {}))
    for page, frame in enumerate(FRAMES, 1):
        # A GIF has a palette of 256 colours, and steps of one code.
        assert np.abs(load(path, page).codes[:, :, 0].astype(int) - frame[:, :, 0]).max() <= (suffix == ".gif")
    assert read(path).warnings == [
        "page 1 of 3 was measured; page=N (--page N) reads another one, fitting.fit_stack all"
    ]
    assert read(path, page=1).warnings == []
    for page in (0, 4, 1.5, True, "2"):
        with pytest.raises(ValueError, match=r"page is .*; allowed: 1 to 3, the pages of"):
            read(path, page=page)


def test_a_page_of_an_array_is_refused():
    with pytest.raises(ValueError, match="page is 1 and the image an array"):
        read(LIGHT, page=1)


def test_compressed_pages_are_the_frames_of_a_stack(tmp_path):
    first, *others = (Image.fromarray(np.roll(GREY, k)) for k in range(3))
    first.save(tmp_path / "stack.tif", save_all=True, append_images=others, compression="tiff_lzw")
    assert all(np.array_equal(frame, np.roll(GREY, k)) for k, frame in enumerate(frames_of(tmp_path / "stack.tif")))


@pytest.mark.parametrize("suffix", [".png", ".tif", "array", "codes"])
def test_rings_in_two_levels_are_measured(tmp_path, suffix):
    """A threshold moves no fringe: the radius within four deviations, and these below a thousandth."""
    bits = rings(0.15, shape=(400, 400), centre=(190.0, 210.0), noise=0.05) > 0.45
    image = {"array": bits, "codes": 255 * bits.astype(np.uint8)}.get(suffix, tmp_path / f"rings{suffix}")
    if suffix.startswith("."):
        Image.fromarray(bits).save(image)
    result = fitting.fit(image, **GIVEN)
    assert abs(result.radius - 0.15) < 4 * result.radius_sd < 4e-3 * 0.15
    assert any("two levels" in text for text in result.warnings)


def test_a_masked_array_keeps_its_mask_and_a_matrix_is_an_array():
    hidden = np.zeros(LIGHT.shape, bool)
    hidden[:100] = True
    assert not read(np.ma.masked_array(LIGHT, hidden)).mask[:100].any()
    assert not read(np.ma.masked_array(COLOURS, np.dstack([hidden] * 3))).mask[:100].any()
    with pytest.warns(PendingDeprecationWarning):
        matrix = np.asmatrix(LIGHT)
    assert np.array_equal(read(matrix).image, read(LIGHT).image)


@pytest.mark.parametrize(
    ("image", "words"),
    [
        ([[1, 2], [3]], "makes no array"),
        ([["a"] * 20] * 20, "of type <U1"),
        (LIGHT + 0j, "of type complex128"),
        (np.full((20, 20), None), "of type object"),
        (None, "image is None"),
        (np.zeros((20, 20), "M8[s]"), "datetime64"),
        (np.zeros((2, 20, 20, 3)), "shape"),
    ],
)
def test_what_is_no_array_of_real_numbers_is_refused_in_one_line(image, words):
    with pytest.raises(ValueError, match=words) as refusal:
        read(image)
    assert "\n" not in str(refusal.value)
    assert "allowed: an array of real numbers" in str(refusal.value)


@pytest.mark.parametrize(
    "image",
    [LIGHT[::-1, ::-1], LIGHT.T, LIGHT.astype(">f4"), LIGHT.astype(np.longdouble), LIGHT.astype(np.float16)],
    ids=["negative strides", "transposed", "big-endian", "long doubles", "halves"],
)
def test_an_array_is_read_whatever_its_memory_looks_like(image):
    image.setflags(write=False)
    assert np.allclose(read(image).image, read(np.array(image, float)).image, rtol=1e-3)
