"""What the bench says, rig by rig: readings of all recordings pooled; contradictions
named, what is left out with its reason."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.bench.language import tr
from benchtwin.bench.rigs import RIGS, variant_of
from benchtwin.calibrate.procedure.rigs import BESIDE, PILE, STEEL
from benchtwin.calibrate.statistics.bench import (
    BenchMean,
    agreement,
    bench_mean,
    pooled_mean,
)
from benchtwin.twin.bench_folder import (
    Observed,
    RecordingReadings,
    hashes,
    read_bench,
)

LOT = ("length_mm", "width_mm", "thickness_mm")


@dataclass(frozen=True, kw_only=True, eq=False)
class RigReadings:
    """All readings of one rig.

    values, reading_sd: (n,); shared_sd: error common to all; description: sections that
    a simulation of the rig takes; recordings: table recording, n, mean, sd, trouble;
    notes: what a reader must know of them; further: {column: readings} of other things
    that were read on the same rig; trimmed: how many highest and how many lowest were
    left out before."""

    rig: str
    response: str
    values: np.ndarray
    reading_sd: np.ndarray
    shared_sd: float = 0.0
    description: dict = field(default_factory=dict)
    recordings: pd.DataFrame = field(default_factory=pd.DataFrame)
    notes: tuple[str, ...] = ()
    contradictions: tuple[str, ...] = ()
    further: dict[str, np.ndarray] = field(default_factory=dict)
    trimmed: int = 0

    def mean(self, *, other: tuple[float, float] | None = None) -> BenchMean:
        """The bench's mean. other: (sd, df) of single simulated runs, which stands in
        for the scatter of a single reading. Raises ValueError as `bench_mean`."""
        name = f"{self.rig}: {self.response}"
        if self.values.size == 1 and other is not None and other[0] > 0:
            sd, df = other
            return pooled_mean(
                self.values,
                name=name,
                scatter_sd=sd,
                df=df,
                reading_sd=self.reading_sd,
                shared_sd=self.shared_sd,
            )
        return bench_mean(
            self.values,
            name=name,
            reading_sd=self.reading_sd,
            shared_sd=self.shared_sd,
            trimmed=self.trimmed,
        )


@dataclass(frozen=True, eq=False)
class Bench:
    """A bench folder, read. rigs: those with readings; seed: the sections [seed] and
    [air] of the lot; trouble: recordings that could not be read, (name, rig, why);
    hashes: SHA-256 of every input file; observed: the recordings, and what was seen on
    them."""

    folder: Path
    rigs: dict[str, RigReadings]
    seed: dict
    trouble: tuple[tuple[str, str, str], ...]
    hashes: dict[str, str]
    provenance: tuple[str, ...]
    observed: Observed


def bench_of(folder: Path | Observed, trimmed: dict[str, int] | None = None) -> Bench:
    """Read and pool a bench folder. trimmed: how many highest and lowest readings of
    each rig were left out before. FileNotFoundError where there is none; ValueError
    where nothing in it can be read."""
    observed = Observed.under(folder)
    seen = read_bench(observed)
    trouble = tuple((s.recording, s.rig, s.trouble) for s in seen if s.trouble)
    apart = _by_name(seen)
    rigs = {
        name: _pooled(name, apart[name], (trimmed or {}).get(name, 0))
        for name in (*STEEL, PILE.name, *BESIDE)
        if any(s.readings.size for s in apart.get(name, ()))
    }
    if not rigs:
        why = "; ".join(why for *_, why in trouble)
        raise ValueError(tr("{}: nothing could be measured: {}", folder, why))
    provenance = tuple(sorted({s.provenance for s in seen if s.provenance}))
    return Bench(
        observed.folder,
        rigs,
        _lot(seen),
        trouble,
        hashes(observed),
        provenance,
        observed,
    )


def _by_name(seen: list[RecordingReadings]) -> dict[str, list[RecordingReadings]]:
    """Recordings by the rig that they are evidence of: a variant stands beside its rig
    where both were read, else in its place; never in that of seed on steel."""
    plain = set(STEEL) | {
        s.rig for s in seen if s.readings.size and _variant(s) == s.rig
    }
    apart: dict[str, list[RecordingReadings]] = {}
    for s in seen:
        apart.setdefault(_variant(s) if s.rig in plain else s.rig, []).append(s)
    return apart


def _variant(s: RecordingReadings) -> str:
    name = variant_of(s.rig, s.description) if s.rig else ""
    return name if name in BESIDE else s.rig


def missing(bench: Bench) -> dict[str, str]:
    """Rigs without a reading, with what that costs and why."""
    costs = {n: tr("{} is", rig.parameter) for n, rig in STEEL.items()}
    if not bench.rigs.keys() & BESIDE.keys():
        costs[PILE.name] = tr("the seed–seed parameters are")
    why = {n: "; ".join(w for _, rig, w in bench.trouble if rig == n) for n in costs}
    return {
        n: tr("no {} recording was measured, so {} not calibrated", n, cost)
        + (f": {why[n]}" if why[n] else "")
        for n, cost in costs.items()
        if n not in bench.rigs
    }


def contradictory(bench: Bench) -> list[str]:
    """Recordings of one rig that cannot all be right, as findings."""
    return [
        f"{rig}: {note}" for rig, r in bench.rigs.items() for note in r.contradictions
    ]


def _pooled(rig: str, seen: list[RecordingReadings], trimmed: int) -> RigReadings:
    """Recordings of one rig as one set of readings; those of a differently built rig
    are left out and named."""
    groups: dict[str, list[RecordingReadings]] = {}
    for s in seen:
        if s.readings.size:
            built = ", ".join(f"{k} = {v}" for k, v in sorted(_section(s).items()))
            groups.setdefault(built, []).append(s)
    pooled = max(groups.values(), key=lambda group: sum(s.readings.size for s in group))
    notes = [f"{s.recording}: {s.trouble}" for s in seen if s.trouble]
    for built, group in groups.items():
        if group is not pooled:
            names = ", ".join(s.recording for s in group)
            notes.append(
                tr(
                    "{}: another {} than {} ({}); left out",
                    names,
                    rig,
                    pooled[0].recording,
                    built or "nothing stated",
                )
            )
    notes += [f"{s.recording}: {s.doubt}" for s in pooled if s.doubt]
    further = dict.fromkeys(column for s in pooled for column in s.further)
    contradictions = tuple(_contradictions(pooled))
    return RigReadings(
        rig=rig,
        response=pooled[0].response,
        values=np.concatenate([s.readings for s in pooled]),
        reading_sd=np.concatenate([s.reading_sd for s in pooled]),
        shared_sd=float(max(s.shared_sd for s in pooled)),
        description=_rig_description(pooled[0]),
        recordings=pd.DataFrame([_row(s) for s in seen]),
        notes=(*notes, *contradictions),
        contradictions=contradictions,
        further={
            c: np.concatenate([s.further[c] for s in pooled if c in s.further])
            for c in further
        },
        trimmed=trimmed,
    )


def _section(s: RecordingReadings) -> dict:
    return RIGS[s.rig].as_built(s.description.get(s.rig, {}))


def _rig_description(s: RecordingReadings) -> dict:
    """The rig's section, and how many seeds were taped together, for a simulation; the
    camera of the bench has no part in it."""
    section, seed = _section(s), s.description.get("seed", {})
    count = {"seed": {"count": seed["count"]}} if "count" in seed else {}
    return ({s.rig: section} if section else {}) | count


def _row(s: RecordingReadings) -> dict:
    n = s.readings.size
    own = float(s.reading_sd[0]) if n else np.nan
    return {
        "recording": s.recording,
        "n": n,
        "mean": float(s.readings.mean()) if n else np.nan,
        "sd": float(s.readings.std(ddof=1)) if n > 1 else own,
        "doubt": s.doubt,
        "trouble": s.trouble,
    }


def _contradictions(pooled: list[RecordingReadings]) -> list[str]:
    """Recordings farther from the others than the scatter within recordings allows, as
    sentences."""
    several = [s.readings for s in pooled if s.readings.size > 1]
    if not several:
        return _outlier(pooled)
    spread = float(np.sqrt(np.mean([r.var(ddof=1) for r in several])))
    if len(pooled) < 2 or spread == 0:
        return []
    own = [np.hypot(spread, np.sqrt(np.mean(s.reading_sd**2))) for s in pooled]
    names = [s.recording for s in pooled]
    sds = [sd / np.sqrt(s.readings.size) for sd, s in zip(own, pooled)]
    found = agreement(names, [s.readings.mean() for s in pooled], sds)
    return [
        tr(
            "{}: {:.4g} contradicts the other recordings ({:.4g}, {:.1f} standard"
            " deviations apart)",
            r.name,
            r.value,
            r.others,
            abs(r.z),
        )
        for r in found[found["contradicts"]].itertuples()
    ]


def _outlier(pooled: list[RecordingReadings], alpha: float = 0.01) -> list[str]:
    """Of films of one seed each, the one that Grubbs' test (1969) finds too far off;
    seeds differ, so it may be right."""
    x, n = np.array([s.readings[0] for s in pooled]), len(pooled)
    if n < 3 or np.ptp(x) == 0:
        return []
    t = stats.t.ppf(1 - alpha / (2 * n), n - 2)
    far = abs(x - x.mean()) / x.std(ddof=1)
    worst = int(np.argmax(far))
    if far[worst] <= (n - 1) / np.sqrt(n) * np.sqrt(t**2 / (n - 2 + t**2)):
        return []
    rest = np.delete(x, worst)
    return [
        tr(
            "{}: {:.4g} lies far from the others ({:.4g} ± {:.2g}): look at what was"
            " found on it before it is believed",
            pooled[worst].recording,
            x[worst],
            rest.mean(),
            rest.std(ddof=1),
        )
    ]


def _lot(seen: list[RecordingReadings]) -> dict:
    """[seed] and [air]: of a recording that states ranges, else the mean of what
    recordings state of single seeds."""
    sections = [s.description.get("seed", {}) for s in seen]
    airs = [s.description["air"] for s in seen if s.description.get("air")]
    whole = next((x for x in sections if "length_range_mm" in x), None)
    if whole is None:
        sized = [x for x in sections if all(k in x for k in LOT)]
        whole = dict(next((x for x in [*sized, *sections] if x), {}))
        for k in LOT if sized else ():
            whole[k] = float(f"{np.mean([x[k] for x in sized]):.6g}")
    known = {"count"} | ({"mass_g"} if "density_kg_m3" in whole else set())
    lot = {k: v for k, v in whole.items() if k not in known}
    found = {"seed": lot, "air": airs[0] if airs else {}}
    return {name: section for name, section in found.items() if section}
