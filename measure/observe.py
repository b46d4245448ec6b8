"""Measures one recording, whatever its rig and evidence."""

import traceback
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.keys import Seed
from benchtwin.bench.language import tr
from benchtwin.bench.numbers import exact_by_mistake
from benchtwin.bench.rigs import RIGS
from benchtwin.bench.section import PLAUSIBLE_MM
from benchtwin.vision.evidence.read_keys import read_toml
from benchtwin.vision.measurement import (
    MeasurementError,
    Observation,
    Quantity,
    failed,
    with_doubts,
)
from benchtwin.vision.pile.repose import PileOptions
from benchtwin.vision.recording import Recording

# reported as failed where a recording cannot be measured
MAIN_QUANTITY: dict[str | None, tuple[str, str]] = {
    **{rig.name: rig.main for rig in RIGS.values()},
    "seeds": ("seed_length", "mm"),
    None: ("recording", ""),
}
# plausible masses and densities of seeds and balls: cork to lead
PLAUSIBLE_G, PLAUSIBLE_KG_M3 = (1e-5, 100.0), (150.0, 12_000.0)

Progress = Callable[[float], None]


def observe(
    recording: Recording,
    options: PileOptions | None = None,
    trim: bool = False,
    progress: Progress | None = None,
) -> Observation:
    """Measure one recording; MeasurementError with the reason where nothing can be
    measured. options: how pile photos are read; trim: leave out the highest and the
    lowest of repeated readings; progress: called with the fraction done."""
    observation = _observe(recording, options, trim, progress)
    return replace(
        observation,
        pictures={**observation.pictures, **_photographed(recording)},
        quantities=_sure(observation.quantities),
        repeats=tuple(map(_sure, observation.repeats)),
        bounces=_bounces(observation),
        notes=(
            *observation.notes,
            *seed_questions(recording.seed),
            *recording.sds_beyond_belief(),
        ),
    )


def _photographed(recording: Recording) -> dict[str, np.ndarray]:
    """What was found on the photo of a plate that the recording names."""
    section = getattr(recording, recording.rig) if recording.rig else None
    file = getattr(section, "plate_photo", None)
    if file is None:
        return {}
    from benchtwin.vision.shape.plate_coverage import coverage_of

    return {"plate": coverage_of(Path(file)).overlay()}


def _sure(quantities: Iterable[Quantity]) -> tuple[Quantity, ...]:
    return tuple(q.doubt(exact_by_mistake(q.value, q.sd)) for q in quantities)


def _bounces(observation: Observation) -> pd.DataFrame | None:
    """The bounces with the doubts of the quantities of their drops."""
    table, drops = observation.bounces, observation.repeats or (observation.quantities,)
    if table is None:
        return None
    parts = [
        with_doubts(table[table["drop"] == number], quantities)
        for number, quantities in enumerate(drops, 1)
    ]
    return pd.concat(parts, ignore_index=True)


def _observe(
    recording: Recording,
    options: PileOptions | None,
    trim: bool,
    progress: Progress | None,
) -> Observation:
    rig = RIGS.get(recording.rig or "")
    if rig is not None and rig.refuse and (why := rig.part("refuse")(recording)):
        raise MeasurementError(f"{recording.path}: {why}")
    if recording.evidence == "readings.csv":
        from benchtwin.vision.evidence.readings import observe_readings

        return observe_readings(recording, trim)
    if recording.rig is None:
        from benchtwin.vision.tell_rig import with_rig

        known, told = with_rig(recording)
        found = _observe(known, options, trim, progress)
        return replace(found, notes=(told, *found.notes))
    return RIGS[recording.rig].part("observe")(recording, options, progress)


def observe_seeds_photo(recording: Recording) -> Observation:
    """Measure a photo of spread seeds: mean length and width (sd of the mean, with that
    of the scale), and a row for each seed."""
    from benchtwin.vision.shape.lot_photos import observe_seeds

    if recording.evidence != "photos":
        raise MeasurementError(
            tr(
                "{}: seeds are measured on photos, not on {}",
                recording.path,
                recording.evidence,
            )
        )
    grains, overlay = observe_seeds(
        recording.files[0], recording.camera.mm_per_px, recording.camera.mm_per_px_sd
    )
    quantities = tuple(
        Quantity(f"seed_{row.quantity}", row.mean, row.mean_sd, row.unit)
        for row in grains.distribution().itertuples()
    )
    doubt = (
        tr("in px: no scale is known")
        if grains.scale is None
        else getattr(grains.scale, "reason", "")
    )
    quantities = tuple(q.doubt(doubt).doubt(grains.common_doubt) for q in quantities)
    rows = grains.distribution().itertuples()
    spread = [
        tr(
            "{}: n = {}, sd {:.3g}, range {:.3g}–{:.3g} {}",
            r.quantity,
            r.n,
            r.sd,
            r.min,
            r.max,
            r.unit,
        )
        for r in rows
    ]
    table = grains.table()
    table.insert(0, "recording", recording.id)
    return Observation(
        recording.id,
        "seeds",
        quantities,
        (*spread, *grains.notes),
        {"seeds": overlay},
        seeds=table,
    )


def seed_questions(seed: Seed) -> list[str]:
    """A question for a size, a mass and a density that no seed has; they are used as
    stated."""
    questions = []
    sizes = seed.sizes_mm
    if odd := [s for s in sizes if not _within(s, PLAUSIBLE_MM)]:
        questions.append(
            tr(
                "a seed of {:,g} mm: is it in millimetres? It is taken as stated",
                odd[0],
            )
        )
    if seed.mass_g and not _within(seed.mass_g, PLAUSIBLE_G):
        questions.append(
            tr("a seed of {:,g} g: is it in grams? It is taken as stated", seed.mass_g)
        )
    volume = (
        0.5236e-3 * sizes[0] * sizes[1] * sizes[2] if len(sizes) == 3 else None
    )  # cm³
    density = seed.density_kg_m3 or (
        1000 * seed.mass_g / volume if seed.mass_g and volume else None
    )
    if density and not _within(density, PLAUSIBLE_KG_M3) and not seed.inertia_factor:
        hollow = tr("A hollow ball has an [seed] inertia_factor of its own")
        questions.append(
            tr("sizes and mass make {:,.3g} kg/m³: are both right? {}", density, hollow)
        )
    return questions


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= value <= limits[1]


def observe_or_fail(
    entry: Recording | MeasurementError,
    observe: Callable[[Recording], Observation],
    rig: str | None = None,
) -> Observation:
    """`observe(entry)`; any error of this one recording becomes a failed quantity of
    its `rig`."""
    if isinstance(entry, MeasurementError):
        return _failure(entry.recording, rig, str(entry))
    bench = entry.path.resolve().parent.name
    return replace(
        _observe_or_fail(entry, observe, rig),
        bench=bench,
        session=entry.session,
        conditions=entry.conditions,
        stated=entry.as_built,
    )


def _observe_or_fail(
    entry: Recording, observe: Callable[[Recording], Observation], rig: str | None
) -> Observation:
    try:
        return observe(entry)
    except MeasurementError as error:
        reason = str(error)
    except OSError as error:
        reason = f"{error.filename or entry.path}: {error.strerror or error}"
    except MemoryError:
        reason = tr("{}: too large for this machine's memory", entry.path)
    except Exception as error:  # a bug in one recording must not cost the others
        place = traceback.extract_tb(error.__traceback__)[-1]
        reason = tr(
            "{}: a fault of benchtwin, please report it: {!r} in {}:{}",
            entry.path,
            error,
            Path(place.filename).name,
            place.lineno,
        )
    return _failure(entry.id, rig or entry.rig, reason + _rig_of_bench(entry))


def _rig_of_bench(recording: Recording) -> str:
    """Where the rig of a recording that failed is stated, if that is for the whole
    bench."""
    own, bench = recording.toml, recording.path.parent / "bench.toml"
    if own.is_file() and "rig" in read_toml(own):
        return ""
    if recording.rig is None or not bench.is_file() or "rig" not in read_toml(bench):
        return ""
    return tr(
        " ({} says rig = {!r} for all; {} may say another)", bench, recording.rig, own
    )


def _failure(name: str, rig: str | None, reason: str) -> Observation:
    quantity, unit = MAIN_QUANTITY[rig]
    return Observation(name, rig or "", (failed(quantity, unit, reason),))
