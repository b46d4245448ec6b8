"""Tables in the place of simulations (`calibrate --tables`), wrong on purpose: file,
row and what belongs there are told."""

import shutil
from pathlib import Path

import pytest
from fuzz import attack, spoilt
from fuzz_files import Reader, calibrate_tables_beside, readers
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchtwin.calibrate.procedure.rigs import STEEL
from benchtwin.calibrate.procedure.tables import (
    design_table,
    levels_box,
    path_table,
    steel_table,
)

TABLES = Path(__file__).parents[2] / "samples" / "soybean-paper" / "tables"
READ = {
    **{
        f"{name}.csv": lambda file, rig=rig: steel_table(file, rig)
        for name, rig in STEEL.items()
    },
    "levels.csv": levels_box,
    "design.csv": lambda file: design_table(file, levels_box(TABLES / "levels.csv")),
    "path.csv": path_table,
}
WRONG = [  # file, what stands there, what somebody wrote, what is said
    (
        "drop.csv",
        "0.49,82",
        "0.49,eighty",
        "rebound_height_mm = 'eighty' in row 3 is not a number",
    ),
    (
        "drop.csv",
        "0.49,82",
        "0.49,",
        "rebound_height_mm is empty or not finite in row 3",
    ),
    (
        "drop.csv",
        "0.49,82",
        "49,82",
        "restitution = 49 in row 3; it should lie between 0 and 1",
    ),
    ("drop.csv", "0.49,82,5", "0.49,82,-5", "sd_mm = -5 in row 3"),
    (
        "drop.csv",
        "0.49,82,5",
        "0.49,82,five",
        "sd_mm = 'five' in row 3 is not a number",
    ),
    (
        "drop.csv",
        "0.49,82",
        "0.49," + "9" * 400,
        "rebound_height_mm = 9+\\.\\.\\.9+ in row 3",
    ),
    ("drop.csv", "0.49,82,5", "0.49,82,5,1", "not a CSV table .*line 3"),
    ("drop.csv", "sd_mm", "rebound_height_mm", "column rebound_height_mm comes twice"),
    (
        "drop.csv",
        "rebound_height_mm",
        "rebound_height",
        "column rebound_height_mm is missing; expected restitution",
    ),
    (
        "drop.csv",
        "restitution,rebound_height_mm,sd_mm\n0.45,70,3",
        "restitution;rebound_height_mm;sd_mm\n0.45;70;3\n0,47;75;3",
        (
            "its columns are separated by .;., its numbers written in two ways; save it"
            " with commas"
        ),
    ),
    (
        "slide.csv",
        "0.25,15",
        "0.25,95",
        "slide_angle_deg = 95 in row 2; it should lie between 0 and 90",
    ),
    (
        "levels.csv",
        "0,0.6,",
        "0,0.56,",
        "seed_restitution at 0 should be midway, 0.6; here is 0.56",
    ),
    (
        "levels.csv",
        "0,0.6,",
        "1,0.6,",
        "column coded should hold −1, 0 and 1, a row each; here are -1, 1, 1",
    ),
    ("levels.csv", "-1,0.55", "-1,0.75", "seed_restitution: low must be below high"),
    (
        "design.csv",
        "-1,1,0",
        "-10,1,0",
        "A = -10 in row 4; it should lie between -2 and 2",
    ),
    (
        "design.csv",
        "A,B,C",
        "a,b,c",
        "column A, B, C is missing; expected A, B, C, repose_angle_deg, found a, b, c",
    ),
    (
        "path.csv",
        "4,0.6,",
        "4.5,0.6,",
        "group = 4.5 in row 5; it should be a whole number",
    ),
]


@pytest.mark.parametrize(("name", "right", "wrong", "said"), WRONG)
def test_a_mistake_is_told_with_its_file_and_row(tmp_path, name, right, wrong, said):
    content, file = (TABLES / name).read_text(), tmp_path / name
    assert right in content
    file.write_text(
        content.replace(right, wrong)
        if len(right) == 1
        else content.replace(right, wrong, 1)
    )
    with pytest.raises(ValueError, match=f"{name}: {said}"):
        READ[name](file)


@pytest.mark.parametrize("name", READ)
@given(data=st.data())
@settings(max_examples=30, deadline=None, suppress_health_check=list(HealthCheck))
def test_a_spoilt_table_is_read_or_refused_in_our_words(tmp_path_factory, name, data):
    file = tmp_path_factory.mktemp("spoilt") / name
    file.write_bytes(
        data.draw(spoilt(Reader((TABLES / name).read_bytes(), ",", READ[name])))
    )
    try:
        READ[name](file)
    except ValueError as error:
        assert str(error).startswith(f"{file}: ")


@pytest.mark.parametrize(
    "name", ["design.csv", "drop.csv", "levels.csv", "path.csv", "published.toml"]
)
def test_calibrating_on_spoilt_tables_ends_in_an_answer_or_a_reason(name):
    tried, _ = attack(f"tables/{name}", readers()[f"tables/{name}"], examples=2, rng=1)
    assert tried >= 2


def test_columns_count_by_their_names_not_by_their_places(tmp_path):
    """Reversed, with one more before them: the same design."""
    shutil.copytree(TABLES, tmp_path / "tables")
    rows = [
        line.split(",") for line in (TABLES / "design.csv").read_text().splitlines()
    ]
    turned = "\n".join(
        ",".join([f"{n}" if n else "run", *row[::-1]]) for n, row in enumerate(rows)
    )
    (tmp_path / "tables" / "design.csv").write_text(turned)
    box = levels_box(TABLES / "levels.csv")
    read, right = (
        design_table(folder / "design.csv", box)
        for folder in (tmp_path / "tables", TABLES)
    )
    assert (read[list(right)] == right).all(axis=None)
    assert not calibrate_tables_beside(tmp_path / "tables" / "design.csv")


def test_a_path_without_group_numbers_is_counted(tmp_path):
    """And what was printed of its groups is still compared."""
    shutil.copytree(TABLES, tmp_path / "tables")
    file = tmp_path / "tables" / "path.csv"
    file.write_text(
        "\n".join(line.partition(",")[2] for line in file.read_text().splitlines())
    )
    assert list(path_table(file)["group"]) == [1, 2, 3, 4, 5, 6]
    assert not calibrate_tables_beside(file)
