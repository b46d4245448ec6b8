"""Findings in words: the verdict in a sentence, as printed and as a report opens."""

import importlib
import math
import traceback
from pathlib import Path

from benchtwin.infer.effect import Effect
from benchtwin.infer.finding import Finding
from benchtwin.infer.verdict import MATTERS_SDS, NAME_SHARE

WHERE = {
    "flight": "in flight",
    "impact": "in the impacts",
    "measurement": "in how it was measured",
    "onset": "at the onset",
    "sliding": "while it slides",
    "incline": "on the incline",
    "run-out": "in the run-out",
    "crest": "at the crest",
    "middle": "in the middle of the slope",
    "toe": "at the toe",
}
PLURALS = {"drop": "drops", "slide": "slides", "roll": "rolls", "pile": "heaps"}
UNITS = {
    "pct": "%",
    "deg": "°",
    "c": "°C",
    "k": "K",
    "days": "day",
}  # at the end of a condition's name
ONLY_WHEN = {
    "order": "the order of the recordings",
    "session": "the session",
}  # drifts without a stated cause


def effect_named(rig: str, name: str) -> Effect | None:
    """A listed effect by name, None for others."""
    if rig not in PLURALS:
        return None
    return importlib.import_module(f"benchtwin.rigs.{rig}.effects").EFFECTS.get(name)


def fault_in_words(error: Exception) -> str:
    """An error of our own, and where it was raised."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{error!r} in {Path(place.filename).name}:{place.lineno}"


def followed_condition(name: str) -> tuple[str, str] | None:
    """The contact parameter, in words, and the condition that it follows; None of other
    effects.

    >>> followed_condition("static_friction-follows-moisture_pct")
    ('static friction', 'moisture_pct')
    """
    parameter, found, condition = name.partition("-follows-")
    return (parameter.replace("_", " "), condition) if found else None


def verdict_in_words(finding: Finding) -> str:
    """What is missing, how much of it, and what ignoring it does to the contact
    parameters."""
    if finding.verdict == "none":
        count = len(finding.recordings)
        these = "the recording shows" if count == 1 else f"{count} recordings show"
        return (
            f"nothing is missing that {these} ({percent(finding.p_verdict)}; noise"
            f" alone: {chance(finding.p_global)})"
        )
    if finding.verdict == "name":
        told = "; ".join(named(n, finding) for n in finding.names)
    else:
        told = _class(finding) if finding.verdict == "class" else _unknown(finding)
    if not finding.matters:
        return f"found, but it moves nothing that matters: {told}"
    return "; ".join([told, *_moved(finding)])


def _class(finding: Finding) -> str:
    sure = [n for n in finding.names if _probability(n, finding) >= NAME_SHARE]
    rest = [n for n in finding.names if n not in sure]
    if sure:
        beside = " or ".join(_short(n, finding) for n in rest)
        return "; ".join(
            [
                *(named(n, finding) for n in sure),
                *([f"beside it, not settled: {beside}"] if beside else []),
            ]
        )
    if len(rest) == 1:
        return (
            f"something is missing {place(finding)}; the likely reason, not settled:"
            f" {named(rest[0], finding)}"
        )
    some = " or ".join(f"{n} ({percent(_probability(n, finding))})" for n in rest)
    return (
        f"something is missing {place(finding)}: {some}; these recordings do not tell"
        " which"
    )


def _unknown(finding: Finding) -> str:
    known = [named(n, finding) for n in finding.names]
    what = (
        f"something{' else' if known else ''} is missing {place(finding)} that no known"
        " effect explains"
    )
    law = finding.law
    likeliest = next((names for names, _ in finding.explanations if names), ())
    drifts = (followed_condition(n) for n in likeliest if n not in finding.effects)
    if not law and (drift := next(filter(None, drifts), None)):
        when = ONLY_WHEN.get(drift[1], drift[1])
        law = f"{drift[0]} changes with {when}, and nothing stated says why"
    return "; ".join(
        [*known, f"{what} ({percent(finding.p_verdict)})" + (f": {law}" if law else "")]
    )


def _moved(finding: Finding) -> list[str]:
    """ "left out, restitution reads 0.8 % too low, 3 of its sds"."""
    out = []
    for name, moved in finding.contact.items():
        if abs(moved.shift_sds) < MATTERS_SDS:
            continue
        off = moved.explained.value - moved.nothing_missing.value
        share = (
            100 * abs(off / moved.explained.value)
            if moved.explained.value
            else math.inf
        )
        how = f"{brief(share)} % too {'low' if off > 0 else 'high'}"
        out.append(
            f"{name.replace('_', ' ')} reads {how}, {brief(abs(moved.shift_sds))} of"
            " its sds"
        )
    return [f"left out, {', and '.join(out)}"] if out else []


def named(name: str, finding: Finding) -> str:
    """ "air drag is missing (99.7 %): 0.018 ± 0.002 of the weight at 2 m/s" (95 %)."""
    if found := followed_condition(name):
        return _following(name, *found, finding)
    told, effect = finding.effects.get(name), effect_named(finding.rig, name)
    unit = effect.wording[1] if effect else ""
    if told is None or not unit or not math.isfinite(told.size.value):
        return _short(name, finding)
    return (
        f"{_short(name, finding)}:"
        f" {plus_minus(told.size)}{'' if unit.startswith('°') else ' '}{unit}"
    )


def _following(name: str, parameter: str, condition: str, finding: Finding) -> str:
    """ "static friction falls by 0.0080 ± 0.0012 per % moisture (moisture_pct), in all
    10 slides (99.7 %)"; of words each level."""
    told, count = finding.effects.get(name), len(finding.recordings)
    over = (
        f"in all {count} {PLURALS[finding.rig]}"
        f" ({percent(_probability(name, finding))})"
    )
    if told and told.levels:
        each = ", ".join(
            f"{level} {'+' if size.value > 0 else ''}{plus_minus(size)}"
            for level, size in told.levels.items()
        )
        return (
            f"{parameter} follows {condition}, {over}; beside the mean of all: {each}"
        )
    if told is None or told.unit == "1" or not math.isfinite(told.size.value):
        return f"{parameter} follows {condition}, {over}"
    what, _, unit = condition.rpartition("_")
    of = (
        f"{UNITS.get(unit, unit)} {what.replace('_', ' ')} ({condition})"
        if what
        else f"unit of {condition}"
    )
    size = plus_minus(told.size).lstrip("−")
    return (
        f"{parameter} {'falls' if told.size.value < 0 else 'rises'} by {size} per {of},"
        f" {over}"
    )


def missing(name: str, rig: str) -> str:
    """What one effect is in a reader's words."""
    if found := followed_condition(name):
        return f"{found[0]} follows {found[1]}"
    effect = effect_named(rig, name)
    return effect.wording[0] if effect and effect.wording[0] else name


def _short(name: str, finding: Finding) -> str:
    return f"{missing(name, finding.rig)} ({percent(_probability(name, finding))})"


def _probability(name: str, finding: Finding) -> float:
    return (
        finding.effects[name].probability
        if name in finding.effects
        else finding.p_verdict
    )


def plus_minus(size) -> str:
    """Value ± half its 95 % interval (value, low95, high95), with two digits of that.

    >>> from benchtwin.infer.finding import Parameter
    >>> plus_minus(Parameter("1", 0.01834, 0.0163, 0.0203))
    '0.0183 ± 0.0020'
    """
    half = (size.high95 - size.low95) / 2
    if not (math.isfinite(half) and half > 0):
        return f"{size.value:.3g}"
    digits = max(0, min(8, 1 - math.floor(math.log10(half))))
    return f"{size.value:.{digits}f} ± {half:.{digits}f}".replace("-", "−")


def place(finding: Finding) -> str:
    """The most likely sector, in words."""
    best = next(
        (s for s in finding.sectors if math.isfinite(s.explained) and s.explained > 0),
        None,
    )
    return WHERE.get(best.name, f"in {best.name}") if best else "somewhere"


def chance(p: float) -> str:
    """A probability of noise alone, "p < 0.0001" where it is smaller."""
    return "p < 0.0001" if p < 1e-4 else f"p = {p:.2g}"


def percent(p: float) -> str:
    """A probability in per cent, with a digit more near 0 and 1.

    >>> percent(0.9971), percent(0.83), percent(0.99999), percent(0.0004)
    ('99.7 %', '83 %', '> 99.9 %', '< 0.1 %')
    """
    if not 0.001 <= p <= 0.999:
        return "> 99.9 %" if p > 0.5 else "< 0.1 %"
    return f"{100 * p:.0f} %" if 0.01 <= p < 0.99 else f"{100 * p:.1f} %"


def brief(x: float) -> str:
    """Two digits, never as a power of ten."""
    return f"{x:.0f}" if x >= 10 else f"{x:.2g}"


def lines(diagnosis) -> list[str]:
    """What the command prints: a line a rig, what is missing first, what to record
    next, what could not be used."""
    out = []
    for rig, finding in sorted(
        diagnosis.findings.items(), key=lambda entry: entry[1].verdict == "none"
    ):
        out.append(f"{rig}: {verdict_in_words(finding)}")
        if finding.matters and finding.next_record:
            out.append(f"  to settle it, record: {finding.next_record}")
        if finding.matters and rig in diagnosis.twins:
            out.append(f"  {diagnosis.twins[rig].in_words()}")
    out += [f"{rig}: not diagnosed: {why}" for rig, why in diagnosis.refused.items()]
    out += [f"{name}: {why}" for name, _, why in diagnosis.trouble]
    return [*out, *diagnosis.notes]
