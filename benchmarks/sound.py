"""Impacts found in drawn sound (drawn_sound.py): how many are found, how many invented,
how exact times and restitution are.

Times of compressed sound are compared after their common shift is taken off, which
encoders may put in."""

import argparse
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from drawn_sound import SCENES, Drawn, Scene, draw, draw_session, write

CLEAR_DB = 0.0  # an impact as loud as that is counted by itself as well
MATCH_S = 3e-3  # a time found this near to a true one is that one


def heard(file: Path, height_mm: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] of the impacts that the reader finds, and their sds."""
    from benchtwin.vision.evidence.sound import read_sound
    from benchtwin.vision.motion.impact_chain import find_chain
    from benchtwin.vision.motion.onsets import find_onsets

    sound = read_sound(file)
    onsets = find_onsets(sound)
    found, _ = find_chain(onsets, sound.duration_s, height_mm)
    impacts = found[found.drop >= 0]
    return impacts.time_s, impacts.sd_s


@dataclass(eq=False)
class Score:
    """Counts and errors of many drops: the first four impacts and those of them that
    are clear, found ones, all that were said and those that are none, seconds of work
    and of sound; errors of times with sd and loudness, errors of e."""

    due: int = 0
    found: int = 0
    clear: int = 0
    clear_found: int = 0
    said: int = 0
    invented: int = 0
    seconds: float = 0.0
    listened: float = 0.0
    times: list = field(default_factory=list)
    e: list = field(default_factory=list)

    def add(
        self, drawn: Drawn, times: np.ndarray, sds: np.ndarray, compressed: bool
    ) -> None:
        near = (
            np.abs(times[:, None] - drawn.times[None])
            if len(times)
            else np.zeros((0, len(drawn.times)))
        )
        own = near.argmin(axis=1) if len(times) else np.zeros(0, int)
        right = near.min(axis=1) < MATCH_S if len(times) else np.zeros(0, bool)
        four = set(range(min(4, len(drawn.times))))
        clear = {k for k in four if drawn.db[k] >= CLEAR_DB}
        heard = set(own[right].tolist())
        self.due, self.found = self.due + len(four), self.found + len(four & heard)
        self.clear, self.clear_found = (
            self.clear + len(clear),
            self.clear_found + len(clear & heard),
        )
        self.said += len(times)
        self.invented += int((~right).sum())
        off = times[right] - drawn.times[own[right]]
        if compressed and len(off):
            off = off - np.median(off)
        self.times += list(zip(off, sds[right], drawn.db[own[right]]))
        at = dict(zip(own[right], times[right]))
        for k in range(1, min(len(drawn.e), 3)):  # the second and third bounce
            if {k - 1, k, k + 1} <= at.keys():
                self.e.append((at[k + 1] - at[k]) / (at[k] - at[k - 1]) - drawn.e[k])


def study(scene: Scene, drops: int, seed: int) -> Score:
    """A row of the table."""
    score = Score()
    with tempfile.TemporaryDirectory() as folder:
        for k in range(drops):
            drawn = draw(scene, np.random.default_rng([seed, k]))
            file = write(drawn, scene.codec, Path(folder), f"{k}")
            begin = time.process_time()
            times, sds = heard(file, drawn.height_mm if scene.stated else None)
            score.seconds += time.process_time() - begin
            score.listened += len(drawn.samples) / drawn.rate
            score.add(drawn, times, sds, bool(scene.codec))
            file.unlink()
    return score


HEAD = (
    f"{'scene':28} {'found':>7} {'of 0 dB':>7} {'invented':>8} {'rms ms':>7}"
    f" {'>= 10 dB':>8} {'in 2 sd':>7} {'e < .005':>8} {'s / 10 s':>8}"
)


def row(name: str, score: Score) -> str:
    off, sd, db = np.array(score.times).reshape(-1, 3).T
    loud = db >= 10
    e = np.abs(score.e)
    rms = [
        1000 * np.sqrt(np.mean(np.square(x))) if len(x) else np.nan
        for x in (off, off[loud])
    ]
    inside = np.mean(np.abs(off) < 1.96 * sd) if len(off) else np.nan
    shares = (
        score.found / score.due,
        score.clear_found / max(score.clear, 1),
        score.invented / max(score.said, 1),
    )
    found, clear, invented = (100 * share for share in shares)
    good = 100 * np.mean(e < 0.005) if len(e) else np.nan
    return (
        f"{name:28} {found:6.1f}% {clear:6.1f}% {invented:7.1f}% {rms[0]:7.3f}"
        f" {rms[1]:8.3f} {100 * inside:6.1f}% {good:7.1f}%"
        f" {10 * score.seconds / score.listened:8.2f}"
    )


def sessions(e: float, stated: bool, sounds: int) -> str:
    """A row of the table of sounds that hold ten drops each (300 mm, pink noise, thumps
    between, e of the drops scattered by .02)."""
    from benchtwin.vision.evidence.sound import Sound
    from benchtwin.vision.motion.impact_chain import find_chain
    from benchtwin.vision.motion.onsets import find_onsets

    scene = Scene("ten drops", (20, 30), "pink")
    due = found = said = 0
    for k in range(sounds):
        rng = np.random.default_rng([round(100 * e), k])
        drawn = draw_session(scene, e + 0.02 * rng.standard_normal(10), 300.0, rng)
        one = drawn[0]
        sound = Sound(Path("drawn"), one.samples, one.rate, 0.0, False)
        onsets = find_onsets(sound)
        height_mm = one.height_mm if stated else None
        heard_all, _ = find_chain(onsets, sound.duration_s, height_mm)
        impacts = heard_all[heard_all.drop >= 0]
        times = impacts.time_s[np.flatnonzero(np.diff(impacts.drop, prepend=-1))]
        off = np.abs(times[:, None] - [d.times[0] for d in drawn])
        due, said = due + len(drawn), said + len(times)
        found += int((off.min(axis=1, initial=np.inf) < MATCH_S).sum())
    height = "stated" if stated else "unknown"
    return (
        f"e {e:.2f}, height {height:8} {found:4} of {due} found, {said - found} others"
    )


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("drops", type=int, nargs="?", default=50, help="a row")
    options.add_argument(
        "rows", nargs="*", help="only rows in whose names one of these words is"
    )
    options.add_argument(
        "--several",
        type=int,
        default=0,
        help="sounds of ten drops each, in their stead",
    )
    arguments = options.parse_args()
    for e in (0.3, 0.5, 0.6, 0.88) if arguments.several else ():
        for stated in (True, False):
            print(sessions(e, stated, arguments.several), flush=True)
    if arguments.several:
        return
    drops, wanted = arguments.drops, arguments.rows
    print(HEAD, flush=True)
    for k, scene in enumerate(SCENES):
        if not wanted or any(w in scene.name for w in wanted):
            print(row(scene.name, study(scene, drops, k)), flush=True)


if __name__ == "__main__":
    main()
