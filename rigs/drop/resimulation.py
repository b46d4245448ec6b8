"""Drops run again in the DEM: flights from their own starts, impacts at their own
speeds."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchtwin.bench.air import REFERENCE_SPEED_M_S, Air, drag_shape
from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.language import tr
from benchtwin.diagnose.rerun import (
    NO_LAWS,
    Comparison,
    Resimulation,
    change_in_words,
    simulation_settings,
)
from benchtwin.infer.effect import Effect
from benchtwin.infer.finding import Finding
from benchtwin.infer.linear import ridge, stacked
from benchtwin.infer.problem import Fit, fit
from benchtwin.rigs.drop.flight_model import (
    IN_FLIGHT,
    nearer,
    pictured,
    places,
    pushed,
    rate_of,
    velocities,
)
from benchtwin.rigs.drop.flown import fly
from benchtwin.rigs.drop.joint_problem import (
    PreparedSession,
    prepared_drops,
)
from benchtwin.twin.lone_seed import bench_of, drag_factor
from benchtwin.twin.parameters import Parameters

MAX_ITERATIONS = 3  # of Gauss–Newton for the starts
TYPICAL = 0.75  # of the greatest speed, at which both drag laws agree


def resimulate(
    finding: Finding, tracks: list, folder: Path, pictures: bool, say
) -> Resimulation:
    """Effects in flight or picture by flights, effects of impacts by impacts."""
    from benchtwin.rigs.drop.impact_resimulation import strikes_again
    from benchtwin.rigs.drop.pictures import with_pictures

    names, laws = finding.modelled, finding.laws
    filmed = [t for t in tracks if len(t.frame)]
    pushing = {n for n, law in laws.items() if law.acceleration}
    in_flight = tuple(n for n in names if (n in IN_FLIGHT or n in pushing) and filmed)
    again = Resimulation(
        "drop",
        names,
        change_in_words(finding),
        "",
        (),
        len(finding.recordings) > 1,
    )
    flights = session_flights(filmed, in_flight, laws) if filmed else []
    if in_flight:
        say(tr("drop: flying the old and the new twin"))
        pairs = [(f, f.read(without=in_flight), f.read()) for f in flights]
        rows = tuple(row for f, old, new in pairs for row in f.compared(old, new))
        how = tr(
            "each flight was flown by the DEM from the start that the recording shows,"
            " old and new twin alike"
        )
        seen = [f.session.places for f in flights]
        gains = [
            ((s - a) ** 2 - (s - b) ** 2).sum() for s, (_, a, b) in zip(seen, pairs)
        ]
        best = pairs[int(np.argmax(gains))]
        again = with_pictures(
            replace(again, compared=rows, how=how), *best, folder, pictures, say
        )
    if len(in_flight) < len(names):
        say(tr("drop: striking the old and the new twin's plate"))
        again = strikes_again(
            again, finding, tracks, tuple(f.prepared for f in flights)
        )
    return again


def session_flights(
    filmed: list, names: tuple[str, ...], laws: Mapping[str, Effect] = NO_LAWS
) -> list["Flights"]:
    """The filmed drops of each session."""
    return [Flights(session, names, laws) for session in prepared_drops(filmed)[0]]


class Flights:
    """A session's flights fitted with what was named; `read` has the DEM fly them."""

    def __init__(
        self,
        prepared: PreparedSession,
        names: tuple[str, ...],
        laws: Mapping[str, Effect] = NO_LAWS,
    ) -> None:
        self.prepared, self.session = prepared, prepared.problem.model.session
        self.tracks = [t for t in prepared.tracks if not t.trouble]
        problem, self.laws = prepared.problem, laws
        for law in (laws[n] for n in names if n in laws):
            assert problem.with_effect is not None
            problem = problem.with_effect(law)
        free = tuple(n for n in names if n in problem.names)
        self.fit = fit(problem, free=free, start=fit(problem))

    def read(self, without: tuple[str, ...] = ()) -> np.ndarray:
        """What the camera would read (n, 2) [m] of the DEM's flights, by the others'
        globals."""
        s, out = self.session, np.zeros_like(self.session.places)
        nil = np.isin(
            self.fit.names,
            [n for effect in without for n in self.fit.problem.columns_of(effect)],
        )
        for r in range(len(s.names)):
            values = np.where(nil, 0.0, left_out(self.fit, r))
            starts = started(self.fit, values)
            self._fly(r, dict(zip(self.fit.names, values, strict=True)), starts, out)
        return out

    def _fly(
        self, r: int, values: dict[str, float], starts: np.ndarray, out: np.ndarray
    ) -> None:
        s = self.session
        flights = np.flatnonzero(s.recording == r)
        if not len(flights):
            return
        rate = rate_of(values)
        begin = self.begins(starts, values)[flights]
        begin[:, 2:] *= rate
        fastest = max(
            np.linalg.norm(begin[:, 2:], axis=1).max(),
            float((2 * s.half[flights] * G_M_S2 - begin[:, 3]).max()),
        )
        change = simulation_settings("drop", values, self.laws)
        told, speed = self.tracks[r].description, TYPICAL * fastest
        laws = laws_of(told, s.air[r], change.get("air", {}), speed)
        if push := change.get("laws", {}).get("push_power"):
            _, seed = bench_of("drop", told, {}, Parameters())
            force = -push.pop("weights") * seed.mass_kg * G_M_S2
            laws["push_power"] = push | {"force": force}
        flown = fly(
            told,
            laws,
            begin,
            s.own_spin[flights] * rate,
            2 * s.half[flights].max() / rate,
        )
        lighter = (
            G_M_S2 * 1.5 * s.air[r].buoyancy / (1 + s.air[r].buoyancy / 2)
        )  # buoyancy and added mass, which the DEM leaves out
        seen = np.zeros_like(out)
        for k, f in enumerate(flights):
            rows = slice(s.first[f], s.stop[f])
            time = (s.tau[rows] + s.half[f]) / rate
            true = flown.at(k, time) + np.outer(time**2, [0.0, lighter / 2])
            seen[rows] = nearer(true, s, starts, s.flight[rows], s.tau[rows])
        seen = pictured(seen, s.view, values)
        mine = s.recording[s.flight] == r
        out[mine] = seen[mine]

    def begins(self, starts: np.ndarray, values: dict[str, float]) -> np.ndarray:
        """(F, 5): place, velocity and v_y of each flight's seed at its first row."""
        model = self.fit.problem.model
        push = pushed(model, starts, values)
        aside = np.sqrt(np.maximum(starts[:, 4:5], 0.0))
        return np.hstack(
            [
                places(model.begins, starts, push),
                velocities(model.begins, starts, push),
                aside,
            ]
        )

    def compared(self, old: np.ndarray, new: np.ndarray):
        """One row a recording: root mean square distance [mm] from the recorded
        places."""
        s = self.session
        for r, name in enumerate(s.names):
            mine = s.recording[s.flight] == r
            if not mine.any():
                continue  # none of its flights could be used
            before, after = (
                1e3 * float(np.sqrt(((s.places - seen)[mine] ** 2).mean()))
                for seen in (old, new)
            )
            yield Comparison(name, tr("place in flight"), "mm", before, after, "track")


def left_out(of: Fit, r: int) -> np.ndarray:
    """Globals as the recordings other than r have them."""
    flown = sorted(
        set(of.problem.model.session.recording.tolist())
    )  # recordings with flights
    k = flown.index(r) if r in flown else len(flown)
    others = of.reduced[:k] + of.reduced[k + 1 :]
    return ridge(*stacked(others), of.prior_sd)[0] if others else of.values


def started(of: Fit, values: np.ndarray) -> np.ndarray:
    """The starts (F, 7) that fit best with these globals."""
    starts, at = of.starts, of.values
    for _ in range(MAX_ITERATIONS):
        starts, at = starts + of.problem.reduce(starts, at)[1](values - at), values
    return starts


def laws_of(
    description: dict, air: Air, more: dict[str, float], speed: float
) -> dict[str, dict]:
    """The DEM's laws for a flight; its C_d(Re) and ours agree at `speed` [m/s]."""

    def over(share: float, at_m_s: float) -> float:
        at, here = (
            float(drag_shape(v, air.reynolds_per_speed)) * v for v in (at_m_s, speed)
        )
        return share * here / at

    total = over(air.share, REFERENCE_SPEED_M_S) + over(
        more.get("share", 0.0), more.get("at_m_s", REFERENCE_SPEED_M_S)
    )
    laws = {
        "drag": (
            drag_factor(description, max(total, 0.0), speed)
            | {"wind_x": more.get("wind_x", 0.0)}
        )
    }
    if more.get("lift", 0.0):
        density = description.get("air", {}).get("density_kg_m3") or 1.2
        laws["magnus"] = {
            "air_density": density,
            "lift": float(np.clip(more["lift"], -5, 5)),
        }
    return laws
