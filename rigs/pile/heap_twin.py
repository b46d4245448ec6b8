"""What a heap that nobody filmed would show: heaps simulated at drawn values of what is
not known (simulated_heaps.UNKNOWNS) and of an effect's strength, a quadratic through
them (response.Quadratic), and what recordings say of both by it."""

import json
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import emcee
import numpy as np
from scipy import optimize
from scipy.special import logsumexp
from scipy.stats import qmc

from benchtwin.bench.language import tr
from benchtwin.bench.whole_file import write_whole
from benchtwin.rigs.pile.effects import EFFECTS
from benchtwin.rigs.pile.effects.shapes import Law
from benchtwin.rigs.pile.read import SeenPile
from benchtwin.rigs.pile.response import Quadratic, quadratic
from benchtwin.rigs.pile.simulated_heaps import (
    AT,
    FILL_MM,
    GATE,
    SOYBEAN_MM,
    UNKNOWNS,
    HeapSettings,
    heap_job,
    heap_of,
    shape_of,
)
from benchtwin.sim.engine.step import Stopped
from benchtwin.sim.lammps.program import cores_here
from benchtwin.twin.job import Job

RUNS = 40  # heaps from which a rig's response is read
LEAST_RUNS = 24  # of these with a flank
FIRST = 100  # packing of the first of RUNS
STANDS_DEG = 60.0  # steeper than that a column stands, and is no heap
# of the flank's way, over which a surface's height is averaged
WINDOWS = ((0.05, 0.2), (0.4, 0.6), (0.8, 1.0), (1.0, 1.25))
DRAWS = 2**13  # of the unknowns, from which fits start
WALKERS, STEPS = 48, 1500  # of the sampler
EVIDENCE_DRAWS = 16  # 2 to that many
# what another friction between seeds changes
GATE_AT = [*UNKNOWNS].index(GATE)
FLOW = 1 + len(WINDOWS)  # of what `shows` gives, how long seeds flowed
OF_SEEDS = ("seed_static_friction", "seed_rolling_friction")


def is_plain(seen: SeenPile) -> bool:
    """Whether its seeds are known to be as usual."""
    return seen.description.get("pile", {}).get("plain", False)


def spared(seen: SeenPile, effect: str) -> bool:
    """Whether a heap does not show an effect: its seeds are usual, and it is one of
    seeds."""
    return is_plain(seen) and EFFECTS[effect].of_seeds


def shows(seen: SeenPile) -> np.ndarray:
    """(m,) angle, mean heights over WINDOWS, and ln of how long a film with a stated
    frame rate shows seeds flow [ln s]; NaN where it is not seen."""
    shape, heights = shape_of([seen]), []
    for low, high in WINDOWS:
        there = shape.surface[(low <= AT) & (high >= AT) & np.isfinite(shape.surface)]
        heights.append(there.mean() if len(there) else np.nan)
    flow = flowed(seen) if seen.clocked else np.nan
    return np.array([shape.angle_deg, *heights, flow])


def flowed(seen: SeenPile) -> float:
    """ln of how long seeds flowed, by the film's own clock [ln s]."""
    return float(np.log(seen.collapse.flow_s)) if seen.collapse else np.nan


def slowness(seen: SeenPile) -> float:
    """ln of the gate's time over that of the flow, which no clock changes; NaN without
    a film that shows both."""
    film = seen.collapse
    if film is None or not np.isfinite(film.flow_s) or not np.isfinite(film.gate_s):
        return np.nan
    return float(np.log(max(film.gate_s, film.gate_sd_s) / film.flow_s))


@dataclass(frozen=True, eq=False)
class Gate:
    """Its coordinate in draws by its slowness: a parabola through simulated heaps,
    between these."""

    parabola: np.ndarray
    between: tuple[float, float]

    def of(self, seen: SeenPile) -> float:
        """NaN without a film."""
        return float(
            np.clip(
                np.polyval(self.parabola, np.clip(slowness(seen), *self.between)), 0, 1
            )
        )


def value(name: str, share: float) -> float:
    """An unknown's value at a share [0, 1] of its span, by logarithms."""
    low, high = UNKNOWNS[name]
    return float(low * (high / low) ** share)


@dataclass(frozen=True)
class Added:
    """An effect that is put into heaps of seeds of that mean length, filled so many
    seeds high."""

    effect: str
    seed_mm: float
    seeds_high: float

    @property
    def law(self) -> Law:
        return EFFECTS[self.effect].law

    @property
    def most(self) -> float:
        """Its greatest strength."""
        return self.law.most(self.seeds_high)

    def drawn(self, count: int, seed: int, free: bool = True) -> np.ndarray:
        """(count, k) in [0, 1]: unknowns, and the strength, 0 if not free."""
        sobol = qmc.Sobol(len(UNKNOWNS) + 1, rng=np.random.default_rng(seed))
        draws = sobol.random_base2(int(np.ceil(np.log2(count))))[:count]
        if not self.law.stepless:
            draws[:, -1] = np.round(draws[:, -1])
        return draws * ([1.0] * len(UNKNOWNS) + [float(free)])

    def settings(self, draw: np.ndarray) -> HeapSettings:
        """What a draw (k,) means: UNKNOWNS by their logarithms, and the strength."""
        unknown = {name: value(name, share) for name, share in zip(UNKNOWNS, draw)}
        return HeapSettings(unknown, self.effect, float(draw[-1]) * self.most)


@dataclass(frozen=True, eq=False)
class Rig:
    """Recordings of one rig and of seeds of one size, and how its heaps respond."""

    recordings: tuple[SeenPile, ...]
    responses: tuple[Quadratic | None, ...]  # of what heaps show, None if they do not
    gate: Gate | None  # None: no gate
    effect: str

    def groups(self, half: int | None) -> list[tuple[SeenPile, ...]]:
        """Plain seeds, and others; every other recording of each, from `half` on."""
        out = []
        for plain in (True, False):
            own = tuple(r for r in self.recordings if is_plain(r) == plain)
            out.append(own if half is None else own[half::2])
        return [g for g in out if g]

    def ln_likelihood(
        self, half: int | None, plain: bool | None = None
    ) -> Callable[[np.ndarray], np.ndarray]:
        """(d,) of the recordings of a half at unknowns and strength (d, k) in [0, 1],
        which is 0 where `spared`. plain: only of plain seeds, or of the others."""
        groups = [
            (group, np.array([shows(r) for r in group]).T)
            for group in self.groups(half)
            if plain in (None, is_plain(group[0]))
        ]

        def at(draws: np.ndarray) -> np.ndarray:
            total = np.zeros(len(draws))
            for group, shown in groups:
                places = [self.place(draws, r) for r in group]
                for seen, response in zip(shown, self.responses, strict=True):
                    there = np.isfinite(seen)
                    if response is None or not there.any():
                        continue
                    known = [response.at(x) for x, ok in zip(places, there) if ok]
                    expected, variance = np.mean(known, axis=0)
                    variance = variance + response.packing_sd**2 / len(known)
                    off = (seen[there].mean() - expected) ** 2 / variance
                    total -= 0.5 * (off + np.log(variance))
            return total

        return at

    def place(self, draws: np.ndarray, seen: SeenPile) -> np.ndarray:
        """Draws (d, k) as a recording has them: without the effect where it is
        `spared`, with the gate's speed by its film."""
        own = draws.copy()
        if spared(seen, self.effect):
            own[:, -1] = 0.0
        if self.gate and np.isfinite(speed := self.gate.of(seen)):
            own[:, GATE_AT] = speed
        return own

    def gate_speed(self, group: Sequence[SeenPile]) -> dict[str, float]:
        """{GATE: geometric mean by the films of a group}; {} without any."""
        shares = [self.gate.of(seen) for seen in group] if self.gate else []
        known = [share for share in shares if np.isfinite(share)]
        return {GATE: value(GATE, float(np.mean(known)))} if known else {}

    def clock(self, draws: np.ndarray) -> np.ndarray:
        """(d,) how many times as long as by their own clocks films without a stated
        frame rate took, by these draws; empty without such films."""
        response, ratios = self.responses[FLOW], []
        rng = np.random.default_rng(5)
        of_response = rng.standard_normal(len(draws))  # one error for all films
        for seen in self.recordings if response else ():
            if not seen.clocked and np.isfinite(own := flowed(seen)):
                expected, variance = response.at(self.place(draws, seen))
                film_sd = seen.collapse.flow_sd_s / seen.collapse.flow_s
                spread = np.hypot(response.packing_sd, film_sd)
                off = spread * rng.standard_normal(len(draws))
                ratios.append(expected + np.sqrt(variance) * of_response + off - own)
        return np.exp(np.mean(ratios, axis=0)) if ratios else np.zeros(0)


def added_to(seen: list[SeenPile], effect: str) -> Added:
    """The effect, as it can be in heaps like these."""
    told = [r.description for r in seen]
    seeds_mm = [t.get("seed", {}).get("length_mm", SOYBEAN_MM[0]) for t in told]
    fills_mm = [t.get("pile", {}).get("fill_height_mm", FILL_MM) for t in told]
    seed_mm = float(np.mean(seeds_mm))
    return Added(effect, seed_mm, float(np.mean(fills_mm)) / seed_mm)


def responding(
    recordings: tuple[SeenPile, ...], added: Added, folder: Path, say
) -> Rig:
    """Heaps of the rig at drawn unknowns and strengths, each of its own packing; what
    they show is kept in `folder`, and not simulated again."""
    draws, told = added.drawn(RUNS, 1), recordings[0].description
    jobs = [
        heap_job(told, added.settings(draw), added.seed_mm, FIRST + k)
        for k, draw in enumerate(draws)
    ]
    kept = []
    with ThreadPoolExecutor(cores_here()) as pool:
        for row in pool.map(lambda job: _kept(job, folder), jobs):
            kept.append(row)
            say(
                tr(
                    "pile: heap {} of {} simulated with {}",
                    len(kept),
                    RUNS,
                    added.effect,
                )
            )
    shown = np.array([row["shows"] for row in kept], dtype=float)
    slow = np.array([row["slowness"] for row in kept], dtype=float)
    shown[shown[:, 0] > STANDS_DEG] = np.nan
    if (usable := int(np.isfinite(shown[:, 0]).sum())) < LEAST_RUNS:
        said = tr(
            "only {} of {} simulated heaps of this rig have a flank", usable, RUNS
        )
        raise ValueError(tr("{}; {} are needed", said, LEAST_RUNS))
    responses = tuple(
        quadratic(draws, y) if np.isfinite(y).any() else None for y in shown.T
    )
    stated = GATE in told.get("pile", {})
    gate = None if stated else _gate(slow, draws)
    return Rig(recordings, responses, gate, added.effect)


def _gate(slow: np.ndarray, draws: np.ndarray) -> Gate | None:
    """From heaps of that slowness; None of a rig without a gate."""
    if (seen := np.isfinite(slow)).sum() < LEAST_RUNS:
        return None
    parabola = np.polyfit(slow[seen], draws[seen, GATE_AT], 2)
    return Gate(parabola, (float(slow[seen].min()), float(slow[seen].max())))


def _kept(job: Job, folder: Path) -> dict:
    """What one heap "shows", and its "slowness"; None where it has no flank or a guard
    stopped it."""
    if not (file := folder / f"{job.key}.json").is_file():
        try:
            heap = heap_of(job)
            shown, slow = [*shows(heap)], slowness(heap)
        except (ValueError, Stopped):
            shown, slow = [np.nan] * (FLOW + 1), np.nan
        *first, last = (v if np.isfinite(v) else None for v in (*shown, slow))
        known = {"shows": first, "slowness": last}
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(file, json.dumps(known))
    return json.loads(file.read_text(encoding="utf8"))


def ln_likelihood(
    rigs: list[Rig], half: int | None, plain: bool | None = None
) -> Callable[[np.ndarray], np.ndarray]:
    """Rig.ln_likelihood of all rigs together."""
    parts = [rig.ln_likelihood(half, plain) for rig in rigs]
    return lambda draws: np.sum([part(draws) for part in parts], axis=0)


def fitted(rigs: list[Rig], half: int | None, added: Added, free: bool) -> HeapSettings:
    """The likeliest settings, with `free` the effect's strength among them."""
    draws = added.drawn(DRAWS, 2, free)
    likelihood = ln_likelihood(rigs, half)
    best = draws[likelihood(draws).argmax()]
    ends = (0.0, 1.0) if free and added.law.stepless else best[[-1, -1]]
    found = optimize.minimize(
        lambda x: -likelihood(x[None])[0],
        best,
        bounds=[(0.0, 1.0)] * len(UNKNOWNS) + [ends],
    )
    return added.settings(found.x)


def posterior(rigs: list[Rig], added: Added) -> np.ndarray:
    """Draws (n, k) in [0, 1] of unknowns and strength, given all recordings."""
    likelihood = ln_likelihood(rigs, None)

    def ln_density(x: np.ndarray) -> np.ndarray:
        inside = ((x >= 0) & (x <= 1)).all(axis=1)
        return np.where(inside, likelihood(x), -np.inf)

    draws = added.drawn(DRAWS, 2)
    likeliest = draws[ln_density(draws).argsort()[-WALKERS:]]
    sampler = emcee.EnsembleSampler(WALKERS, draws.shape[1], ln_density, vectorize=True)
    sampler.random_state = np.random.MT19937(3).state
    sampler.run_mcmc(likeliest, STEPS)
    return sampler.get_chain(discard=STEPS // 3, flat=True)


def between(values: np.ndarray) -> str:
    """Median and 95 %."""
    low, middle, high = np.quantile(values, [0.025, 0.5, 0.975])
    return tr("{:.2g} ({:.2g} to {:.2g})", middle, low, high)


def odds_over_friction(rigs: list[Rig], added: Added) -> float:
    """How many times as probable the recordings are with the effect, at any strength,
    as with another friction and rolling friction between the seeds that are not plain:
    both averaged over all unknowns."""
    draws = qmc.Sobol(len(UNKNOWNS) + 1 + len(OF_SEEDS), rng=np.random.default_rng(4))
    drawn = draws.random_base2(EVIDENCE_DRAWS)
    with_effect, other = np.split(drawn, [len(UNKNOWNS) + 1], axis=1)
    without = with_effect * ([1.0] * len(UNKNOWNS) + [0.0])
    changed = without.copy()
    changed[:, [[*UNKNOWNS].index(name) for name in OF_SEEDS]] = other
    if not added.law.stepless:
        with_effect[:, -1] = 1.0
    plain = ln_likelihood(rigs, None, plain=True)(without)
    of_others = ln_likelihood(rigs, None, plain=False)
    one, two = (logsumexp(plain + of_others(x)) for x in (with_effect, changed))
    return float(np.exp(one - two))
