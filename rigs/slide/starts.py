"""Where a fit of slides begins: each run alone, its onset searched over a grid, or its
speed and friction from several first guesses."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from benchtwin.bench.constants import G_M_S2
from benchtwin.rigs.slide.model import OWN, Model, run_motion
from benchtwin.rigs.slide.session import SET_OFF, Run, Session

# trial places on a step at which a block lets go [sd]
LAGS = (-1.5, -0.75, 0.0, 0.75, 1.5)
ONSETS, REFINED, REFINEMENTS = 60, 15, 5  # tried over the recording; about the best
LATEST = 0.9  # of the recording
EARLY = 6  # rows that tell the speed with which a block sets off
FLATTER = 0.05  # friction under the plate's slope, for a first guess
TRIALS = 40  # of a first descent


@dataclass(frozen=True)
class Start:
    """First values of a run; friction: in motion, or at the onset; loss: of friction at
    the onset; stretch: of its travel in the picture."""

    own: np.ndarray
    friction: float
    loss: float = 0.0
    stretch: float = 1.0


def own_of(values: dict[str, float]) -> np.ndarray:
    """A run's parameters (L,) from those that are not 0."""
    return np.array([values.get(name, 0.0) for name in OWN])


def start_of(
    model: Model, r: int, sigma: np.ndarray, *, jump: bool = False, free: bool = False
) -> Start:
    """Of one run; sigma (n,): sds of its rows; jump: whether it may lose friction at
    its onset; free: whether its travel's unit is unknown."""
    run = model.session.runs[r]
    if run.in_motion:
        return _of_motion(run, sigma)
    return _of_onset(model, r, sigma, jump, free)


def _of_onset(model: Model, r: int, sigma: np.ndarray, jump: bool, free: bool) -> Start:
    run = model.session.runs[r]
    time = run.time - run.tilt.origin
    lags = LAGS if model.stair_deg else (0.0,)

    def tried(onset: float, lag: float = 0.0) -> tuple[float, Start]:
        own = own_of({"onset": onset, "phase": lag})
        way, _, friction, _ = run_motion(model, r, own, {})
        columns = [np.ones(len(time))]
        columns += [1e3 * way] if free else []
        columns += [np.clip(time - onset, 0, None) ** 2] if jump else []
        design = np.column_stack(columns) / sigma[:, None]
        data = (run.travel - (0.0 if free else 1e3 * way)) / sigma
        found = np.linalg.lstsq(design, data, rcond=None)[0]
        if jump and found[-1] < 0:  # friction does not increase at the onset
            kept = np.linalg.lstsq(design[:, :-1], data, rcond=None)[0]
            found = np.append(kept, 0.0)
        stretch = float(found[1]) if free else 1.0
        lost = 2e-3 * float(found[-1]) * math.hypot(1.0, friction) / G_M_S2
        own[OWN.index("place")] = found[0]
        left = data - design @ found
        begun = Start(own, friction, lost if jump else 0.0, stretch)
        return float(left @ left), begun

    grid = np.linspace(time[0], time[0] + LATEST * (time[-1] - time[0]), ONSETS)
    for _ in range(REFINEMENTS):
        at = int(np.argmin([tried(t)[0] for t in grid]))
        ends = grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)]
        grid = np.linspace(*ends, REFINED)
    fine = grid[REFINED // 2 : REFINED // 2 + 1]
    if model.stair_deg:
        step = grid[1] - grid[0]
        fine = np.linspace(grid[0], grid[-1], 9) + step * np.arange(-4, 5)
    every = [tried(t, lag) for t in fine for lag in lags]
    return min(every, key=lambda found: found[0])[1]


def _of_motion(run: Run, sigma: np.ndarray) -> Start:
    """Several frictions are tried, since one that stops the block within the recording
    is another minimum."""
    edge = max(run.rest - 1, 0) if run.how == SET_OFF else 0
    time = run.time - run.tilt.origin
    angle = float(run.tilt.at(run.time).mean())
    since, gone = (
        time[edge:] - time[edge],
        1e-3 * (run.travel - run.travel[edge])[edge:],
    )
    speed = float(np.polyfit(since, gone, min(2, len(since) - 1))[-2])
    early = slice(1, max(2, min(EARLY, len(since) // 3)))
    first = float(np.median(gone[early] / since[early]))  # before friction tells
    way = max(float(np.ptp(gone)), 1e-6)
    guesses = []
    for v in (speed, first, way / float(np.ptp(time))):
        stops = math.tan(angle) + v**2 / (2 * G_M_S2 * way * math.cos(angle))
        guesses += [(v, math.tan(angle) - FLATTER), (v, stops)]
    if not run.tilt.stands:  # a raised plate does not stop what slides
        guesses = guesses[:1]
    names = ["place", "speed", "own friction", *["onset"] * (run.how == SET_OFF)]
    model = Model(Session((run,), (), (), ()), 0.0)

    def left(values: np.ndarray) -> np.ndarray:
        own = own_of(dict(zip(names, values, strict=True)))
        model.seen.clear()
        return (run.travel - own[0] - 1e3 * run_motion(model, 0, own, {})[0]) / sigma

    ends = [(-np.inf, np.inf), (0.0, np.inf), (-np.inf, np.inf), (time[0], time[-3])]
    low, high = np.transpose(ends[: len(names)])
    tried = [
        least_squares(
            left,
            np.clip([run.travel[edge], v, mu, time[edge]][: len(names)], low, high),
            bounds=(low, high),
            x_scale="jac",
            max_nfev=TRIALS,
        )
        for v, mu in guesses
    ]
    best = min(tried, key=lambda found: found.cost)
    own = own_of(dict(zip(names, best.x, strict=True)))
    friction = float(own[OWN.index("own friction")])
    own[OWN.index("own friction")] = 0.0
    return Start(own, friction)
