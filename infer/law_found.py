"""What is unlisted, as a law that was found, in the place of what it was."""

import math
from dataclasses import replace

from benchtwin.infer.evidence import Kind
from benchtwin.infer.explanation import Explanation, Posterior
from benchtwin.infer.posterior import PRIOR, explanation_of
from benchtwin.infer.power_law import NAMES, ROUNDS, Law, Term, fitted
from benchtwin.infer.task import DiagnosisTask
from benchtwin.infer.verdict import Verdict, estimate


def lawful(
    posterior: Posterior, verdict: Verdict, chosen: Explanation, task: DiagnosisTask
) -> tuple[Explanation, Law, Verdict]:
    """What is unlisted as a law, its terms, and the verdict: of listed effects beside
    it those are left that are needed beside the law as well."""
    if not chosen.listed:
        return *with_law(chosen, task), verdict
    alone, own = with_law(posterior.base, task)
    if not own or _ln_weight(alone) < _ln_weight(chosen):
        model, terms = with_law(chosen, task)
        if not own or _ln_weight(alone) < _ln_weight(model):
            return model, terms, verdict
    strange = posterior.unlisted()
    unlisted = sum(p for names, p in posterior.by_set() if strange & set(names))
    return alone, own, Verdict("unknown", (), unlisted)


def _ln_weight(e: Explanation) -> float:
    """ln of evidence and prior odds of something unlisted beside these effects."""
    beside = sum(n not in NAMES for n in e.names if n in e.listed)
    candidates = sum(c.kind is not Kind.UNLISTED for c in e.table.components.values())
    odds = PRIOR[min(beside, 2), 1] / math.comb(candidates, min(beside, 2))
    return e.table.ln_evidence(e.names)[0] + math.log(odds)


def with_law(chosen: Explanation, task: DiagnosisTask) -> tuple[Explanation, Law]:
    """The explanation with a law in the place of what is unlisted, and its terms with
    the sizes that it gives; what a model cannot follow stays as it was found."""
    k, found = chosen.alternative, chosen.fit
    free = tuple(n for n in chosen.listed if n in found.problem.effects)
    terms: tuple[Term, ...] = ()
    able: tuple[Term, ...] = ()
    for _ in range(ROUNDS):
        before = [t.in_the_twin for t in able]
        law = task.law(found)
        if law is None:
            return chosen, None
        terms = law
        able = tuple(t for t in terms if t.in_the_twin)
        if not terms or terms[0] not in able:
            return chosen, terms
        if before == [t.in_the_twin for t in able]:
            break
        found = fitted(chosen.fit, free, able)
    names = tuple(t.effect.name for t in able)
    noise = chosen.power, chosen.table.level_sd
    windows = task.windows(found)
    own = task.alternatives[k]
    model = explanation_of(found, (*chosen.listed, *names), k, own, windows, noise)
    sizes = {n: estimate(model, n) for n in names}
    found_sizes = ((t, sizes.get(t.effect.name, (t.size, t.sd))) for t in terms)
    return model, tuple(replace(t, size=a, sd=sd) for t, (a, sd) in found_sizes)
