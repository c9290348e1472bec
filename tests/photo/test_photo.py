"""Reading photographs: formats, transfer, channel and mask."""

import subprocess
import sys
import tracemalloc

import imageio.v3 as iio
import numpy as np
import pytest
from PIL import Image
from rings_data import rings

import fitting
from fitting.photo import read
from fitting.photo.image_file import load
from newtonjax.numerics import memory


def codes(image, bits=8):
    top = 2**bits - 1
    return np.round(np.clip(image * 0.9, 0, 1) * top).astype(np.uint8 if bits == 8 else np.uint16)


def encode_srgb(linear):
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("suffix", [".png", ".tif", ".webp"])
def test_eight_bit_files_are_srgb_and_become_linear_light(tmp_path, suffix):
    light = 0.9 * rings() + 0.05
    stored = np.round(encode_srgb(light) * 255).astype(np.uint8)
    stored = np.repeat(stored[..., None], 3, axis=2) if suffix == ".webp" else stored
    options = {"lossless": True} if suffix == ".webp" else {}
    iio.imwrite(tmp_path / f"rings{suffix}", stored, **options)
    photo = read(tmp_path / f"rings{suffix}")
    ratio = photo.image / light
    # Half a code of 255 is at most 1.5 % of the light above a tenth.
    assert np.ptp(ratio[light > 0.1]) < 0.05
    assert photo.transfer == "srgb"


def test_inks_and_single_bits_are_read_as_light(tmp_path):
    image = Image.fromarray(codes(encode_srgb(rings(noise=0.02).clip(0, 1))))
    image.convert("RGB").convert("CMYK").save(tmp_path / "inks.jpg", quality=95)
    assert np.corrcoef(read(tmp_path / "inks.jpg").image.ravel(), rings().ravel())[0, 1] > 0.98
    image.convert("1").save(tmp_path / "bits.png")
    assert load(tmp_path / "bits.png").codes.dtype == bool


def test_sixteen_bit_files_are_linear(tmp_path):
    light = 0.9 * rings() + 0.05
    iio.imwrite(tmp_path / "rings.png", np.round(light * 60000).astype(np.uint16))
    photo = read(tmp_path / "rings.png")
    assert photo.transfer == "linear"
    assert np.ptp(photo.image / light) < 1e-3


def test_channel_with_most_unsaturated_contrast_is_taken():
    light = rings()
    colour = np.stack([np.full(light.shape, 255), codes(light), codes(0.02 * light)], axis=2).astype(np.uint8)
    assert read(colour).channel == "green"


def test_saturated_pixels_are_masked_and_told():
    image = codes(rings())
    image[:60] = 255
    photo = read(image)
    assert not photo.mask[:60].any()
    assert any("saturated" in text for text in photo.warnings)


def test_dark_surround_of_a_round_field_is_masked():
    y, x = np.mgrid[-1:1:256j, -1:1:256j]
    inside = x * x + y * y < 0.6
    light = np.where(inside, 0.3 + 0.6 * rings(0.3), 0.01)
    photo = read(light)
    assert photo.mask[~inside].mean() < 0.01
    assert photo.mask[inside].mean() > 0.8


def few_rings_in_a_stop(orders: float, soft: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray, float]:
    """Wide rings in a round stop, lit from the right, with noise; where the stop is open, and turns per pixel²."""
    y, x = np.mgrid[:300, :340].astype(float)
    r2 = (x - 80) ** 2 + (y - 165) ** 2
    scale = orders / 110**2
    lit = 1 / (1 + np.exp((np.hypot(x - 150, y - 155) - 110) / soft))
    light = (0.004 + lit * np.exp(1.8 * (x / 170 - 1))) * (0.5 - 0.48 * np.cos(2 * np.pi * scale * r2))
    return light + np.random.default_rng(seed).normal(0, 0.006, light.shape), lit, scale


@pytest.mark.parametrize("orders", [3.0, 4.0, 6.0])
@pytest.mark.parametrize("soft", [2.0, 8.0])
def test_a_stop_is_found_around_rings_that_are_wide(orders, soft):
    light, lit, scale = few_rings_in_a_stop(orders, soft)
    used = read(light).mask
    assert used[lit < 0.01].mean() < 0.1
    assert used[lit > 0.9].mean() > 0.9
    result = fitting.fit(light, wavelength=589.3e-9)
    if result.fringe_scale_per_px2 is not None:
        assert abs(result.fringe_scale_per_px2 - scale) < 4 * result.fringe_scale_sd


def test_a_black_contact_inside_of_the_frame_is_no_surround():
    y, x = np.mgrid[:300, :300].astype(float)
    r2 = np.maximum((x - 150) ** 2 + (y - 150) ** 2 - 85**2, 0.0)
    light = 0.5 - 0.5 * np.cos(2 * np.pi * r2 / 5000)
    assert read(light + np.random.default_rng(0).normal(0, 0.004, light.shape)).mask.all()


@pytest.mark.parametrize("radius", [0.1, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("dark", [True, False])
@pytest.mark.parametrize("centre", [(130.0, 120.0), (0.0, 0.0), (20.0, 330.0)])
def test_a_frame_without_surround_keeps_its_dark_rings(radius, dark, centre):
    assert read(rings(radius, centre=centre, dark=dark, noise=0.02)).mask.all()


@pytest.mark.parametrize("transfer", ["linear", "srgb", 2.2, "2.2"])
def test_transfer_of_the_user_wins(transfer):
    assert read(codes(rings()), transfer).transfer in ("linear", "srgb", "exponent 2.2")


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (np.zeros((3, 3)), "shape"),
        (np.zeros(40), "shape"),
        (np.zeros((64, 64, 7)), "channels"),
        (np.array([["a"] * 20] * 20), "type"),
    ],
)
def test_what_is_no_image_is_refused(image, words):
    with pytest.raises(ValueError, match=words):
        read(image)


def test_missing_and_broken_files_say_so(tmp_path):
    with pytest.raises(FileNotFoundError, match="is not a file"):
        read(tmp_path / "none.png")
    for name, content in (("broken.jpg", b"\xff\xd8\xff\xe0 broken"), ("text.png", b"hello")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ValueError, match="cannot be read as an image"):
            read(tmp_path / name)
    with pytest.raises(FileNotFoundError, match="is a folder, whose photographs newtonjax batch measures"):
        read(tmp_path)


def test_what_needs_more_memory_than_there_is_is_refused_with_its_size_and_a_way_out(tmp_path, monkeypatch):
    codes = np.zeros((4000, 5000), np.uint8)
    iio.imwrite(tmp_path / "large.png", codes)
    iio.imwrite(tmp_path / "large.tif", codes)
    assert read(codes).mask.shape == (4000, 5000)
    monkeypatch.setattr(memory, "available_memory", lambda: 30_000_000)
    for source in (tmp_path / "large.png", tmp_path / "large.tif", codes):
        with pytest.raises(ValueError, match=r"4000 x 5000 pixels.*needs [0-9.]+ MB .*30 MB are available; crop"):
            read(source)


def test_a_header_is_read_without_the_limit_of_the_decoder(tmp_path, monkeypatch):
    """Pillow refuses more than 179 Mpx, and warns of half of that, whatever memory there is."""
    iio.imwrite(tmp_path / "rings.png", codes(rings()))
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 1000)
    assert load(tmp_path / "rings.png").codes.shape == (256, 256)
    assert Image.MAX_IMAGE_PIXELS == 1000


def test_a_photograph_is_read_without_jax(tmp_path):
    """JAX takes a third of a second and 110 MB, as much as a photograph of 10 megapixels."""
    Image.fromarray(np.uint8(255 * rings().clip(0, 1))).save(tmp_path / "rings.png")
    program = "import sys; from fitting.photo import read; read(sys.argv[1]); print('jax' in sys.modules)"
    command = [sys.executable, "-c", program, str(tmp_path / "rings.png")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "False\n"


def test_a_picture_is_decoded_into_one_array(tmp_path):
    """Pillow's own way to an array takes twice its bytes."""
    colours = np.random.default_rng(0).integers(0, 256, (2000, 1000, 3), np.uint8)
    Image.fromarray(colours).save(tmp_path / "noise.bmp")
    load(tmp_path / "noise.bmp")
    tracemalloc.start()
    try:
        picture = load(tmp_path / "noise.bmp")
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert np.array_equal(picture.codes, colours)
    assert peak < 1.6 * colours.nbytes


@pytest.mark.parametrize("kind", [np.int32, np.int64, np.uint32])
def test_small_values_of_wide_integers_are_codes_unless_they_are_said_to_be_light(kind):
    codes = np.round(rings() * 254).astype(kind)
    by_itself, as_bytes = read(codes), read(codes.astype(np.uint8))
    assert any("give transfer='linear' for counts of light" in text for text in by_itself.warnings)
    for photo in (by_itself, read(codes, "srgb")):
        assert np.allclose(photo.image, as_bytes.image)
        assert np.array_equal(photo.mask, as_bytes.mask)
    counts = read(codes, "linear")
    assert counts.mask.all()
    assert np.allclose(counts.image / counts.image.max(), codes / codes.max())
    assert counts.warnings == []
    assert read(codes, "srgb").warnings == as_bytes.warnings
    assert read(codes * 200).warnings == []
