"""Slides and rolls run again: simulated and recorded way along the path."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.diagnose.rerun import Comparison, Resimulation, differences
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.paths import Path1D, Ran, Recording, above, filmed, run_path, shown

MOST = 6  # recordings that are run again
POINTS = 200  # at which ways are compared


@dataclass(frozen=True, eq=False)
class TwinPair:
    """One recording with its old and new simulation."""

    name: str
    seen: Path1D
    from_mm: float  # way at which all clocks start
    old: tuple[Recording, Parameters]  # this and new: what they are run like, and with
    new: tuple[Recording, Parameters]


def compared(
    again: Resimulation,
    twins: list[TwinPair],
    folder: Path,
    pictures: bool,
    say: Callable[[str], None],
) -> Resimulation:
    """`again` with every recording beside both simulations, a picture, and optionally
    films."""
    rows, ways = [], []
    for k, twin in enumerate(twins):
        say(
            tr(
                "{}: running the twin of {} again ({} of {})",
                again.rig,
                twin.name,
                k + 1,
                len(twins),
            )
        )
        ran = [run_path(*made, k) for made in (twin.old, twin.new)]
        before, after = (rms_distance_mm(twin, path) for path in ran)
        rows.append(
            Comparison(
                twin.name, tr("way along the path"), "mm", before, after, "track"
            )
        )
        ways.append(ran)
    best = max(range(len(twins)), key=lambda k: rows[k].before - rows[k].after)
    caption = tr(
        "{} at the same moments: as recorded (drawn from its track), the old twin, the"
        " new twin with {}, and what differs, brightened",
        twins[best].name,
        tr(" and ").join(again.effects),
    )
    again = replace(
        again, compared=tuple(rows), figure=_figure(twins[best], *ways[best])
    )
    try:  # no renderer, or a film that cannot be followed: a note
        again = replace(
            again, picture=_picture(twins[best], *ways[best]), caption=caption
        )
        if pictures:
            more = _followed(twins[best], best, again.rig, folder, say)
            again = replace(again, compared=(*again.compared, more))
    except (RuntimeError, ValueError) as error:
        again = replace(
            again, notes=(*again.notes, tr("no pictures of the twin: {}", error))
        )
    return again


def way_from_rest(r, share: int) -> np.ndarray:
    """Way (n,) [mm] from the median place of the first of `share` parts of the rows."""
    return r.x_mm - float(np.median(r.x_mm[: max(3, len(r.x_mm) // share)]))


def with_frame_rate(recording: Recording, time_s: np.ndarray) -> Recording:
    """The recording with the frame rate of these rows where none is stated."""
    if recording.camera.fps is not None:
        return recording
    fps = float(1 / np.median(np.diff(time_s)))
    return replace(recording, camera=recording.camera.model_copy(update={"fps": fps}))


def rms_distance_mm(twin: TwinPair, path: Path1D) -> float:
    """Root mean square [mm] between recorded and simulated way, clocks started at
    `from_mm`."""
    begin, own = twin.seen.reached(twin.from_mm), path.reached(twin.from_mm)
    if not np.isfinite(own):
        # it did not move that far
        return float(np.sqrt(((twin.seen.way - twin.from_mm) ** 2).mean()))
    time = np.linspace(0.0, twin.seen.time[-1] - begin, POINTS)
    return float(
        np.sqrt(((twin.seen.at(begin + time) - path.at(own + time)) ** 2).mean())
    )


def _followed(twin: TwinPair, number: int, rig: str, folder: Path, say) -> Comparison:
    import shutil

    off: dict[str, float] = {}
    for which, made in (("old", twin.old), ("new", twin.new)):
        out = folder / f"{twin.name.replace('/', '-')}-{which}"
        shutil.rmtree(out, ignore_errors=True)
        out.parent.mkdir(parents=True, exist_ok=True)
        off[which] = rms_distance_mm(
            twin, filmed(*made, number, out, lambda text: say(f"{rig}: {text}"))
        )
    return Comparison(
        twin.name, tr("way along the path"), "mm", off["old"], off["new"], "pictures"
    )


def _figure(twin: TwinPair, old: Path1D, new: Path1D) -> dict:
    begin = twin.seen.reached(twin.from_mm)
    time = np.linspace(0.0, twin.seen.time[-1] - begin, 60)
    points = {"recorded": (time, twin.seen.at(begin + time))}
    for name, path in (("old twin", old), ("new twin", new)):
        if np.isfinite(own := path.reached(twin.from_mm)):
            points[name] = (time, path.at(own + time))
    return {
        "x": tr("time since {:.3g} mm (s), {}", twin.from_mm, twin.name),
        "y": tr("way along the path (mm)"),
        "points": points,
    }


def _picture(twin: TwinPair, old: Ran, new: Ran) -> bytes:
    """Recording and simulations at the same moments: several of a roll, one of a
    slide."""
    slide = twin.old[0].rig == "slide"
    begin = twin.seen.reached(twin.from_mm)
    span = twin.seen.time[-1] - twin.seen.reached(twin.from_mm)
    moments = [0.8 * span] if slide else [k * span / 7 for k in range(8)]
    recorded = [
        int(np.argmin(np.abs(new.way - way)))
        for way in twin.seen.at(begin + np.array(moments))
    ]
    since = [path.time - path.reached(twin.from_mm) for path in (old, new)]
    frames = [[int(np.argmin(np.abs(s - t))) for t in moments] for s in since]
    drawn = [shown(twin.new[0], new.motion, recorded)]
    drawn += [
        shown(made[0], path.motion, which)
        for made, path, which in zip((twin.old, twin.new), (old, new), frames)
    ]
    labels = [
        "recording",
        "old twin",
        "new twin",
        "recording - old",
        "recording - new",
    ]
    return above([*drawn, *differences(drawn, 60)], labels)
