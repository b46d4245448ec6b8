"""What the evidence makes of the candidates: a name, a class, or unknown.

Rules. Alarm: global p < .005. Definite name: ln BF ≥ 5 over the baseline and ≥ 3 over every rival,
predictive gain > 2 standard errors, the same sign in ≥ 80 % of the recordings, parameter inside its physical range, and nothing
left that the saturated model would still explain (p > .01). Else a class with the recording that best separates it; else unknown.
"""

from dataclasses import dataclass

ALPHA = 0.005
LN_BF_BASELINE, LN_BF_RIVAL = 5.0, 3.0
SAME_SIGN = 0.8
SATURATED_P = 0.01
NIL = 1.0  # sd within which a candidate has nothing of an effect: it is no member of a class by that
MORE = "the same again at half and at twice what was set (height, tilt rate, length), and more recordings of each"


@dataclass(frozen=True)
class Candidate:
    """One set of effects fitted together.

    value, sd: of each one's reported parameter; ln_bayes: over the baseline; gain, gain_se: mean predictive gain a recording (NaN
    for one recording), over a baseline that has learnt from the others or, where that shows nothing, one that has not; same_sign:
    share of the recordings that see it; left_p: of what the saturated model still explains;
    flaws: which rules it breaks, in words.
    """

    names: tuple[str, ...]
    value: tuple[float, ...]
    sd: tuple[float, ...]
    ln_bayes: float
    gain: float
    gain_se: float
    same_sign: float
    left_p: float
    flaws: tuple[str, ...]


@dataclass(frozen=True)
class Verdict:
    """verdict: none | name | class | unknown; names: of the effects (class: its members); candidates: all that was fitted, best
    first; p_global of the alarm; next_record: what would separate or settle it, None where nothing is open."""

    verdict: str
    names: tuple[str, ...]
    p_global: float
    candidates: tuple[Candidate, ...]
    ln_bayes_runner_up: float
    next_record: str | None


def possible(candidate: Candidate) -> bool:
    return not any("physical range" in flaw for flaw in candidate.flaws)


def flaws_of(effects, names, values, bayes, shared, same, left) -> tuple[str, ...]:
    """The rules that a candidate breaks by itself; rivals are `decide`'s business."""
    flaws = [f"{n} = {v:.3g} {effects[n].unit} is outside its physical range" for n, v in zip(names, values, strict=True)
             if not effects[n].low <= v <= effects[n].high]  # fmt: skip
    if bayes < LN_BF_BASELINE:
        flaws.append(f"ln Bayes factor {bayes:.1f} over the baseline is below {LN_BF_BASELINE:g}")
    if not shared:
        flaws.append("it does not predict left-out recordings better by 2 standard errors")
    if same < SAME_SIGN:
        flaws.append(f"its sign is the same in only {100 * same:.0f} % of the recordings")
    if left <= SATURATED_P:
        flaws.append(f"something else is left (p = {left:.1g})")
    return tuple(flaws)


def _had(candidate: Candidate) -> tuple[str, ...]:
    """The effects of which it has anything; all of them where that is none."""
    had = tuple(n for n, v, sd in zip(candidate.names, candidate.value, candidate.sd, strict=True) if abs(v) > NIL * sd)
    return had or candidate.names


def decide(effects, p: float, chosen: tuple[str, ...], candidates: tuple[Candidate, ...], left: float) -> Verdict:
    ranked = tuple(sorted(candidates, key=lambda c: -c.ln_bayes))
    if not chosen:
        return Verdict("unknown", (), p, ranked, float("nan"), MORE)
    best = next(c for c in ranked if c.names == chosen)
    rivals = [c for c in ranked if c is not best and len(c.names) <= len(best.names) and possible(c)]
    runner_up = best.ln_bayes - max((c.ln_bayes for c in rivals), default=0.0)
    close = [c for c in rivals if c.ln_bayes > best.ln_bayes - LN_BF_RIVAL]
    members = tuple(dict.fromkeys(n for c in (best, *close) for n in _had(c)))
    advice = next((effects[n].separating for n in members if effects[n].separating), None)
    left_over = left < ALPHA or any(flaw.startswith("something else") for flaw in best.flaws)  # it would be an alarm of its own
    beyond = any(c.ln_bayes > best.ln_bayes + LN_BF_RIVAL for c in ranked if len(c.names) <= len(best.names) and not possible(c))
    if left_over or beyond or not possible(best):
        return Verdict("unknown", (), p, ranked, runner_up, advice)
    if close:
        return Verdict("class", members, p, ranked, runner_up, advice)
    if best.flaws:
        return Verdict("class", best.names, p, ranked, runner_up, advice or "more recordings of the same")
    return Verdict("name", best.names, p, ranked, runner_up, None)
