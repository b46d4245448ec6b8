"""What result.json must hold, and what is said when it does not; the command."""

import json

import pytest
from typer.testing import CliRunner

from benchtwin.calibrate.export.result import calibrated_from, read_result
from benchtwin.command_line import app

LEAVES = [
    "parameters.restitution.value",
    "parameters.restitution.most_probable_set",
    "parameters.static_friction.status",
    "parameters.seed_rolling_friction.low",
    "parameters.static_friction.unit",
    "conventions.rolling",
    "materials.seed.density_kg_m3",
    "materials.wall.shear_modulus_pa",
    "materials.wall.name",
    "seed_shape.spheres",
]


def put(content, path, value=None, *, drop=False):
    *way, last = path.split(".")
    for key in way:
        content = content[key]
    if drop:
        del content[last]
    else:
        content[last] = value


@pytest.mark.parametrize("path", LEAVES)
def test_a_missing_key_is_named_with_its_file_and_what_it_should_hold(result, path):
    put(result, path, drop=True)
    with pytest.raises(
        ValueError, match=rf"^some/result\.json: {path} is missing: it should hold .+"
    ):
        calibrated_from(result, "some/result.json")


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (
            "parameters.restitution.most_probable_set",
            1.2,
            "restitution.most_probable_set = 1.2: must be a number above 0, up to 1",
        ),
        ("parameters.restitution.value", float("nan"), "restitution.value = nan"),
        ("parameters.restitution.value", "0.5", "restitution.value = '0.5'"),
        ("parameters.restitution.value", None, "restitution.value = None"),
        (
            "parameters.restitution.low",
            0.6,
            "the interval 0.6 to 0.594 does not hold the value",
        ),
        ("parameters.restitution.unit", "%", "unit = '%': must be \"1\""),
        ("parameters.restitution", 0.5, "restitution.unit is missing"),
        (
            "conventions.rolling",
            "viscous",
            "rolling = 'viscous': must be one of edem, type_a, type_c",
        ),
        ("materials.seed.poisson_ratio", 0.7, "poisson_ratio = 0.7"),
        ("materials.seed.name", "a\nb", "one line of text"),
        ("seed_shape.spheres", [], "a list of"),
        ("seed_shape.spheres", [[0, 0, 0]], "a list of"),
        ("seed_shape.spheres", [[0, 0, 0, 3], [9, 0, 0, 3]], "ball 1 touches none"),
    ],
)
def test_a_wrong_value_is_named(result, path, value, said):
    put(result, path, value)
    with pytest.raises(ValueError, match=r"^some/result\.json") as error:
        calibrated_from(result, "some/result.json")
    assert said in str(error.value)


def test_millimetres_become_metres_and_the_union_is_weighed(folder):
    shape = read_result(folder).shape
    assert shape.balls_m[0] == pytest.approx((0, 0, 0, 3e-3))
    ball = 1250 * 4 / 3 * 3.14159265 * 3e-3**3
    assert ball < shape.mass_kg < 3 * ball


def export(*arguments):
    return CliRunner().invoke(app, ["export", *map(str, arguments)])


def test_the_command_writes_replaces_only_when_told_and_names_what_is_wrong(folder):
    assert export(folder, "--to", "yade").exit_code == 0
    card = folder / "export" / "yade" / "seed_contact.py"
    card.write_text("mine")
    refused = export(folder, "--to", "yade")
    assert (
        refused.exit_code == 2
        and "exists already" in refused.output
        and card.read_text() == "mine"
    )
    assert (
        export(folder, "--to", "yade", "--overwrite").exit_code == 0
        and card.read_text() != "mine"
    )
    assert export(folder, "--to", "pfc").exit_code == 2
    assert "result.json: not there" in export(folder / "export", "--to", "yade").output
    (folder / "result.json").write_text("{")
    assert "not readable as JSON" in export(folder, "--to", "edem").output
    (folder / "result.json").write_text(json.dumps([]))
    assert "materials.seed.name is missing" in export(folder, "--to", "edem").output


def test_a_folder_that_cannot_be_written_is_named(folder):
    (folder / "file").write_text("")
    failed = export(folder, "--to", "edem", "--out", folder / "file" / "cards")
    assert failed.exit_code == 1 and "cannot write to" in failed.output
