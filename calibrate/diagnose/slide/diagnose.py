"""Slides, from recordings to a finding."""

import numpy as np

from calibrate.diagnose.finding import Finding, finding_of
from calibrate.diagnose.locate import locate
from calibrate.diagnose.name import name
from calibrate.diagnose.problem import Fit, fit
from calibrate.diagnose.slide.model import Model, candidates
from calibrate.diagnose.slide.problem import Prepared, begin, prepare, problem_of
from calibrate.diagnose.slide.session import assemble
from calibrate.diagnose.slide.windows import windows_of


def diagnose_slide(recordings, rng: np.random.Generator) -> Finding:
    """Finding of one pair's slides (calibrate.twin.slides.SeenSlide); ValueError where none can be used."""
    prepared = prepare(assemble(recordings))
    base = fitted(prepared, Model(prepared.session, 0.0, candidates(prepared.session)))
    where = locate(base, windows_of(base), rng)
    return finding_of(base, where, name(base, where, rng), notes=prepared.session.notes)


def fitted(prepared: Prepared, model: Model) -> Fit:
    """The baseline, fitted."""
    model, starts = begin(prepared, model)
    return fit(problem_of(prepared, model, starts))
