"""A simulator without physics: closed forms with scatter, whose true parameters are
known. It counts what it was asked for."""

import numpy as np
import pandas as pd
import pytest
from command_code import command_code

from benchtwin.calibrate.procedure import pairs

TRUE = {
    "restitution": 0.54,
    "static_friction": 0.34,
    "rolling_friction": 0.0115,
    "seed_restitution": 0.60,
    "seed_static_friction": 0.48,
    "seed_rolling_friction": 0.042,
}
# of seed on seed, over which the closed forms rise
NEAR = {
    "seed_restitution": (0.45, 0.70),
    "seed_static_friction": (0.20, 0.70),
    "seed_rolling_friction": (0.01, 0.06),
}


def angle(values: dict) -> float:
    """Angle of repose (°), the paper's Eq. 8 made wider: rises with all three, bends in
    two."""
    a = (values["seed_restitution"] - 0.60) / 0.05
    b = (values["seed_static_friction"] - 0.50) / 0.10
    c = (values["seed_rolling_friction"] - 0.04) / 0.01
    return (
        30.04
        + 0.5875 * a
        + 0.8375 * b
        + 0.775 * c
        + 0.1 * b * c
        - 0.08 * b * b
        - 0.07 * c * c
    )


def response(run, packing_sd: float, own_sd: float) -> dict:
    """What one run measures; the same rng gives the same scatter."""
    v, rng = run.values, np.random.default_rng(list(run.rng))
    if run.rig == "drop":
        return {
            "rebound_height_mm": (
                310 * v["restitution"] ** 2 * 0.97 * (1 + 0.05 * rng.standard_normal())
            )
        }
    if run.rig == "slide":
        return {
            "slide_angle_deg": (
                float(np.degrees(np.arctan(v["static_friction"])))
                + 0.01 * rng.standard_normal()
            )
        }
    if run.rig == "roll":
        return {
            "run_out_mm": max(
                0.0,
                10 * np.sin(0.2618) / v["rolling_friction"]
                - 9.66
                + 2 * rng.standard_normal(),
            )
        }
    packing = (
        packing_sd * rng.standard_normal()
    )  # first: the same for every point on this packing
    own = (
        own_sd
        * np.random.default_rng(
            [*run.rng, int(1e6 * sum(v.values()))]
        ).standard_normal()
    )
    crest = 40 + 30 * (v["seed_static_friction"] - 0.5) + 0.2 * packing + own
    return {"repose_angle_deg": angle(v) + packing + own, "true_crest_mm": crest}


class StandIn:
    """Simulator; `runs` holds all that was asked for, `rigs` how many of each. fails:
    rigs of which every run fails."""

    def __init__(
        self, packing_sd: float = 0.4, own_sd: float = 0.15, fails: tuple[str, ...] = ()
    ):
        self.packing_sd, self.own_sd, self.fails, self.runs = (
            packing_sd,
            own_sd,
            fails,
            [],
        )

    def __call__(self, runs) -> pd.DataFrame:
        self.runs += runs
        rows = []
        for run in runs:
            told = {
                "status": "failed",
                "reason": "ValueError: it blew up",
                "rerun": "python -m benchtwin.twin.campaign X",
            }
            done = {"status": "done", "reason": "", "rerun": ""}
            rows.append(
                told
                if run.rig in self.fails
                else done | response(run, self.packing_sd, self.own_sd)
            )
        return pd.DataFrame(rows)

    @property
    def rigs(self) -> dict[str, int]:
        return pd.Series([r.rig for r in self.runs]).value_counts().to_dict()


def write_bench(
    folder,
    rng,
    *,
    readings: int = 10,
    piles: int = 3,
    true: dict = TRUE,
    packing_sd: float = 0.4,
):
    """A bench folder of readings that the stand-in itself would give with the true
    parameters."""
    from benchtwin.calibrate.procedure.simulator import Run

    columns = {
        "drop": "rebound_height_mm",
        "slide": "slide_angle_deg",
        "roll": "run_out_mm",
        "pile": "repose_angle_deg",
    }
    for rig, column in columns.items():
        (folder / rig).mkdir(parents=True)
        (folder / rig / "recording.toml").write_text(f'rig = "{rig}"\n')
        n = piles if rig == "pile" else readings
        values = [
            response(
                Run(rig, true, tuple(rng.integers(2**31, size=2).tolist())),
                packing_sd,
                0.15,
            )[column]
            for _ in range(n)
        ]
        scatter = 0.4 if rig == "slide" else 0.0  # hands on a goniometer
        (folder / rig / "readings.csv").write_text(
            column
            + "\n"
            + "\n".join(f"{v + scatter * rng.standard_normal():.4f}" for v in values)
        )
    (folder / "bench.toml").write_text(
        "[seed]\nlength_mm = 8.72\nwidth_mm = 6.84\nthickness_mm = 5.98\ndensity_kg_m3"
        " = 1250\n[drop]\nheight_mm = 310\n[roll]\nincline_deg = 15\nincline_length_mm"
        " = 10\n"
    )
    return folder


def calibrate_command(bench, out, simulator=None, **options) -> int:
    """The exit code of `benchtwin calibrate`; simulator: in the place of the campaign,
    without a twin to show."""
    with pytest.MonkeyPatch.context() as patch:
        if simulator is not None:
            patch.setattr(pairs, "pairs", lambda *_, **__: ([], []))
        return command_code("calibrate", simulator, bench=bench, out=out, **options)
