"""Several sessions as one problem: physics is common to all, each session has a camera of its own.

The globals of a session's camera (effects and nuisances of the picture) stand once for every session; of an effect all of them
are freed together, and reported is that of the session that shows it most.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from calibrate.diagnose.drop.model import LAWS, build
from calibrate.diagnose.drop.nameless import LENS, pushes_of
from calibrate.diagnose.drop.noise_of_track import TrackNoise, estimate_noise
from calibrate.diagnose.drop.problem import problem_of
from calibrate.diagnose.drop.retouch import retouched
from calibrate.diagnose.drop.session import assemble
from calibrate.diagnose.drop.windows import windows_of
from calibrate.diagnose.linear import stacked
from calibrate.diagnose.locate import Windows
from calibrate.diagnose.problem import Fit, Problem, fit
from calibrate.diagnose.scores import score


@dataclass(frozen=True, eq=False)
class Sitting:
    """One session: its tracks, their noise, the problem that they make."""

    tracks: tuple
    noise: TrackNoise
    problem: Problem


def sittings_of(tracks) -> tuple[tuple[Sitting, ...], tuple[str, ...]]:
    """One a session, and notes on those that are of no use; ValueError where none is."""
    found, notes = [], []
    for session in dict.fromkeys(t.session for t in tracks):
        own = tuple(t for t in tracks if t.session == session)
        try:
            seen, own, noise, twice = _assembled(own)
        except ValueError as error:
            notes.append(f"session {session!r} left out: {error}" if session else str(error))
            continue
        notes += [*seen.notes, *twice]
        found.append(Sitting(own, noise, problem_of(build(seen), noise)))
    if not found:
        raise ValueError("; ".join(notes) or "no drop was filmed")
    return tuple(found), tuple(notes)


def _assembled(own: tuple):
    """A session with its noise, without what lies between two touches."""
    seen = assemble(own)
    noise = estimate_noise(seen)
    cut, notes = retouched(own, seen, noise)
    if not notes:
        return seen, own, noise, ()
    seen = assemble(cut)
    return seen, cut, estimate_noise(seen), notes


@dataclass(frozen=True, eq=False)
class Joint:
    """parts: the sessions' problems; spots: which of the joint globals each part's globals are; cuts: each part's locals."""

    parts: tuple[Problem, ...]
    spots: tuple[np.ndarray, ...]
    cuts: np.ndarray


def joint_problem(parts: tuple[Problem, ...]) -> Problem:
    """The problem of all sessions; of one session its own."""
    if len(parts) == 1:
        return replace(parts[0], nameless=nameless)
    order = _by_strength(parts)
    names: list[str] = []
    effects, known, spots = dict(parts[0].effects), {}, []
    for k, part in enumerate(parts):
        spot = []
        for n in part.names:
            rank = order[n].index(k) if _of_camera(n) else 0
            own = n if rank == 0 else f"{n}@{k + 1}"
            if own not in names:
                names.append(own)
                known[own] = part.known_sd.get(n, 0.0)
            if own != n and n in effects:
                effects[own] = replace(effects[n], name=own, group=effects[n].group or n)
            spot.append(names.index(own))
        spots.append(np.array(spot))
    cuts = np.cumsum([0, *(len(p.starts) for p in parts)])
    joint = Joint(parts, tuple(spots), cuts)
    return Problem(
        "drop", sum((p.recordings for p in parts), ()), effects, tuple(names), known, np.vstack([p.starts for p in parts]),
        partial(reduce, joint, len(names)), sum(p.freedom for p in parts), max(p.level_sd for p in parts), joint,
        max(p.turns for p in parts), nameless=nameless,
    )  # fmt: skip


def _of_camera(name: str) -> bool:
    return LAWS[name].picture is not None or LAWS[name].clock is not None


def _by_strength(parts: tuple[Problem, ...]) -> dict[str, list[int]]:
    """Sessions in the order in which they show each camera effect."""
    shown = [dict(zip((s := score(fit(p))).names, np.abs(s.z), strict=True)) for p in parts]

    def ranked(name: str) -> list[int]:
        return sorted((k for k, p in enumerate(parts) if name in p.names), key=lambda k: -shown[k].get(name, 0.0))

    return {name: ranked(name) for name in LAWS}


def reduce(joint: Joint, count: int, starts: np.ndarray, values: np.ndarray, extra=None):
    """See Problem.reduce; extra: (part, pushes) pairs, whose columns stand one part after the other."""
    pushes = extra or [None] * len(joint.parts)
    more = [0 if p is None else len(p) for p in pushes]
    out, back = [], []
    for k, (part, spot) in enumerate(zip(joint.parts, joint.spots, strict=True)):
        made, change = part.reduce(starts[joint.cuts[k] : joint.cuts[k + 1]], values[spot], pushes[k])
        for r in made:
            a = np.zeros((len(r.b), count + sum(more)))
            a[:, spot] = r.a[:, : len(spot)]
            first = count + sum(more[:k])
            a[:, first : first + more[k]] = r.a[:, len(spot) :]
            out.append(replace(r, a=a))
        back.append((spot, change))
    return tuple(out), lambda theta: np.vstack([change(theta[spot]) for spot, change in back])


def parts_of(whole: Fit) -> tuple[Fit, ...]:
    """The fit of each session in a joint fit."""
    if not isinstance(whole.problem.model, Joint):
        return (whole,)
    joint, out, first = whole.problem.model, [], 0
    for k, (part, spot) in enumerate(zip(joint.parts, joint.spots, strict=True)):
        reduced = whole.reduced[first : first + len(part.recordings)]
        first += len(part.recordings)
        out.append(Fit(
            part, whole.prior_sd[spot], whole.values[spot], whole.covariance[np.ix_(spot, spot)],
            whole.starts[joint.cuts[k] : joint.cuts[k + 1]], whole.chi2, reduced,
        ))  # fmt: skip
    return tuple(out)


def nameless(at: Fit) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """See Problem.nameless; a force is common to all sessions."""
    pushes = [pushes_of(part) for part in parts_of(at)]
    reduced, _ = at.problem.reduce(at.starts, at.values, pushes if len(pushes) > 1 else pushes[0])
    a, b = stacked(reduced)
    a, columns = np.split(a, [len(at.names)], axis=1)
    common = columns.reshape(len(b), len(pushes), -1).sum(axis=1)
    lenses = a[:, [n.startswith(LENS) for n in at.names]]
    return a, b, {"flight": common[:, :-1], "measurement": np.hstack([lenses, common[:, -1:]])}


def all_windows(base: Fit) -> Windows:
    """The windows of every session."""
    found = [windows_of(part) for part in parts_of(base)]
    if len(found) == 1:
        return found[0]
    return Windows([w.extra for w in found], sum((w.where for w in found), ()))
