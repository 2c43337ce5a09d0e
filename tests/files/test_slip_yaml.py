from dataclasses import replace

import numpy as np
import pytest

from trackctl.errors import InputFileError
from trackctl.files.slip_yaml import NAMES, SlipFile, read_slip, slip_to_yaml
from trackctl.identification.identifier import LearnedSlip
from trackctl.identification.slip_model import SlipModel


def example(seed=0):
    random = np.random.default_rng(seed)
    root = random.standard_normal((11, 11)) * 10.0 ** random.integers(-9, 1, 11)[:, None]
    learned = LearnedSlip(random.standard_normal(11) * 1e-7, root @ root.T, 0.1, 1e-17)
    return SlipFile(
        "a: vehicle", 0.61, 0.1, SlipModel.PAPER, learned, "log #1.csv", 7, "2026-01-01", 'trackctl "identify"'
    )


@pytest.mark.parametrize("seed", range(5))
def test_a_slip_model_comes_back_bit_for_bit(tmp_path, seed):
    path, slip = tmp_path / "slip.yaml", example(seed)
    path.write_text(slip_to_yaml(slip))
    found = read_slip(str(path))
    assert np.array_equal(found.learned.p, slip.learned.p)
    assert np.array_equal(found.learned.covariance, slip.learned.covariance)
    assert found.learned.heading_error == slip.learned.heading_error
    for name in ("vehicle", "track_gauge", "sprocket_radius", "model", "log", "updates", "created", "history"):
        assert getattr(found, name) == getattr(slip, name)


def changed(key, value):
    """The example's text with another value."""
    lines = slip_to_yaml(example()).splitlines()
    return "\n".join(f"{key}: {value}" if line.startswith(f"{key}:") else line for line in lines)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("- 1\n", "is no list of"),
        ("name: x\n", "is no slip model"),
        ("mass_kg: [\n", "is not valid YAML"),
        ("a: b\0", "YAML"),
        (changed("filetype", "trackctl-lut"), "filetype: 'trackctl-lut' is not allowed; allowed: trackctl-slip"),
        (changed("version", "2"), "version: 2 is not allowed; allowed: 1"),
        (changed("model", "best"), "model: 'best' is not allowed; allowed: parametric, "),
        (changed("p3", ".nan"), "p3: .nan is no finite decimal number"),
        (changed("p3", "1e9"), "p3: "),
        (changed("p3", "[1, 2]"), "p3: a list is no number"),
        (changed("track_gauge_m", "-1"), "track_gauge_m: -1 is not allowed; allowed: from 0.02 to 20"),
        (changed("position_error", "-0.5"), "position_error: -0.5 is not allowed"),
        (slip_to_yaml(example()).partition("  - [")[0] + "  1\n", "covariance: is no matrix"),
        (changed("updates", "many"), "updates: 'many' is no number"),
        (changed("created", "[1]"), "created: "),
        (slip_to_yaml(example()).replace("p5:", "p12:"), "missing keys: p5"),
        (slip_to_yaml(example()) + "colour: red\n", "colour: unknown key"),
        (slip_to_yaml(example()).rpartition("  - [")[0], "covariance: is no matrix"),
    ],
)
def test_what_is_no_slip_model_is_refused(tmp_path, text, words):
    path = tmp_path / "slip.yaml"
    path.write_text(text)
    with pytest.raises(InputFileError) as error:
        read_slip(str(path))
    assert str(path) in str(error.value)
    assert words in str(error.value)


@pytest.mark.parametrize("entry", [(0, 1, 1.0, "symmetric"), (3, 3, -1.0, "not positive"), (0, 0, 1e9, "too large")])
def test_a_matrix_that_is_no_covariance_is_refused(tmp_path, entry):
    row, column, value, word = entry
    slip, path = example(), tmp_path / "slip.yaml"
    matrix = np.eye(11)
    matrix[row, column] = value
    path.write_text(slip_to_yaml(replace(slip, learned=replace(slip.learned, covariance=matrix))))
    with pytest.raises(InputFileError, match=word):
        read_slip(str(path))


def test_names_are_those_of_the_columns():
    assert tuple(f"p{i}" for i in range(1, 12)) == NAMES
