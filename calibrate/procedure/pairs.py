"""The answer shown: of every calibrated rig one recording of the bench beside the twin
at the most probable set of parameters."""

from collections.abc import Callable
from pathlib import Path

from benchtwin.bench.language import tr
from benchtwin.bench.rigs import RIGS
from benchtwin.calibrate.procedure.calibration import Calibration
from benchtwin.calibrate.procedure.effort import Effort
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.twin import Parameters
from benchtwin.twin.engine import OWN, Engine
from benchtwin.twin.job import Job, described
from benchtwin.twin.pair import Pair, Recording, pair, recordings


def pairs(
    c: Calibration,
    out: Path,
    effort: Effort,
    say: Callable[[str], None] = lambda text: None,
    engine: Engine = OWN,
) -> tuple[list[Pair], list[str]]:
    """Pairs, and why there is none of a rig. Of each rig that recording which lies
    nearest the bench's mean is taken; the twin of it is run into `out`, or read from
    there. Recordings of readings alone have nothing to show and are passed over."""
    found, why = [], []
    at = Parameters(**c.most_probable)
    entries = recordings(c.bench.observed)
    for rig in (*c.steel, *(n for n in c.seeds if n == PILE.name)):
        recording = _nearest(c, rig, entries)
        if recording is None:
            continue
        say(tr("{}: {} beside its twin", rig, recording.id))
        try:
            found.append(_pair(recording, at, c, effort, out / rig, engine))
        # no graphics, a full disk, a seed that flies off: a picture less, not a
        # calibration
        except Exception as error:
            why.append(
                tr(
                    "{}: {} could not be shown beside its twin: {}",
                    rig,
                    recording.id,
                    error,
                )
            )
    return found, why


def _nearest(
    c: Calibration, rig: str, entries: dict[str, Recording]
) -> Recording | None:
    """The recording, with something to show, whose reading lies nearest the mean."""
    readings = c.bench.rigs[rig]
    table = readings.recordings.dropna(subset=["mean"]).set_index("recording")["mean"]
    shown = {n for n, r in entries.items() if r.evidence != "readings.csv"}
    table = table[table.index.isin(shown)]
    if table.empty:
        return None
    return entries[(table - readings.values.mean()).abs().idxmin()]


def _pair(
    recording: Recording,
    at: Parameters,
    c: Calibration,
    effort: Effort,
    out: Path,
    engine: Engine,
) -> Pair:
    """The twin run as the recording states itself; of a pile as it was simulated for
    the calibration."""
    _, stated = described(recording.toml) if recording.toml.is_file() else (None, {})
    rig = recording.need_rig()
    lot = {name: stated.get(name, {}) for name in ("seed", "air")}
    if rig == PILE.name or not lot["seed"]:
        lot |= {k: v for k, v in c.bench.seed.items() if k in lot}
    section: dict = stated.get(rig, {})
    said: tuple[str, ...] = ()
    camera = {k: v for k, v in stated.get("camera", {}).items() if k == "fps"}
    if rig == PILE.name:
        of_bench = c.bench.rigs[rig].description.get(rig, {})
        section, said = effort.simulated(PILE, section or of_bench)
        section = RIGS[rig].as_built(section)
        camera = PILE.shown(section)
    description = {rig: section, "seed": lot["seed"], "camera": camera} | lot
    job = Job(rig, at, description, (c.seed,), rendered=rig == PILE.name, engine=engine)
    twin = job.run(out / job.key)
    return pair(recording, twin, alike=not said, observed=c.bench.observed)
