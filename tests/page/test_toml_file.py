"""TOML as people write it stays so: comments kept, values checked, two writers do not
lose each other's edits."""

import tomllib

import pytest

from benchtwin.page import toml_file
from benchtwin.page.folder import Refused

TEXT = """# my first drop
rig = "drop"   # a plate of steel

[seed]
length_mm = 8.7   # of ten seeds
mass_g = 0.23
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "recording.toml"
    path.write_text(TEXT)
    return path


def test_comments_and_order_are_kept(file):
    toml_file.change(
        toml_file.read(file),
        {
            ("seed", "length_mm"): 8.9,
            ("drop", "height_mm"): 310,
            ("seed", "mass_g"): None,
        },
    )
    assert (
        file.read_text()
        == TEXT.replace("8.7", "8.9").replace("mass_g = 0.23\n", "")
        + "\n[drop]\nheight_mm = 310\n"
    )


def test_by_hand_is_marked_and_a_table_left_empty_goes(file):
    keys = toml_file.change(
        toml_file.read(file), {("pile", "roi_px"): [1, 2, 30, 40]}, by_hand=True
    )
    assert "roi_px = [1, 2, 30, 40] # set by hand on the page" in file.read_text()
    toml_file.change(keys, {("pile", "roi_px"): None})
    assert tomllib.loads(file.read_text()) == tomllib.loads(TEXT)


def test_a_second_page_does_not_overwrite_the_first_one_s_change(file):
    first, second = toml_file.read(file), toml_file.read(file)
    toml_file.change(first, {("drop", "height_mm"): 310})
    with pytest.raises(Refused, match="changed meanwhile"):
        toml_file.change(second, {("drop", "height_mm"): 200})
    assert tomllib.loads(file.read_text())["drop"]["height_mm"] == 310


@pytest.mark.parametrize(
    "change",
    [
        {("seed", "length_mm"): -1},
        {("drop", "height"): 3},
        {("", "rig"): "fall"},
        {("seed", "mass_g"): "x"},
    ],
)
def test_what_is_not_valid_is_not_written(file, change):
    with pytest.raises(Refused):
        toml_file.change(toml_file.read(file), change)
    assert file.read_text() == TEXT


def test_a_file_that_is_not_there_is_made_and_a_broken_one_is_left(tmp_path):
    file = tmp_path / "bench.toml"
    toml_file.change(toml_file.read(file), {("seed", "length_mm"): 8.7})
    assert tomllib.loads(file.read_text()) == {"seed": {"length_mm": 8.7}}
    file.write_text("[seed\n")
    with pytest.raises(Refused, match="not valid TOML"):
        toml_file.read(file)


def test_wrong_keys_are_mended_one_by_one(tmp_path):
    file = tmp_path / "recording.toml"
    file.write_text('rig = "heap"\ncamera = 3\nblue = 1\n')
    keys = toml_file.read(file)
    with pytest.raises(Refused, match="fps"):  # no new fault beside the old ones
        toml_file.change(keys, {("camera", "fps"): "fast"})
    keys = toml_file.change(keys, {("", "rig"): "pile"})
    keys = toml_file.change(keys, {("camera", "fps"): 50.0})
    keys = toml_file.change(keys, {("", "blue"): None})
    assert keys.content == {"rig": "pile", "camera": {"fps": 50.0}}


@pytest.mark.parametrize(
    "content", [b"\xff\xfe", b"[" * 20_000, b"a = ", b"x" * 40_000, b"\0"]
)
def test_what_is_no_file_of_keys_is_said_and_replaced_as_text(tmp_path, content):
    file = tmp_path / "recording.toml"
    file.write_bytes(content)
    with pytest.raises(Refused, match=r"recording\.toml"):
        toml_file.read(file)
    assert toml_file.any_text(file)
    with pytest.raises(Refused, match="not valid TOML"):
        toml_file.write_text(file, "rig = ", toml_file.any_text(file))
    assert file.read_bytes() == content
    toml_file.write_text(file, 'rig = "pile"\n', toml_file.any_text(file))
    assert toml_file.read(file).content == {"rig": "pile"}


def test_a_text_that_another_tab_has_saved_is_not_overwritten(tmp_path):
    file = tmp_path / "recording.toml"
    file.write_text("[seed\n")
    seen = toml_file.any_text(file)
    toml_file.write_text(file, "[seed]\n", seen)
    with pytest.raises(Refused, match="was changed meanwhile, elsewhere"):
        toml_file.write_text(file, "[camera]\n", seen)
    assert file.read_text() == "[seed]\n"
