"""Inertia of a rolling seed or ball: 1 + I/(m r²).

A solid ball on a plate has I/(m r²) = 2/5, a hollow one up to 2/3. On two rails it
rolls on the smaller radius √(R² − (gap/2)²), so that I/(m r²) grows by R² / (R² −
(gap/2)²). An ellipsoid that rolls across its longest axis has (a² + b²)/(5 r²)."""

import math
from dataclasses import dataclass

from benchtwin.bench.keys import Seed
from benchtwin.bench.language import tr
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording

SOLID = 0.4
ROUND = 0.02  # elongation of what is taken for a ball


@dataclass(frozen=True)
class Inertia:
    """factor: 1 + I/(m r²); sd: relative; radius_mm: rolling radius, NaN where no size
    is stated; ball: stated to be round."""

    factor: float
    sd: float
    radius_mm: float
    ball: bool


def inertia_of(seed: Seed, rail_gap_mm: float | None) -> Inertia:
    """Inertia of a seed on a plate, or on two rails at that inside distance;
    MeasurementError where it would fall between them."""
    sizes = sorted(seed.sizes_mm, reverse=True)
    across = sizes[1:] if len(sizes) == 3 else sizes[-1:] * 2
    radius = sum(across) / 4 if sizes else math.nan
    ball = len(sizes) > 1 and sizes[0] - sizes[-1] < ROUND * (sizes[0] + sizes[-1])
    share = sum(s**2 for s in across) / 20 / radius**2 if sizes else SOLID
    share = share if seed.inertia_factor is None else seed.inertia_factor
    known = ball or seed.inertia_factor is not None
    sd = (stated_sd if known else unstated_sd)("inertia")
    if not rail_gap_mm:
        return Inertia(1 + share, sd, radius, ball)
    if not sizes:
        raise MeasurementError(
            tr(
                "[seed] length_mm is missing; on rails the rolling radius depends on a"
                " ball's diameter"
            )
        )
    if rail_gap_mm >= min(across):
        raise MeasurementError(
            tr(
                "[roll] rail_gap_mm = {:g}: a ball of {:g} mm falls between such rails",
                rail_gap_mm,
                min(across),
            )
        )
    low = radius**2 - (rail_gap_mm / 2) ** 2
    return Inertia(1 + share * radius**2 / low, sd, math.sqrt(low), ball)


def inertia_of_recording(recording: Recording) -> Inertia:
    """Inertia of a recording's seed; MeasurementError names its file."""
    try:
        return inertia_of(recording.seed, recording.roll.rail_gap_mm)
    except MeasurementError as error:
        raise MeasurementError(f"{recording.toml}: {error}") from error


def inertia_told(description: dict) -> Inertia:
    """The same by sections of recording.toml as plain values; ValueError where it
    falls between the rails."""
    gap = description.get("roll", {}).get("rail_gap_mm")
    return inertia_of(Seed(**description.get("seed", {})), gap)
