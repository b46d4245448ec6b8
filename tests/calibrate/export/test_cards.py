"""Cards that no engine runs here: their syntax, their tables, and the conventions back
and forth by formula."""

import ast
import json
import re
from dataclasses import replace

import pytest

from benchtwin.calibrate.export import ENGINES, cards, read_result
from benchtwin.calibrate.export.conventions import (
    GIVEN,
    damping_factor,
    effective_moduli,
    rolling_friction,
)
from benchtwin.sim.laws.hertz_mindlin import damping_factor as engine_damping_factor
from benchtwin.sim.material import Contact, Material
from benchtwin.sim.material import effective_moduli as engine_moduli


@pytest.fixture
def calibrated(folder):
    return read_result(folder)


def code(text, mark):
    return [
        line for line in text.splitlines() if line.strip() and not line.startswith(mark)
    ]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_card_says_version_source_units_and_every_calibrated_value(
    calibrated, engine
):
    text = next(iter(cards(calibrated, engine).values()))
    for said in (
        "written for",
        "result.json (sha256 ",
        "Units: SI",
        "rolling friction 0.04 [0.0408 (0.0360 to 0.0440); calibrated]",
        "R_i",
    ):
        assert said in text
    assert all(
        len(line) < 130 for line in text.splitlines() if line.startswith(("#", "//"))
    )


@pytest.mark.parametrize("engine", ENGINES)
def test_a_number_that_is_not_resolved_is_said_to_be(folder, result, engine):
    """In a comment, with its interval; the card's own number is the set's."""
    row = result["parameters"]["seed_static_friction"]
    row |= {"value": 0.53, "low": 0.45, "high": 0.9, "most_probable_set": 0.6}
    row |= {"status": "not resolved", "remark": "nearly all of the range fits"}
    (folder / "result.json").write_text(json.dumps(result))
    text = next(iter(cards(read_result(folder), engine).values()))
    said = " ".join(re.sub(r"\n\S+ +", " ", text).split())
    assert (
        "static friction 0.6 [0.53 (0.45 to 0.90); not resolved: nearly all of the"
        " range fits]" in said
    )


@pytest.mark.parametrize("on_wall", [False, True])
@pytest.mark.parametrize("given", GIVEN)
def test_rolling_friction_converts_as_our_materials_do(given, on_wall):
    """To R* as `Contact.rolling_friction_in`, and back again."""
    contact = Contact(("a", "b"), 0.5, 0.5, 0.04, given)
    there = rolling_friction(0.04, given, "effective", on_wall=on_wall)
    assert there == contact.rolling_friction_in("type_a", on_wall=on_wall)
    back = rolling_friction(there, "type_a", GIVEN[given], on_wall=on_wall)
    assert back == pytest.approx(0.04)


def test_moduli_and_damping_are_the_engine_s(calibrated):
    seed, wall = (
        Material(s.name, s.density_kg_m3, s.shear_modulus_pa, s.poisson_ratio)
        for s in (calibrated.seed, calibrated.wall)
    )
    assert effective_moduli(calibrated.seed, calibrated.wall) == pytest.approx(
        engine_moduli(seed, wall)
    )
    assert [damping_factor(e) for e in (0.1, 0.54, 1.0)] == pytest.approx(
        [engine_damping_factor(e) for e in (0.1, 0.54, 1.0)]
    )


@pytest.mark.parametrize(
    ("given", "factor"), [("edem", 2.0), ("type_a", 1.0), ("type_c", 1.0)]
)
def test_liggghts_tables(calibrated, given, factor):
    text = cards(replace(calibrated, rolling=given), "liggghts")[
        "seed.contact.liggghts"
    ]
    found = dict(
        re.findall(
            r"^fix \S+ all property/global (\S+) peratomtype(?:pair 2)? (.+)$",
            text,
            re.M,
        )
    )
    tables = {name: [float(v) for v in row.split()] for name, row in found.items()}
    assert tables["youngsModulus"] == pytest.approx([2 * 1e7 * 1.4, 2 * 8.2e10 * 1.28])
    assert tables["poissonsRatio"] == [0.4, 0.28]
    assert tables["coefficientRestitution"] == [0.65, 0.54, 0.54, 0.54]
    assert tables["coefficientFriction"] == [0.55, 0.34, 0.34, 0.34]
    assert tables["coefficientRollingFriction"] == pytest.approx(
        [0.04 * factor, 0.01, 0.01, 0.01]
    )
    model = "epsd2" if given == "type_c" else "cdt"
    assert (
        f"\npair_style gran model hertz tangential history rolling_friction {model}\n"
        in text
    )
    rows = cards(calibrated, "liggghts")["seed.multisphere"].splitlines()
    assert f"nspheres {len(rows)} " in text and all(
        len([float(v) for v in row.split()]) == 4 for row in rows
    )


def test_liggghts_is_told_of_moduli_that_it_refuses(calibrated):
    text = cards(calibrated, "liggghts")["seed.contact.liggghts"]
    assert "hard_particles" in text and "soft_particles" not in text
    soft = replace(calibrated, seed=replace(calibrated.seed, shear_modulus_pa=1e6))
    assert "soft_particles" in cards(soft, "liggghts")["seed.contact.liggghts"]


@pytest.mark.parametrize(
    ("given", "eta"), [("edem", 0.04), ("type_a", 0.02), ("type_c", 0.02)]
)
def test_yade_s_script_is_python_and_holds_the_numbers(calibrated, given, eta):
    tree = ast.parse(
        cards(replace(calibrated, rolling=given), "yade")["seed_contact.py"]
    )
    calls = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    ]
    keywords = {call.func.id: {k.arg: k.value for k in call.keywords} for call in calls}
    law = keywords["Ip2_FrictMat_FrictMat_MindlinPhys"]
    assert set(law) == {"en", "es", "frictAngle", "eta", "krot", "ktwist"}
    assert law["eta"].value == pytest.approx(eta)
    matches = {
        k: [triple.elts[2].value for triple in law[k].keywords[0].value.elts]
        for k in ("en", "es", "frictAngle")
    }
    assert matches["en"] == matches["es"] == [0.65, 0.54]
    assert [pytest.approx(v, rel=1e-6) for v in matches["frictAngle"]] == [
        0.50284321,
        0.32773851,
    ]
    assert keywords["Law2_ScGeom_MindlinPhys_Mindlin"]["includeMoment"].value is True
    assert keywords["NewtonIntegrator"]["damping"].value == 0.0
    caps = [
        n
        for n in ast.walk(tree)
        if isinstance(n, ast.Assign) and ast.unparse(n.targets[0]) == "i.phys.maxBendPl"
    ]
    assert ast.unparse(caps[0].value) == "0.01 * ball.shape.radius"
    balls = next(
        n.value
        for n in tree.body
        if isinstance(n, ast.Assign) and ast.unparse(n.targets[0]) == "BALLS"
    )
    assert len(ast.literal_eval(balls)) == 3


@pytest.mark.parametrize(
    ("given", "model"),
    [
        ("edem", "Standard Rolling"),
        ("type_a", "RVD Rolling"),
        ("type_c", "Type C Rolling"),
    ],
)
def test_edem_s_card_takes_the_numbers_as_they_are(calibrated, given, model):
    text = cards(replace(calibrated, rolling=given), "edem")["seed.edem.txt"]
    rows = [line.split(" | ") for line in code(text, "#") if not line.startswith("[")]
    assert all(len(row) == 3 for row in rows)
    rolling = [
        float(row[1]) for row in rows if row[0] == "Coefficient of Rolling Friction"
    ]
    assert rolling == [0.04, 0.01]
    assert [row[1] for row in rows if row[0] == "Shear Modulus"] == [
        "10000000",
        "8.2e+10",
    ]
    assert (
        f"Particle to Particle | Hertz-Mindlin (no slip) + {model} Friction | -" in text
    )
    table = [
        line.split("\t")
        for line in cards(calibrated, "edem")["seed.spheres.tsv"].splitlines()
    ]
    assert [len(row) for row in table] == [4] * 4 and [
        float(v) for v in table[1]
    ] == pytest.approx([3e-3, 0, 0, 0])


def test_mercury_s_header(calibrated):
    text = cards(calibrated, "mercury")["SeedContact.h"]
    assert text.count("{") == text.count("}") and text.count("(") == text.count(")")
    calls = dict(re.findall(r"between->(\w+)\((.*)\);", text))
    modulus, shear = effective_moduli(calibrated.seed, calibrated.wall)
    entered = [
        float(v)
        for v in calls["setEffectiveElasticModulusAndRestitutionCoefficient"].split(",")
    ]
    assert entered == pytest.approx([modulus, 0.54])
    assert float(calls["setEffectiveShearModulus"]) == pytest.approx(shear)
    assert [
        float(v) for v in re.findall(r"setRollingFrictionCoefficient\((.*)\)", text)
    ] == pytest.approx([0.08, 0.01])


def test_the_note_on_lengths_follows_what_was_converted(calibrated):
    for engine in ("lammps", "liggghts", "mercury"):
        own, effective = (
            next(iter(cards(replace(calibrated, rolling=r), engine).values()))
            for r in ("edem", "type_a")
        )
        assert "up to 1.43 times less" in own.replace("\n#   ", " ").replace(
            "\n//   ", " "
        )
        assert "nothing was converted" in effective.replace("\n#   ", " ").replace(
            "\n//   ", " "
        )


def test_a_name_cannot_continue_a_comment_into_the_card(calibrated):
    odd = replace(calibrated, wall=replace(calibrated.wall, name="steel & \\"))
    for engine in ("lammps", "liggghts", "mercury"):
        text = next(iter(cards(odd, engine).values()))
        assert not any(line.endswith(("&", "\\")) for line in text.splitlines())


def test_an_unknown_engine_is_told_which_there_are(calibrated):
    with pytest.raises(
        ValueError, match="there are lammps, liggghts, yade, edem, mercury"
    ):
        cards(calibrated, "pfc")
