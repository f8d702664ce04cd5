"""Numbers, names and files as people write them: read as meant, or refused in one line that says what to write."""

import itertools

import pytest
import trimesh

from millprint.checks.before_running import mill_warnings
from millprint.cli.new_mill import completed, questions, read_template
from millprint.config.card import Experiment
from millprint.config.checks import check_given_once
from millprint.config.errors import ConfigError
from millprint.config.included import load_mill
from millprint.config.load import check_model, file_of_key, load_named, parse_yaml
from millprint.config.mill import MillConfig
from millprint.config.wording import SAME_KIND, converted, list_words
from tests.refusals import refusal, refusals

TEMPLATE = read_template("planetary")
MILL = completed("mine", "mine", TEMPLATE, {each.name: each.default for each in questions(TEMPLATE)})


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder with the file of a planetary mill."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config/mills").mkdir(parents=True)
    (tmp_path / "config/mills/mine.yaml").write_text(MILL)
    return tmp_path


def refused(folder, content: bytes) -> str:
    (folder / "config/mills/mine.yaml").write_bytes(content)
    line = refusal(load_named, "config/mills", "mine", MillConfig, "mill")
    assert line.startswith("config/mills/mine.yaml: ")
    return line


@pytest.mark.parametrize(("old", "new", "parts"), refusals("a_value_as_people_write_it"))
def test_a_value_as_people_write_it(folder, old, new, parts):
    assert old in MILL
    line = refused(folder, MILL.replace(old, new).encode())
    assert all(part in line for part in parts), line


@pytest.mark.parametrize(("content", "part"), refusals("a_card_as_people_write_it"))
def test_a_card_as_people_write_it(content, part):
    with pytest.raises(ConfigError) as caught:
        check_model(content, Experiment, "card.yaml")
    assert part in str(caught.value)


def test_arms_that_catch_balls_are_told():
    mill = load_mill("attritor")
    high = [
        insert.model_copy(update={"geometry": insert.geometry.model_copy(update={"bottom_mm": 12.0})})
        if getattr(insert.geometry, "bottom_mm", 99) < 12 else insert
        for insert in mill.inserts
    ]  # fmt: skip
    assert not mill_warnings({"attritor": mill})
    (line,) = mill_warnings({"attritor": mill.model_copy(update={"inserts": high})})
    assert "bottom_mm = 12" in line and line.endswith("write less than 7")


@pytest.mark.parametrize(
    ("content", "part"),
    [
        (MILL.replace("title: mine", "title: Mühle").encode("cp1252"), "line 3: is not in UTF-8"),
        (MILL.encode("utf-16"), "is in UTF-16; save it as UTF-8"),
        (b"\0" * 100, "is not a text file"),
        (b"", "it is empty"),
        (b"- a\n", "it is a list"),
        (b"<!DOCTYPE html>\n<html><body>404: not found</body></html>", "HTML"),
    ],
)
def test_a_file_that_is_another_one(folder, content, part):
    assert part in refused(folder, content)


def test_what_is_plain_is_read(folder):
    """A mark of byte order, ends of lines of Windows, a number in quotes, one with an exponent."""
    text = MILL.replace("height_mm: 58", "height_mm: '58'").replace("37.5 ", "3.75e1 ").replace("\n", "\r\n")
    (folder / "config/mills/mine.yaml").write_bytes(text.encode("utf-8-sig"))
    assert load_named("config/mills", "mine", MillConfig, "mill").geometry.radius_mm == 37.5


@pytest.mark.parametrize("name", ["mine.yml", "Mine.yaml"])
def test_a_file_of_a_similar_name_is_named(folder, name):
    (folder / "config/mills/mine.yaml").rename(folder / "config/mills" / name)
    with pytest.raises(ConfigError, match=f"{name}: the file of the mill 'mine' must be called mine.yaml"):
        load_named("config/mills", "mine", MillConfig, "mill")


def test_a_value_of_the_command_line_is_not_that_of_a_file(tmp_path):
    (tmp_path / "run.yaml").write_text("mill: emax\n")
    assert file_of_key([str(tmp_path / "run.yaml")], ("mill",), "Emax") == "--config"
    assert file_of_key([str(tmp_path / "run.yaml")], ("mill",), "emax").endswith("run.yaml")


def test_a_forgotten_sign_of_a_planetary_mill_is_told():
    mill = load_mill("planetary")
    turned = mill.model_copy(update={"motion": mill.motion.model_copy(update={"ratio": 1.82})})
    (line,) = mill_warnings({"planetary": mill, "mine": turned})
    assert "config/mills/mine.yaml: motion.ratio = 1.82" in line and line.endswith("write -1.82")


PLANETARY, TURNED = {"kind": "planetary", "sun_radius_mm": 70, "ratio": -2}, {"kind": "rotation", "axis": [0, 1, 0]}
ABOUT_Z = {"kind": "rotation", "axis": [0, 0, 1]}


@pytest.mark.parametrize(
    ("motion", "shift_mm", "parts"),
    [
        (PLANETARY, (20, 20, 0), ("28.3 mm", "20 mm radius", "move the drawing by [-20, -20, 0] mm")),
        (PLANETARY, (0.1, 0, 30), ()),
        (PLANETARY | {"ratio": -1}, (20, 20, 0), ()),
        (ABOUT_Z, (0, 583, 0), ("583 mm", "write pivot_mm: [0, 583, 0]")),
        (ABOUT_Z | {"pivot_mm": [0, 583, 4]}, (0, 583, 0), ()),
        (ABOUT_Z | {"pivot_mm": [10, 0, 0]}, (0, 0, 0), ("10 mm", "write pivot_mm: [0, 0, 0]")),
        (TURNED, (0, 0, 0), ("90 degrees", "write axis: [0, 0, 1]")),
        ({"kind": "circle", "amplitude_mm": 17}, (20, 20, 0), ()),
    ],
)
def test_a_vessel_that_turns_about_another_axis_than_its_own_is_told(motion, shift_mm, parts, tmp_path, monkeypatch):
    """A jar at -1 only moves on a circle, so that its place in the drawing is nothing."""
    monkeypatch.chdir(tmp_path)
    jar = trimesh.creation.cylinder(20, 38, sections=64)
    jar.apply_translation(shift_mm)
    jar.export("jar.stl")
    shape = {"kind": "stl", "path": "jar.stl", "unit": "mm"}
    mill = MillConfig(name="mine", title="mine", source="made", volume_ml=47.7, geometry=shape, motion=motion)
    found = mill_warnings({"mine": mill})
    assert len(found) == bool(parts)
    assert all(part in line for line in found for part in parts), found


def test_a_list_of_whole_numbers_is_no_list_of_decimal_commas():
    assert parse_yaml("sizes: [1,2,3]\nother: [1, 2]", "a") == {"sizes": [1, 2, 3], "other": [1, 2]}


@pytest.mark.parametrize(
    ("text", "meant"),
    [("10-20", "[10, 20]"), ("5 - 10", "[5, 10]"), ("0 0 -1", "[0, 0, -1]"), ("-1, 0.5", "[-1, 0.5]"), (7, "[7]")],
)
def test_a_list_without_brackets_keeps_its_signs(text, meant):
    assert list_words(text) == f"must be a list; write {meant}"


@pytest.mark.parametrize(("words", "parts"), refusals("an_option_that_replaces_another_is_named"))
def test_an_option_that_replaces_another_is_named(words, parts):
    with pytest.raises(ConfigError) as caught:
        check_given_once(words.split())
    assert all(part in str(caught.value) for part in parts)
    check_given_once(["fingerprint", "--configfile", "a.yaml", "b.yaml", "--config", "mill=mine", "name=me", "-n"])


def test_a_value_in_any_unit_of_the_same_kind_is_converted_back():
    for kind in SAME_KIND:
        for given, wanted in itertools.permutations(kind, 2):
            there = float(converted(3.25, given, wanted))
            assert float(converted(there, wanted, given)) == pytest.approx(3.25, rel=1e-8)
    assert converted(3.0, "mm", "rpm") == "" and converted(1.0, "in", "mm") == "25.4"
