"""Commands are the functions of the Python interface: their options and help come from
the signatures and docstrings."""

import inspect

import pytest
from typer.testing import CliRunner

from benchtwin import calibrate, export, measure
from benchtwin.command_line import COMMANDS, app


def words_of(text: str) -> str:
    return " ".join(text.split())


@pytest.mark.parametrize(
    ("name", "function", "options"),
    [
        (
            "measure",
            measure,
            (
                "Photos, folders of photos, recordings, bench folders",
                "overlays/, tracks/, bounces.csv. [required]",
                "between which the line is fitted. [default: 20-80]",
                "Print nothing but errors. [default: no-quiet]",
            ),
        ),
        (
            "calibrate",
            calibrate,
            (
                "Bench folder: recordings of drop",
                "the simulated runs. [required]",
                "--range NAME=A:B",
                "[default: 1; x>=0]",
            ),
        ),
        ("export", export, ("What `benchtwin calibrate", "lammps, liggghts, yade")),
    ],
)
def test_help_is_the_function_s(name, function, options):
    shown = words_of(CliRunner().invoke(app, [name, "--help"]).output)
    told = words_of(inspect.getdoc(function).partition("\f")[0])
    assert told in shown
    assert [option for option in options if option not in shown] == []
    assert "Raises" not in shown  # what only Python asks for


def test_every_command_is_one_function():
    of_python = {"measure", "calibrate", "predict", "diagnose", "export"}
    assert of_python <= set(COMMANDS) and len(COMMANDS) == 18
    assert COMMANDS["calibrate"].__wrapped__ is calibrate


def test_a_fault_of_ours_is_not_taken_for_misuse(tmp_path, monkeypatch):
    """Where a command says by itself what is wrong, another error is none of the
    user's."""
    from benchtwin.measure import measured

    def broken(*_, **__):
        raise ValueError("no such row")

    monkeypatch.setattr(measured, "find_all", broken)
    ended = CliRunner().invoke(app, ["measure", str(tmp_path), "--out", "out"])
    assert isinstance(ended.exception, ValueError)
