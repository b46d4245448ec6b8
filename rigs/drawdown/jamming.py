"""How often the slot jams, by its width, and the width at which half of the runs jam.

    P(jam) = 1 / (1 + exp((w − w½)/b)),   b > 0

Of w½ [mm] the maximum of the likelihood, and as its 95 % interval all widths that a
likelihood-ratio test at 5 % keeps (b at its own maximum for each). Where that has no
end, or the runs do not show that the width matters (the same test), no width is given.
Of one width's share the 95 % interval of Wilson (1927)."""

from collections.abc import Iterable

import numpy as np
from scipy import special

from benchtwin.bench import distributions as stats
from benchtwin.bench.language import tr
from benchtwin.vision.measurement import Observation, Quantity
from benchtwin.vision.recording import Recording

JAMMED = (
    "an arch over the slot ended the flow: it tells of jamming, not of slope and time"
)
NORMAL_95 = float(stats.norm.ppf(0.975))
ANY_SHARE = 12**-0.5  # sd of a share that may be any
KEPT = float(stats.chi2.ppf(0.95, 1)) / 2  # of a log likelihood below its maximum
WIDTHS, STEEPNESSES = 2001, 60  # places of a grid: finer than any interval of a bench
# b in widths: from steeper than any series of openings shows to no dependence on width
STEEP, FLAT = 1e-3, 1.0


def jammed(recording: Recording) -> str:
    """Why a jammed run has no slope and no time; "" for a run that flowed."""
    return tr(JAMMED) if recording.drawdown.jammed else ""


def jamming(
    measured: Iterable[tuple[Recording, Observation]],
) -> list[Observation]:
    """An observation of the quantity `jam_share` for every width of slot of which any
    run says whether it jammed; and of half_jam_slot [mm] where several widths bracket
    it."""
    runs: dict[float, list[bool]] = {}
    for recording, _ in measured:
        stated = recording.drawdown
        if stated.slot_mm is not None and stated.jammed is not None:
            runs.setdefault(stated.slot_mm, []).append(stated.jammed)
    found = [_share(width, jams) for width, jams in sorted(runs.items())]
    if not any(any(jams) for jams in runs.values()):
        return []
    half = half_width(
        np.array(list(runs)),
        np.array([sum(jams) for jams in runs.values()]),
        np.array([len(jams) for jams in runs.values()]),
    )
    if half is not None:
        width, low, high = half
        sd = (high - low) / (2 * NORMAL_95)
        note = tr(
            "half of the runs jam at {:.1f} mm, 95 % {:.1f} to {:.1f} mm",
            width,
            low,
            high,
        )
        value = Quantity("half_jam_slot", width, sd, "mm")
        found.append(Observation("slots", "drawdown", (value,), (note,)))
    return found


def _share(width: float, jams: list[bool]) -> Observation:
    n, jammed = len(jams), sum(jams)
    low, high = share_interval(jammed, n)
    sd = (high - low) / (2 * NORMAL_95)
    value = Quantity("jam_share", jammed / n, sd, "1", believed_sd=ANY_SHARE)
    note = tr("{} of {} runs jammed, 95 % {:.2f} to {:.2f}", jammed, n, low, high)
    return Observation(tr("slot {:g} mm", width), "drawdown", (value,), (note,))


def share_interval(count: int, n: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share: count of n."""
    z2 = NORMAL_95**2
    middle = (count + z2 / 2) / (n + z2)
    half = NORMAL_95 * np.sqrt(count * (n - count) / n + z2 / 4) / (n + z2)
    return float(max(middle - half, 0.0)), float(min(middle + half, 1.0))


def half_width(
    widths: np.ndarray, jammed: np.ndarray, runs: np.ndarray
) -> tuple[float, float, float] | None:
    """w½ and the ends of its 95 % interval; None where the runs do not bracket it.

    widths (n,) of slots; jammed, runs (n,): counts at each."""
    places = np.linspace(0.0, 2 * widths.max(), WIDTHS)
    b = np.geomspace(STEEP, FLAT, STEEPNESSES) * widths.max()
    runs_on = (widths[:, None, None] - places[:, None]) / b
    likely = special.log_expit(-runs_on) * jammed[:, None, None]
    likely += special.log_expit(runs_on) * (runs - jammed)[:, None, None]
    profile = likely.sum(axis=0).max(axis=1)
    share = jammed.sum() / runs.sum()
    alike = special.xlogy(jammed, share) + special.xlog1py(runs - jammed, -share)
    if profile.max() - alike.sum() < KEPT:
        return None
    kept = np.flatnonzero(profile >= profile.max() - KEPT)
    if kept[0] == 0 or kept[-1] == WIDTHS - 1:
        return None
    top = np.flatnonzero(
        profile >= profile.max() - 1e-9
    )  # all between where it is flat
    return float(places[top].mean()), float(places[kept[0]]), float(places[kept[-1]])
