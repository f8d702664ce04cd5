"""The file of factors by contact parameters is read as it was written; a wrong one is refused in one line."""

import json

import numpy as np
import pytest

from millprint.errors import ConfigError
from millprint.fingerprint.curves import CURVES
from millprint.uncertainty.contact_file import FORMAT, ContactUncertainty


def sample() -> ContactUncertainty:
    return ContactUncertainty(
        mill="emax",
        contact="calibrated",
        probability=0.95,
        samples=16,
        parameters={"restitution": {"kind": "uniform", "low": 0.1, "high": 0.9, "source": "a test"}},
        fill_ratios=np.array([0.05, 0.2]),
        lower={name: np.array([0.5, 0.8]) for name in CURVES},
        upper={name: np.array([1.2, 1.8]) for name in CURVES},
    )


def test_what_is_read_is_what_was_written(tmp_path):
    sample().write(tmp_path / "contact.json")
    found = ContactUncertainty.read(tmp_path / "contact.json")
    assert json.loads((tmp_path / "contact.json").read_text())["format"] == FORMAT
    assert (found.mill, found.contact, found.probability, found.samples) == ("emax", "calibrated", 0.95, 16)
    assert found.parameters == sample().parameters
    for name in CURVES:
        np.testing.assert_array_equal(found.lower[name], [0.5, 0.8])
        np.testing.assert_array_equal(found.upper[name], [1.2, 1.8])


def test_factors_are_interpolated_in_logarithms_and_held_beyond_the_ends():
    found = sample()
    low, high = found.at(0.1)["Pn"]
    assert low == pytest.approx(np.sqrt(0.5 * 0.8)) and high == pytest.approx(np.sqrt(1.2 * 1.8))
    assert found.at(np.array([0.01, 0.5]))["f"][0] == pytest.approx([0.5, 0.8])
    assert found.covers(0.05) and found.covers(0.2) and not found.covers(0.21)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"format": "millprint fingerprint 1"}, "format"),
        ({"fill_ratios": [0.2, 0.05]}, "must rise"),
        ({"fill_ratios": [0.05, 0.1, 0.2]}, "factors.Pn"),
        ({"factors": {}}, "KeyError"),
        ({"factors": {name: {"lower": [2.0, 2.0], "upper": [1.0, 1.0]} for name in CURVES}}, "factors.Pn"),
    ],
)
def test_a_file_with_other_content_is_refused_in_one_line(tmp_path, change, words):
    path = tmp_path / "contact.json"
    sample().write(path)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(ConfigError, match=words) as error:
        ContactUncertainty.read(path)
    assert "\n" not in str(error.value) and str(path) in str(error.value)


def test_a_missing_file_names_the_command_that_writes_it(tmp_path):
    with pytest.raises(ConfigError, match="uncertainty --config mill"):
        ContactUncertainty.read(tmp_path / "contact.json")
