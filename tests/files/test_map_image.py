import os

import numpy as np
import pytest
from PIL import Image
from system_words import NO_FILE, NOT_PERMITTED
from systems import needs_permissions, needs_pipe

from trackctl.errors import MapError
from trackctl.files.map_image import read_image

GREY = np.arange(30, dtype=np.uint8).reshape(5, 6) * 8


@pytest.mark.parametrize("ending", ["pgm", "png", "bmp", "gif"])
def test_grey_images_of_all_kinds(tmp_path, ending):
    path = tmp_path / f"map.{ending}"
    Image.fromarray(GREY).save(path)
    image = read_image(path)
    np.testing.assert_array_equal(image.grey, GREY)
    assert not image.is_clear.any()


@pytest.mark.parametrize(
    "header", [b"P5\n# by hand\n6 5\n255\n", b"P5 6 5 255\n", b"P5\n6\n# one\n# two\n5\n# three\n255\n"]
)
def test_comments_in_a_header(tmp_path, header):
    path = tmp_path / "map.pgm"
    path.write_bytes(header + GREY.tobytes())
    np.testing.assert_array_equal(read_image(path).grey, GREY)


def test_a_pgm_in_letters_and_one_of_few_shades(tmp_path):
    path = tmp_path / "map.pgm"
    path.write_text("P2\n3 2\n4\n0 1 2\n3 4 0\n")
    assert read_image(path).grey.tolist() == [[0, 64, 128], [191, 255, 0]]


DEEP = np.array([[0, 128, 129, 257 * 205, 65535]], np.uint16)


def test_a_deep_png_is_rounded(tmp_path):
    path = tmp_path / "map.png"
    Image.fromarray(DEEP).save(path)
    assert read_image(path).grey.tolist() == [[0, 0, 1, 205, 255]]


def test_a_deep_pgm_is_rounded(tmp_path):
    path = tmp_path / "map.pgm"
    path.write_bytes(b"P5 5 1 65535\n" + DEEP.astype(">u2").tobytes())
    assert read_image(path).grey.tolist() == [[0, 0, 1, 205, 255]]


def test_a_bitmap_of_one_bit(tmp_path):
    path = tmp_path / "map.pbm"
    path.write_text("P1\n3 1\n0 1 0\n")  # 1 is black
    assert read_image(path).grey.tolist() == [[255, 0, 255]]


def test_colours_become_their_luma(tmp_path):
    path = tmp_path / "map.png"
    Image.fromarray(np.array([[[255, 0, 0], [0, 255, 0], [0, 0, 255], [205, 205, 205]]], np.uint8)).save(path)
    assert read_image(path).grey.tolist() == [[76, 150, 29, 205]]


def test_what_is_not_opaque_is_clear(tmp_path):
    path = tmp_path / "map.png"
    shades = np.array([[[10, 255], [20, 254], [30, 0]]], np.uint8)
    Image.fromarray(shades).save(path)
    image = read_image(path)
    assert image.grey.tolist() == [[10, 20, 30]]
    assert image.is_clear.tolist() == [[False, True, True]]


def refusal(path):
    with pytest.raises(MapError) as error:
        read_image(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_what_is_no_image_file(tmp_path):
    assert NO_FILE in refusal(tmp_path / "missing.pgm")
    assert "is a folder" in refusal(tmp_path)
    text = tmp_path / "text.pgm"
    text.write_text("free as the wind\n")
    assert "is no image; allowed: PPM, PNG" in refusal(text)
    text.write_text("")
    assert "is no image" in refusal(text)
    fractions = tmp_path / "fractions.pfm"
    fractions.write_bytes(b"Pf\n1 1\n-1.0\n" + np.float32(0.5).tobytes())
    assert "holds fractions" in refusal(fractions)


@needs_pipe
def test_a_pipe_is_no_image_file(tmp_path):
    os.mkfifo(tmp_path / "pipe.pgm")
    assert "is no regular file" in refusal(tmp_path / "pipe.pgm")


@needs_permissions
def test_a_file_that_is_not_permitted(tmp_path):
    path = tmp_path / "map.pgm"
    path.write_bytes(b"P5 1 1 255\n0")
    path.chmod(0)
    assert NOT_PERMITTED in refusal(path)


@pytest.mark.parametrize("size", [(4001, 4000), (10_000, 10_000), (200_000, 200_000)])
def test_a_huge_image_is_refused_before_it_is_read(tmp_path, size):
    """The file is but a header: to read on would call it cut short."""
    path = tmp_path / "map.pgm"
    path.write_text("P5 {} {} 255\n".format(*size))
    assert "allowed: up to 16000000" in refusal(path)


@pytest.mark.parametrize("ending", ["pgm", "png", "bmp", "jpg"])
def test_a_file_cut_short_or_damaged_reads_or_is_refused(tmp_path, ending):
    path = tmp_path / f"map.{ending}"
    Image.fromarray(GREY).save(path)
    whole, random = path.read_bytes(), np.random.default_rng(0)
    for length in range(0, len(whole) - 8, 7):
        path.write_bytes(whole[:length])
        reads_or_refuses(path)
    for _ in range(150):
        content = bytearray(whole)
        for place in random.integers(0, len(whole), random.integers(1, 6)):
            content[place] = random.integers(0, 256)
        path.write_bytes(content)
        reads_or_refuses(path)


def reads_or_refuses(path):
    try:
        image = read_image(path)
    except MapError as error:
        assert "\n" not in str(error)  # noqa: PT017
    else:
        assert image.grey.dtype == np.uint8
        assert image.grey.shape == image.is_clear.shape
