"""What the bench says, rig by rig: readings of all recordings pooled; contradictions
named, what is left out with its reason."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.rigs import STEEL
from benchtwin.calibrate.statistics.bench import (
    BenchMean,
    agreement,
    bench_mean,
    one_reading,
)
from benchtwin.twin.bench_folder import (
    WEIGHED,
    Observed,
    RecordingReadings,
    hashes,
    read_bench,
)
from scipy import stats

PER_RECORDING = {
    "baseline_px",
    "direction",
    "photo_s",
    "start_deg",
    *WEIGHED,
}  # not what makes a rig another rig
LOT = ("length_mm", "width_mm", "thickness_mm")


@dataclass(frozen=True, eq=False)
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
    shared_sd: float
    description: dict
    recordings: pd.DataFrame
    notes: tuple[str, ...]
    further: dict[str, np.ndarray] = field(default_factory=dict)
    trimmed: int = 0

    def mean(self, *, other: tuple[float, float] | None = None) -> BenchMean:
        """The bench's mean. other: (sd, df) of single simulated runs, which stands in
        for the scatter of a single reading.

        Raises ValueError as `bench_mean`.
        """
        if self.values.size == 1 and other is not None and other[0] > 0:
            sd = float(np.hypot(other[0], self.reading_sd[0]))
            return one_reading(
                self.values[0],
                name=self.response,
                scatter_sd=sd,
                df=max(other[1], 1.0),
                shared_sd=self.shared_sd,
            )
        return bench_mean(
            self.values,
            name=f"{self.rig}: {self.response}",
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


def bench_of(folder: Path | Observed) -> Bench:
    """Read and pool a bench folder. FileNotFoundError where there is none; ValueError
    where nothing in it can be read."""
    observed = Observed.under(folder)
    seen = read_bench(observed)
    trouble = tuple((s.recording, s.rig, s.trouble) for s in seen if s.trouble)
    rigs = {
        rig: _pooled(rig, [s for s in seen if s.rig == rig])
        for rig in ("drop", "slide", "roll", "pile")
        if any(s.rig == rig and s.readings.size for s in seen)
    }
    if not rigs:
        raise ValueError(
            f"{folder}: nothing could be measured: "
            + "; ".join(why for *_, why in trouble)
        )
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


def trimmed_before(bench: Bench, rigs: dict[str, int]) -> Bench:
    """The bench, told how many highest and lowest readings of each rig were left out
    before: {rig: number}."""
    return replace(
        bench,
        rigs={n: replace(r, trimmed=rigs.get(n, 0)) for n, r in bench.rigs.items()},
    )


def missing(bench: Bench) -> dict[str, str]:
    """Rigs without a reading, with what that costs and why."""
    asked = {
        **{n: r.parameter for n, r in STEEL.items()},
        "pile": "the seed–seed parameters",
    }
    why = {n: "; ".join(w for _, rig, w in bench.trouble if rig == n) for n in asked}
    return {
        n: (
            f"no {n} recording was measured, so {what} not calibrated"
            + (f": {why[n]}" if why[n] else "")
        )
        for n, what in (
            (n, f"{w} {'are' if n == 'pile' else 'is'}") for n, w in asked.items()
        )
        if n not in bench.rigs
    }


def contradictory(bench: Bench) -> list[str]:
    """Recordings of one rig that cannot all be right, as findings."""
    return [
        f"{rig}: {note}"
        for rig, r in bench.rigs.items()
        for note in r.notes
        if " contradicts the other recordings" in note
    ]


def _pooled(rig: str, seen: list[RecordingReadings]) -> RigReadings:
    """Recordings of one rig as one set of readings; those of a differently built rig
    are left out and named."""
    usable = [s for s in seen if s.readings.size]
    by_signature: dict[str, list[RecordingReadings]] = {}
    for s in usable:
        by_signature.setdefault(_signature(s), []).append(s)
    pooled = max(
        by_signature.values(), key=lambda group: sum(s.readings.size for s in group)
    )
    notes = [f"{s.recording}: {s.trouble}" for s in seen if s.trouble]
    for group in by_signature.values():
        if group is not pooled:
            names = ", ".join(s.recording for s in group)
            notes.append(
                f"{names}: another {rig} than {pooled[0].recording}"
                f" ({_signature(group[0]) or 'nothing stated'}); left out"
            )
    notes += [f"{s.recording}: {s.doubt}" for s in pooled if s.doubt]
    values = np.concatenate([s.readings for s in pooled])
    reading_sd = np.concatenate([s.reading_sd for s in pooled])
    table = pd.DataFrame([_row(s) for s in seen])
    notes += _contradictions(pooled)
    shared = float(max(s.shared_sd for s in pooled))
    columns = dict.fromkeys(column for s in pooled for column in s.further)
    further = {
        c: np.concatenate([s.further[c] for s in pooled if c in s.further])
        for c in columns
    }
    return RigReadings(
        rig,
        pooled[0].response,
        values,
        reading_sd,
        shared,
        _rig_description(pooled[0]),
        table,
        tuple(notes),
        further,
    )


def _signature(s: RecordingReadings) -> str:
    """What tells two rigs of one kind apart."""
    section = {
        k: v for k, v in s.description.get(s.rig, {}).items() if k not in PER_RECORDING
    }
    return ", ".join(f"{k} = {v}" for k, v in sorted(section.items()))


def _rig_description(s: RecordingReadings) -> dict:
    """The rig's section, and how many seeds were taped together, for a simulation; the
    camera of the bench has no part in it."""
    section = {
        k: v for k, v in s.description.get(s.rig, {}).items() if k not in PER_RECORDING
    }
    count = (
        {"seed": {"count": s.description["seed"]["count"]}}
        if "count" in s.description.get("seed", {})
        else {}
    )
    return {s.rig: section, **count} if section else count


def _row(s: RecordingReadings) -> dict:
    n = s.readings.size
    scatter = (
        float(s.readings.std(ddof=1))
        if n > 1
        else float(s.reading_sd[0])
        if n
        else float("nan")
    )
    mean = float(s.readings.mean()) if n else float("nan")
    return {
        "recording": s.recording,
        "n": n,
        "mean": mean,
        "sd": scatter,
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
    sds = [
        np.hypot(spread, np.sqrt(np.mean(s.reading_sd**2))) / np.sqrt(s.readings.size)
        for s in pooled
    ]
    found = agreement(
        [s.recording for s in pooled], [s.readings.mean() for s in pooled], sds
    )
    return [
        f"{label}: {value:.4g} contradicts the other recordings ({others:.4g},"
        f" {abs(z):.1f} standard deviations apart)"
        for label, value, _, others, z, contradicts in found.itertuples(
            index=False, name=None
        )
        if contradicts
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
        f"{pooled[worst].recording}: {x[worst]:.4g} lies far from the others"
        f" ({rest.mean():.4g} ± {rest.std(ddof=1):.2g}): look at what was found on it"
        " before it is believed"
    ]


def _lot(seen: list[RecordingReadings]) -> dict:
    """[seed] and [air]: of a recording that states ranges, else the mean of what
    recordings state of single seeds."""
    sections = [s.description.get("seed", {}) for s in seen]
    air: dict = next(
        (s.description["air"] for s in seen if s.description.get("air")), {}
    )
    whole = next((x for x in sections if "length_range_mm" in x), None)
    if whole is None:
        sized = [x for x in sections if all(k in x for k in LOT)]
        whole = dict(sized[0]) if sized else next((x for x in sections if x), {})
        whole = whole | {
            k: float(f"{np.mean([x[k] for x in sized]):.6g}") for k in LOT if sized
        }
    lot = {
        k: v
        for k, v in whole.items()
        if k != "count" and not (k == "mass_g" and "density_kg_m3" in whole)
    }
    return {name: section for name, section in (("seed", lot), ("air", air)) if section}
