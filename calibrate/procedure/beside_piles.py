"""Rigs that tell of seed on seed beside the piles, as draw-downs do: simulated over the
piles' design, then where runs tell most."""

from dataclasses import replace

import numpy as np
import pandas as pd

from benchtwin.calibrate.procedure.more_piles import add_piles
from benchtwin.calibrate.procedure.pile_runs import design_points
from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.pile_surrogate import PileObservables, observed
from benchtwin.calibrate.procedure.simulator import SimulationFailed
from benchtwin.calibrate.statistics.box import Box

LEAST_RUNS = 12  # that were measured: fewer lay no surface over three parameters


def simulate_design(stage: PileStage, box: Box) -> tuple[int, pd.DataFrame]:
    """How many runs the design in `box` has, and those that were measured."""
    points = design_points(stage, box)
    _, done = stage.piles(points, np.arange(len(points)))
    return len(points), done


def simulate_beside(
    stage: PileStage, box: Box, known: tuple[PileObservables, ...]
) -> PileObservables:
    """What the recordings of the stage's rig say of the parameters: surfaces over the
    design in `box`, and further runs where they tell most beside what is `known`.
    SimulationFailed, ValueError where nothing can be laid through them."""
    asked, done = simulate_design(stage, box)
    name = stage.rig.name
    if len(done) < LEAST_RUNS:
        raise SimulationFailed(
            f"{name}: {len(done)} of {asked} simulated runs could be measured"
        )
    done, notes = add_piles(stage, box, done, shared=False, known=known)
    seen = observed(
        done, stage.readings, box, stage.steel, alike=stage.alike, rig=stage.rig
    )
    if not seen.observables:
        raise ValueError(f"{name}: nothing of it can be compared with a simulation")
    said = dict.fromkeys((*stage.notes, *_left_open(stage), *notes, *seen.notes))
    return replace(seen, notes=tuple(said), runs=done, believed=stage.left_open)


def _left_open(stage: PileStage) -> list[str]:
    return [
        f"[{stage.rig.name}] {key} is not stated: {of.mean:g} ± {of.sd:g} is believed,"
        " which widens the intervals; measure and state it"
        for key, of in stage.left_open.items()
    ]
