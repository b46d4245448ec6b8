"""Drops run again in the DEM: flights from their own starts, impacts at their own speeds, seen as the camera saw them."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from calibrate.diagnose.air import G_M_S2, Air, drag_shape
from calibrate.diagnose.drop.model import build, nearer, pictured, places, pushed, rate_of, velocities
from calibrate.diagnose.drop.problem import problem_of
from calibrate.diagnose.drop.session import assemble
from calibrate.diagnose.effects.drop import EFFECTS
from calibrate.diagnose.finding import Finding, without
from calibrate.diagnose.linear import ridge, stacked
from calibrate.diagnose.model import Again, Compared, change_in_words
from calibrate.diagnose.problem import Fit, fit
from calibrate.twin.flown import drag_factor, fly

TYPICAL = 0.75  # of the greatest speed: where drag bends a flight most


def drops_again(finding: Finding, tracks: list, folder: Path, pictures: bool, say) -> Again:
    """Flight and picture by flights, impacts by impacts; both where both were named."""
    from calibrate.diagnose.drop.pictures import with_pictures
    from calibrate.diagnose.drop.strikes import strikes_again

    names = finding.modelled
    in_flight = tuple(n for n in names if n in EFFECTS)
    again = Again("drop", names, change_in_words("drop", finding), "", (), len(finding.recordings) > 1)
    if in_flight:
        say("drop: flying the old and the new twin")
        flown = [(f, f.read(f.before), f.read(f.after)) for f in sessions_of(tracks, in_flight)]
        rows = tuple(row for f, old, new in flown for row in f.compared(old, new))
        how = "each flight was flown by the DEM from the start that the recording shows, old and new twin alike"
        again = with_pictures(replace(again, compared=rows, how=how), *_most_mended(flown), folder, pictures, say)
    if len(in_flight) < len(names):
        say("drop: striking the old and the new twin's plate")
        again = strikes_again(again, finding, tracks)
    return again


def sessions_of(tracks: list, names: tuple[str, ...]) -> list["Flights"]:
    """The filmed drops of each session; a session of which no flight can be used is left out."""
    out, filmed = [], [t for t in tracks if len(t.frame)]
    for session in dict.fromkeys(t.session for t in filmed):
        try:
            out.append(Flights([t for t in filmed if t.session == session], names))
        except ValueError:
            continue
    return out


def _most_mended(flown: list[tuple["Flights", np.ndarray, np.ndarray]]) -> tuple["Flights", np.ndarray, np.ndarray]:
    return max(flown, key=lambda f: float(((f[0].session.places - f[1]) ** 2 - (f[0].session.places - f[2]) ** 2).sum()))


class Flights:
    """A session's flights with the baseline (what was named at nil) and with the model fitted; `read` has the DEM fly them."""

    def __init__(self, tracks: list, names: tuple[str, ...]) -> None:
        self.tracks = [t for t in tracks if not t.trouble]
        self.session = assemble(self.tracks)
        problem = problem_of(build(self.session))
        base = fit(problem)
        self.after = fit(problem, free=names, start=base)
        self.before = without(base, names)

    def read(self, of: Fit) -> np.ndarray:
        """What the camera would read (n, 2) [m] of the DEM's flights, each recording with the globals that the others gave."""
        s, out = self.session, np.zeros_like(self.session.places)
        for r in range(len(s.names)):
            values, starts = left_out(of, r)
            self._fly(r, dict(zip(of.names, values, strict=True)), starts, out)
        return out

    def _fly(self, r: int, values: dict[str, float], starts: np.ndarray, out: np.ndarray) -> None:
        s = self.session
        flights = np.flatnonzero(s.recording == r)
        if not len(flights):
            return
        rate = rate_of(values)
        begin = self.begins(starts, values)[flights]
        begin[:, 2:] *= rate
        fastest = max(np.linalg.norm(begin[:, 2:], axis=1).max(), float((2 * s.half[flights] * G_M_S2 - begin[:, 3]).max()))
        laws = laws_of(self.tracks[r].description, s.air[r], values, TYPICAL * fastest)
        flown = fly(self.tracks[r].description, laws, begin, s.own_spin[flights] * rate, 2 * s.half[flights].max() / rate)
        seen = np.zeros_like(out)
        for k, f in enumerate(flights):
            rows = slice(s.first[f], s.stop[f])
            seen[rows] = nearer(flown.at(k, (s.tau[rows] + s.half[f]) / rate), s, starts, s.flight[rows], s.tau[rows])
        seen = pictured(seen, s.view, values)
        mine = s.recording[s.flight] == r
        out[mine] = seen[mine]

    def begins(self, starts: np.ndarray, values: dict[str, float]) -> np.ndarray:
        """(F, 5): where and how fast each flight's seed is at its first row, by the model's own flights; v_y."""
        model = self.after.problem.model
        push = pushed(model, starts, values)
        aside = np.sqrt(np.maximum(starts[:, 4:5], 0.0))
        return np.hstack([places(model.begins, starts, push), velocities(model.begins, starts, push), aside])

    def compared(self, old: np.ndarray, new: np.ndarray):
        """One row a recording: root mean square distance [mm] from what was recorded, along each axis on average."""
        s = self.session
        for r, name in enumerate(s.names):
            mine = s.recording[s.flight] == r
            if not mine.any():
                continue  # none of its flights could be used
            before, after = (1e3 * float(np.sqrt(((s.places - seen)[mine] ** 2).mean())) for seen in (old, new))
            yield Compared(name, "place in flight", "mm", before, after, "track")


def left_out(of: Fit, r: int) -> tuple[np.ndarray, np.ndarray]:
    """Globals as the recordings other than r have them, and the starts (F, 7) that go with them."""
    flown = sorted(set(of.problem.model.session.recording.tolist()))  # the reduced space holds no others
    k = flown.index(r) if r in flown else len(flown)
    others = of.reduced[:k] + of.reduced[k + 1 :]
    if not others:
        return of.values, of.starts
    values = ridge(*stacked(others), of.prior_sd)[0]
    return values, of.starts + of.problem.reduce(of.starts, of.values)[1](values - of.values)


def laws_of(description: dict, air: Air, values: dict[str, float], speed: float) -> dict[str, dict]:
    """The DEM's laws for a flight: drag of the stated air and what is missing of it, its draught, Magnus' force.

    The DEM's own C_d(Re) is another fit to measured spheres: both are made to agree at `speed` [m/s], typical of the flight.
    """
    total = max(air.share + values.get("drag", 0.0), 0.0) * float(drag_shape(speed, air.reynolds_per_speed)) * speed
    laws = {"drag": drag_factor(description, total, speed) | {"wind_x": values.get("draught", 0.0)}}
    if values.get("magnus", 0.0):
        density = description.get("air", {}).get("density_kg_m3") or 1.2
        laws["magnus"] = {"air_density": density, "lift": float(np.clip(values["magnus"], -5, 5))}
    return laws
