"""What a job of the twin does in a worker."""

import threading
from dataclasses import replace

import pytest

from benchtwin.twin import Parameters
from benchtwin.twin.campaign import Measured
from benchtwin.twin.campaign.attempt import (
    kernels_of,
    one_compiles,
    simulate_and_measure,
    thin,
)
from benchtwin.twin.job import Job

ROLL = Job("roll", Parameters(), {"roll": {"direction": "+x"}}, rendered=False)


def test_a_roll_is_run_and_measured(tmp_path):
    measured = simulate_and_measure(ROLL, tmp_path / "roll", 1)
    found = {m.name: m for m in measured.measurements}
    assert found["run_out"].unit == "mm" and found["run_out"].value == pytest.approx(
        measured.truth["run_out_mm"], abs=2.0
    )
    thin(tmp_path / "roll", measured)
    assert (tmp_path / "roll" / "track.csv").is_file()


def test_the_measured_track_takes_the_place_of_the_frames(tmp_path):
    measured = simulate_and_measure(ROLL, tmp_path / "roll", 1)
    (tmp_path / "roll" / "track.csv").unlink()
    (tmp_path / "roll" / "frames").mkdir()
    thin(tmp_path / "roll", measured)
    assert not (tmp_path / "roll" / "frames").exists()
    assert (tmp_path / "roll" / "track.csv").read_text().count("\n") > 100


def test_an_unmeasurable_run_is_told_from_a_failed_one(tmp_path, monkeypatch):
    from benchtwin.twin.job import MeasurementError

    def fail(recording):
        raise MeasurementError("nothing to see")

    monkeypatch.setattr("benchtwin.twin.observe", fail)
    measured = simulate_and_measure(ROLL, tmp_path / "roll", 1)
    assert (
        measured.reason.endswith("nothing to see")
        and measured.truth
        and not measured.measurements
    )


def test_laws_and_rigs_decide_the_kernels():
    kinds = {
        kernels_of(job)
        for job in (
            ROLL,
            Job("slide", Parameters()),
            Job("roll", Parameters(laws={"magnus": {}}), ROLL.description),
            Job(
                "roll",
                Parameters(),
                {"air": {"density_kg_m3": 0.0}, **ROLL.description},
            ),
            Job("pile", Parameters()),
            Job("pile", Parameters(), {"pile": {"cylinder_mm": [70.0, 150.0]}}),
        )
    }
    assert len(kinds) == 6
    assert kernels_of(
        replace(ROLL, parameters=Parameters(restitution=0.3), rng=(7,))
    ) == kernels_of(ROLL)


@pytest.mark.parametrize("crash", [False, True])
def test_one_compiles_and_the_others_wait_until_it_has(tmp_path, monkeypatch, crash):
    """Also when the first crashes before it has compiled."""
    monkeypatch.setattr("benchtwin.sim.engine.compiled.cache_folder", lambda: tmp_path)
    monkeypatch.setattr("benchtwin.twin.campaign.attempt._compiled", set())
    inside, let_go, order = threading.Event(), threading.Event(), []

    def first() -> None:
        try:
            with one_compiles("a") as warming:
                inside.set()
                let_go.wait(10)
                order.append("first compiled")
                if crash:
                    raise ValueError
                warming.over()
        except ValueError:
            pass

    def second() -> None:
        inside.wait(10)
        with one_compiles("a") as warming:
            order.append("second may")
            warming.over()

    threads = [threading.Thread(target=first), threading.Thread(target=second)]
    for thread in threads:
        thread.start()
    inside.wait(10)
    with one_compiles("b") as warming:  # other kernels need not wait
        warming.over()
    threads[1].join(0.3)
    assert order == []
    let_go.set()
    for thread in threads:
        thread.join(10)
    assert order == ["first compiled", "second may"]


def test_compiled_kernels_need_no_lock(tmp_path, monkeypatch):
    nowhere = tmp_path / "nowhere"
    monkeypatch.setattr("benchtwin.sim.engine.compiled.cache_folder", lambda: nowhere)
    monkeypatch.setattr("benchtwin.twin.campaign.attempt._compiled", {"a"})
    with one_compiles("a") as warming:
        warming.over()
    assert not nowhere.exists()
    with one_compiles("b"):  # the control: others make their lock there
        assert list(nowhere.iterdir())


def test_thinning_leaves_a_folder_without_pictures_alone(tmp_path):
    (tmp_path / "track.csv").write_text("t_s\n")
    thin(tmp_path, Measured())
    assert [p.name for p in tmp_path.iterdir()] == ["track.csv"]
