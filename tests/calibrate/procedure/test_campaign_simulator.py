"""The procedure's simulator over a real campaign store: runs come back measured, and
are not computed again."""

import numpy as np
import pytest

from benchtwin.calibrate.procedure.simulator import Run, campaign, seed_numbers


@pytest.mark.usefixtures("rigs_compiled")
def test_runs_come_back_in_order_and_from_the_store_without_workers(
    tmp_path, monkeypatch
):
    runs = [
        Run(
            "drop",
            {"restitution": e},
            seed_numbers(1, "drop", e),
            {"drop": {"height_mm": 100.0}, "seed": {}},
        )
        for e in (0.7, 0.4)
    ]
    with campaign(tmp_path / "runs", workers=1) as simulate:
        table = simulate(runs)
    assert table["status"].tolist() == ["done", "done"]
    np.testing.assert_allclose(table["rebound_height_mm"], [49.0, 16.0], rtol=0.25)
    monkeypatch.setattr(
        "benchtwin.twin.campaign.processes.Processes.submit", None
    )  # nothing may be started
    with campaign(tmp_path / "runs", workers=1) as simulate:
        assert (
            simulate(runs)["rebound_height_mm"].tolist()
            == table["rebound_height_mm"].tolist()
        )
