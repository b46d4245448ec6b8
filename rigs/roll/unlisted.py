"""Unlisted physics of rolls: resistance in windows of an axis, and laws for it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.table import Table, over
from benchtwin.infer import power_law
from benchtwin.infer.linear import beside_globals, chance, fall_of_chi2
from benchtwin.infer.possible_law import LEFT
from benchtwin.infer.power_law import Family, Law, raised, reference, resisting
from benchtwin.infer.problem import Fit
from benchtwin.infer.unlisted import Bin, Windows
from benchtwin.rigs.roll.model import run_motion, way_of
from benchtwin.rigs.roll.problem import PUSH
from benchtwin.rigs.roll.run_noise import has_few_rows
from benchtwin.rigs.roll.session import Run, Seed

BINS = 6
POINTS = 400
RISING = tuple(np.arange(0.5, 4.01, 0.5))  # of way and time
POWERS = (-1.0, -0.5, *np.arange(0.25, 4.01, 0.25))  # of speed
PARTS = 10  # of the run-out, for what acts on one part of the plate
LONGEST_PART = 0.65  # of the run-out, from which a part is hardly one
RADII = 0.82, 1.18  # of the stated radius: sizes in one lot, and the axis of rolling
MOST_RADII = 61
NEARER = 9  # radii between neighbours of the best one
POINTS_A_TURN = 24
AT_ONCE = 5  # radii
SEEN_P = 0.01  # p of as great a ripple by chance below which it is a candidate


@dataclass(frozen=True, eq=False)
class FittedRuns:
    """Each fitted run: way, travel as read (n,), speed (n,) at the rows."""

    ways: tuple
    seen: tuple[np.ndarray, ...]
    speed: tuple[np.ndarray, ...]


def fitted_runs(fit: Fit) -> FittedRuns:
    """The runs of a fit."""
    model, at = fit.problem.model, fit.by_name
    ways = tuple(way_of(model, r, own, at) for r, own in enumerate(fit.starts))
    found = [run_motion(model, r, own, at) for r, own in enumerate(fit.starts)]
    return FittedRuns(ways, tuple(f[0] for f in found), tuple(f[1] for f in found))


def response(fit: Fit, at: FittedRuns, r: int, **tables) -> np.ndarray:
    """(n,) [m]: change of run r's travel for a push, resistance or way of size PUSH,
    over PUSH."""
    out = run_motion(
        fit.problem.model,
        r,
        fit.starts[r],
        fit.by_name,
        **({"way": at.ways[r]} | tables),
    )[0]
    return (out - at.seen[r]) / PUSH


def bump(low: float, high: float, reach: float) -> Table:
    """−PUSH between low and high, 0 elsewhere, over [0, reach]."""
    grid = np.linspace(0.0, reach, POINTS)
    width = grid[1]
    inside = np.clip((grid - low) / width + 0.5, 0, 1) * np.clip(
        (high - grid) / width + 0.5, 0, 1
    )
    return over(grid, -PUSH * inside)


def windows_of(fit: Fit) -> Windows:
    """A resistance over weight in every bin of every axis, from release to stop."""
    at, model = fitted_runs(fit), fit.problem.model
    last = [
        float(t[s > 0.01 * s.max()].max())
        for t, s in zip((run.time_s for run in model.runs), at.speed, strict=True)
    ]
    reach_t = max(t - way.t0 for t, way in zip(last, at.ways, strict=True))
    reach_x = max(
        float(x[-1] - way.x0) for x, way in zip(at.seen, at.ways, strict=True)
    )
    top = max(float(s.max()) for s in at.speed)
    corner, passing = (
        max(way.corner - way.x0 for way in at.ways),
        any(not run.stays for run in model.runs),
    )
    where, columns = [], []
    axes = {"t_s": ("time", reach_t, 1.0), "x_mm": ("place", reach_x, 1e3)}
    axes["v_m_s"] = ("more", top, 1.0)
    for axis, (kind, reach, unit) in axes.items():
        for low, high in pairwise(np.linspace(0.0, reach, BINS + 1)):
            table = bump(low, high, 1.3 * reach)
            if kind == "more":  # a resistance, not a push
                table = table._replace(values=-table.values)
            sector = (
                "onset"
                if passing and axis == "x_mm" and high <= corner + 0.5 * (high - low)
                else "run-out"
            )
            where.append(
                Bin(axis, float(low * unit), float(high * unit), "resistance", sector)
            )
            columns.append(
                [response(fit, at, r, **{kind: table}) for r in range(len(model.runs))]
            )
    if np.all(model.turn > 0) and all(run.turning for run in model.runs):
        for low, high in pairwise(np.linspace(0.0, 2 * np.pi, BINS + 1)):
            where.append(Bin("phase", float(low), float(high), "resistance", "run-out"))
            columns.append(
                [
                    response(fit, at, r, place=_phase(model, at, r, low, high))
                    for r in range(len(model.runs))
                ]
            )
    return Windows(
        [np.column_stack(c) for c in zip(*columns, strict=True)], tuple(where)
    )


def _phase(model, at: FittedRuns, r: int, low: float, high: float) -> Table:
    """−PUSH where the ripple's argument modulo 2π lies between low and high."""
    reach = 1.3 * float(at.seen[r][-1] - at.ways[r].x0)
    grid = np.linspace(0.0, reach, 2000)
    phi = np.mod(model.turn[r] * (grid + at.ways[r].x0) + model.phase[r], 2 * np.pi)
    return over(grid, -PUSH * ((phi >= low) & (phi < high)))


def law_of(base: Fit) -> Law:
    """A resistance as a power of speed, way or time, or on a part of the way; a loss at
    the corner."""
    at, model = fitted_runs(base), base.problem.model
    runs = range(len(model.runs))
    top = reference(max(float(s.max()) for s in at.speed))
    begins = [law_begins_at(w, run) for w, run in zip(at.ways, model.runs, strict=True)]
    reach = max(float(x[-1] - x0) for x, x0 in zip(at.seen, begins, strict=True))
    waits = [
        float(np.interp(x0, np.maximum.accumulate(x), run.time_s)) - way.t0
        for x, x0, run, way in zip(at.seen, begins, model.runs, at.ways, strict=True)
    ]
    ends = [float(run.time_s[-1]) - w.t0 for run, w in zip(model.runs, at.ways)]
    last = max(e - w for e, w in zip(ends, waits, strict=True))
    far, long = reference(reach), reference(last)

    def by_speed(p: float, r: int) -> np.ndarray:
        grid = np.linspace(0.0, 1.3 * top, POINTS)
        return response(base, at, r, more=over(grid, PUSH * raised(grid / top, p)))

    def by_place(p: float, r: int) -> np.ndarray:
        grid = np.linspace(0.0, begins[r] - at.ways[r].x0 + 1.3 * reach, POINTS)
        past = np.maximum(grid - (begins[r] - at.ways[r].x0), 0.0)
        return response(base, at, r, place=over(grid, -PUSH * raised(past / far, p)))

    def by_time(p: float, r: int) -> np.ndarray:
        grid = np.linspace(0.0, ends[r], POINTS)
        past = np.maximum(grid - waits[r], 0.0)
        return response(base, at, r, time=over(grid, -PUSH * raised(past / long, p)))

    def least_drive(at: Mapping[str, float]) -> float:
        """A force along the motion that goes with speed or time is friction that is
        less there; with place it may be a plate that is not flat."""
        return (LEFT - 1) * model.mu * (1 + at["mu"])

    slowest = min(float(s.min()) for s in at.speed) / top
    acts = resisting(tr("rolling friction is more by"), "rolling_power", top)
    families = [
        replace(
            _resisting("speed", f"at {top:g} m/s", POWERS, acts),
            least=slowest,
            low=least_drive,
        ),
        _resisting("travel", tr("at {:g} mm", 1e3 * far), RISING),
        replace(_resisting("time", f"after {long:g} s", RISING), low=least_drive),
    ]
    columns = [[by_speed(p, r) for p in POWERS] for r in runs]
    for r in runs:
        columns[r] += [by_place(p, r) for p in RISING] + [by_time(p, r) for p in RISING]
    for part in combinations(np.linspace(0.0, reach, PARTS + 1), 2):
        if part[1] - part[0] >= LONGEST_PART * reach:
            continue
        families.append(_on_part(*part))
        for r in runs:
            low, high = (begins[r] - at.ways[r].x0 + x for x in part)
            pushed = bump(low, high, begins[r] - at.ways[r].x0 + 1.3 * reach)
            columns[r].append(response(base, at, r, place=pushed))
    if any(not run.stays for run in model.runs):
        families.append(CORNER)
        for r in runs:
            way = at.ways[r]._replace(keep=at.ways[r].keep * (1 - PUSH))
            columns[r].append(response(base, at, r, way=way))
    return power_law.law_of(base, families, [np.column_stack(c) for c in columns])


def _against(rises: bool) -> str:
    return tr("a force {} the motion", tr("against") if rises else tr("along"))


def _resisting(quantity: str, where: str, powers, acts=None) -> Family:
    return Family(
        lambda rises, power: tr("{} as {} {}", _against(rises), tr(quantity), power),
        ("1", tr("of the weight {}", where)),
        "run-out",
        powers,
        quantity,
        acts,
        tr("the twin knows no resistance that goes with {}", tr(quantity))
        * (acts is None),
    )


def _on_part(low: float, high: float) -> Family:
    part = tr("between {:.0f} and {:.0f} mm behind the corner", 1e3 * low, 1e3 * high)
    return Family(
        lambda rises, power: f"{_against(rises)} {part}",
        ("1", tr("of the weight")),
        "run-out",
        not_simulated=tr("the twin's plate is the same all over"),
    )


CORNER = Family(
    lambda rises, power: tr("a loss of speed at the corner"),
    ("1", "of the speed"),
    "onset",
    not_simulated="the twin's corner has no law of its own",
    low=lambda at: 0.0,
)


def law_begins_at(way, run) -> float:
    """Place [m] from which a law is looked for: the corner, or the release on an
    incline."""
    return float(way.x0 if run.stays else way.corner)


@dataclass(frozen=True)
class Ripple:
    """p of as great a ripple by chance; turn, phase (R,): its argument is turn x +
    phase."""

    p: float
    turn: np.ndarray
    phase: np.ndarray


def arguments(
    runs: tuple[Run, ...], seed: Seed, radius: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """turn, phase (R,): twice the seen orientation, or 2/r; radius: over the stated
    one."""
    turn, phase = [], []
    for run in runs:
        if run.turning:
            slope, level = (np.sign(run.turning[0]) * value for value in run.turning)
            turn.append(2 * slope)
            phase.append(2 * level)
        else:
            turn.append(2 / (seed.radius * radius))
            phase.append(-turn[-1] * float(np.mean(run.x)))
    return np.array(turn), np.array(phase)


def find_ripple(base: Fit, rng: np.random.Generator) -> Ripple:
    """For a fitted baseline without ripple."""
    model = base.problem.model
    if any(has_few_rows(run) for run in model.runs):
        return Ripple(1.0, *arguments(model.runs, model.seed))
    doubt, at = (
        np.exp(base.problem.level_sd * rng.standard_normal(4000)),
        fitted_runs(base),
    )
    if all(run.turning for run in model.runs):
        own = arguments(model.runs, model.seed)
        return Ripple(chance(*_falls(base, at, [own])[0], doubt), *own)
    way = max(
        float(seen[-1] - (w.x0 if run.stays else w.corner))
        for seen, w, run in zip(at.seen, at.ways, model.runs, strict=True)
    )
    count = int(
        np.clip((RADII[1] - RADII[0]) * way / model.seed.radius, 9, MOST_RADII)
    )  # neighbours differ by 2 rad at the end of the way
    radii = np.linspace(*RADII, count)
    falls = _falls_by_radius(base, at, radii)
    best = int(np.argmax([fall for fall, _ in falls]))
    p = min(1.0, count * chance(*falls[best], doubt))
    if p < SEEN_P:
        radii = radii[best] + (radii[1] - radii[0]) * np.linspace(-1, 1, NEARER)
        best = int(np.argmax([fall for fall, _ in _falls_by_radius(base, at, radii)]))
    return Ripple(p, *arguments(model.runs, model.seed, radii[best]))


def _falls_by_radius(
    base: Fit, at: FittedRuns, radii: np.ndarray
) -> list[tuple[float, int]]:
    """Fall of χ² and degrees of freedom at each radius over the stated one."""
    asked, found = (
        [
            arguments(base.problem.model.runs, base.problem.model.seed, radius)
            for radius in radii
        ],
        [],
    )
    for some in (asked[k : k + AT_ONCE] for k in range(0, len(asked), AT_ONCE)):
        found += _falls(base, at, some)
    return found


def _falls(base: Fit, at: FittedRuns, asked) -> list[tuple[float, int]]:
    """Fall of χ² and degrees of freedom for each (turn, phase), each run with its own
    ripple."""
    model, count = base.problem.model, len(base.problem.model.runs)
    rows = [len(run.x) + (run.junction is not None) for run in model.runs]
    extra = [np.zeros((n, 2 * count * len(asked))) for n in rows]
    for k, (turn, phase) in enumerate(asked):
        for r in range(count):
            reach = 1.1 * float(at.seen[r][-1] - at.ways[r].x0)
            grid = np.linspace(
                0.0, reach, max(50, int(reach * turn[r] / (2 * np.pi) * POINTS_A_TURN))
            )
            phi = turn[r] * (grid + at.ways[r].x0) + phase[r]
            for j, wave in enumerate((np.cos, np.sin)):
                push = over(grid, PUSH * wave(phi))
                moved = response(base, at, r, place=push)
                extra[r][: len(moved), 2 * (k * count + r) + j] = moved
    columns, project, b = beside_globals(
        base.problem.reduce(base.starts, base.values, extra)[0], base.prior_sd
    )
    return [
        fall_of_chi2(part, project, b) for part in np.split(columns, len(asked), axis=1)
    ]
