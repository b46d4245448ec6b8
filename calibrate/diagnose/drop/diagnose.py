"""Drops, from tracks to a finding: flight and picture."""

import numpy as np

from calibrate.diagnose.drop.curves import curves_of
from calibrate.diagnose.drop.model import build
from calibrate.diagnose.drop.problem import problem_of
from calibrate.diagnose.drop.session import assemble
from calibrate.diagnose.drop.windows import windows_of
from calibrate.diagnose.finding import Finding, finding_of
from calibrate.diagnose.locate import locate
from calibrate.diagnose.name import name
from calibrate.diagnose.problem import fit


def diagnose_flights(tracks, rng: np.random.Generator) -> Finding:
    """Finding of one session's tracks (calibrate.twin.tracks.SeenTrack); ValueError where no flight can be used."""
    session = assemble(tracks)
    base = fit(problem_of(build(session)))
    where = locate(base, windows_of(base), rng)
    return finding_of(base, where, name(base, where, rng), notes=session.notes, draw=curves_of)
