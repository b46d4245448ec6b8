"""Findings in words: the verdict in a sentence, as printed and as a report opens."""

import math
import traceback
from pathlib import Path

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import with_interval, with_sd
from benchtwin.bench.rigs import RIGS
from benchtwin.infer.effect import Effect
from benchtwin.infer.explanation import UNSHAPED
from benchtwin.infer.finding import Finding, StatedKey
from benchtwin.infer.follow import Follow
from benchtwin.infer.verdict import MATTERS_SDS, Interval

SURE_OF_NOTHING = 0.8  # from which it is said in green
LEAST_SHARE = 0.1  # of an explanation beside the verdict that is worth a word

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
UNITS = {
    "pct": "%",
    "deg": "°",
    "c": "°C",
    "k": "K",
    "days": "day",
}  # at the end of a condition's name
AXES = {
    "t_s": ("time", "s"),
    "z_mm": ("height", "mm"),
    "v_m_s": ("speed", "m/s"),
    "x_mm": ("place", "mm"),
    "x_share": ("share of the flank from its crest", ""),
    "n_bounce": ("bounce number", ""),
    "tilt_deg": ("tilt", "°"),
    "travel_mm": ("travel", "mm"),
    "phase_deg": ("phase", "°"),
}
ONLY_WHEN = {
    "order": "the order of the recordings",
    "session": "the session",
}  # drifts without a stated cause


def effect_named(rig: str, name: str) -> Effect | None:
    """A listed effect by name, None for others."""
    if rig not in RIGS or not RIGS[rig].effects:
        return None
    return RIGS[rig].part("effects").get(name)


def effect_of(finding: Finding, name: str) -> Effect | None:
    """A listed effect, or a law that was found."""
    return finding.laws.get(name) or effect_named(finding.rig, name)


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
    """The one sentence of a finding, wherever it is shown: what it does to a contact
    parameter, what was found, how probable exactly that is, how large it is, what else
    is possible, and how often noise alone would do as much."""
    told = {"none": _none, "name": _name, "class": _class, "unknown": _unknown}
    parts = [told[finding.verdict](finding), *_path(finding)]
    parts += _else_possible(finding)
    return "; ".join(
        [*parts, tr("noise alone would do this in {}", odds(finding.p_global))]
    )


def _path(finding: Finding) -> list[str]:
    """ "it moves a path by 0.031 mm at most", beside what each recording's own start
    and friction take up: of what does not matter, how little it is."""
    moved = finding.moves_mm
    if finding.matters or not math.isfinite(moved):
        return []
    return [tr("it moves a path by {} mm at most", brief(moved))]


def tone(finding: Finding) -> str:
    """How a verdict is coloured: "sure" that nothing is missing, "open" where nothing
    was shown to be, "quiet" where what is moves nothing, else the verdict."""
    if finding.verdict == "none":
        return "sure" if finding.p_verdict >= SURE_OF_NOTHING else "open"
    return finding.verdict if finding.matters else "quiet"


def _none(finding: Finding) -> str:
    count = len(finding.recordings)
    these = tr("the recording") if count == 1 else tr("the {} recordings", count)
    return tr(
        "nothing was shown to be missing in {} ({} that nothing is)",
        these,
        percent(finding.p_verdict),
    )


def _name(finding: Finding) -> str:
    what = tr(" and ").join(_with_slope(n, finding) for n in finding.names)
    sizes = "; ".join(filter(None, (_size(n, finding) for n in finding.names)))
    holding = sum(
        p
        for (names, _), p in statements(finding).items()
        if set(finding.names) <= set(names)
    )
    alone = percent(finding.p_verdict)
    found = tr("{} ({}), and nothing else ({})", what, percent(holding), alone)
    return _because(finding, f"{found}: {sizes}" if sizes else found)


def _class(finding: Finding) -> str:
    among = [
        (names, p)
        for (names, strange), p in statements(finding).items()
        if names and not strange and set(names) <= set(finding.names)
    ]
    options = [one for one in among if one[1] >= LEAST_SHARE] or among[:1]
    if len(options) == 1:
        what = tr("{}, not for certain", _set(*options[0], finding))
    else:
        what = tr(
            "{}, which these recordings do not tell apart ({} together)",
            tr(" or ").join(_set(*one, finding) for one in options),
            percent(finding.p_verdict),
        )
    return _because(finding, what)


def _unknown(finding: Finding) -> str:
    known = tr(" and ").join(_with_slope(n, finding) for n in finding.names)
    what = tr(
        "something is missing {} that no known effect explains ({})",
        place(finding),
        percent(finding.p_verdict),
    )
    law = finding.law
    drift = next((f for f in finding.follows if f.unlisted), None)
    if not law and drift:
        law = tr("{}, and nothing stated says why", follow_in_words(drift, finding))
    found = tr("{}, and beside it {}", known, what) if known else what
    if finding.senseless:
        where = tr(", most at {}", at) if (at := window(finding)) else ""
        found = tr("{}, of no shape that makes sense{}", found, where)
    return _because(finding, f"{found}: {law}" if law else found)


def _set(names: tuple[str, ...], p: float, finding: Finding) -> str:
    what = tr(" and ").join(_with_slope(n, finding) for n in names)
    return f"{what} ({percent(p)})"


def statements(finding: Finding) -> dict[tuple[tuple[str, ...], bool], float]:
    """Probability of exactly these listed effects, with or without something unlisted,
    the greatest first, those that are alike in per cent by name; all of them add up to
    1."""
    out: dict[tuple[tuple[str, ...], bool], float] = {}
    for names, p in finding.explanations:
        listed = tuple(n for n in names if n not in finding.unlisted)
        key = listed, len(listed) < len(names)
        out[key] = out.get(key, 0.0) + p
    return dict(sorted(out.items(), key=lambda entry: (-round(entry[1], 2), entry[0])))


def _else_possible(finding: Finding) -> list[str]:
    """ "also possible: the scale is wrong (23 %)": what the verdict leaves out."""

    def said(names: tuple[str, ...], strange: bool) -> bool:
        if finding.verdict == "class":
            return bool(names) and not strange and set(names) <= set(finding.names)
        if finding.verdict == "unknown":
            return strange and set(names) >= set(finding.names)
        return not strange and set(names) == set(finding.names)

    out = []
    for (names, strange), p in statements(finding).items():
        if p < LEAST_SHARE or said(names, strange):
            continue
        parts = [missing(n, finding.rig) for n in names]
        parts += [missing(UNSHAPED, finding.rig)] if strange else []
        what = tr(" and ").join(parts) or tr("nothing is missing")
        out.append(f"{what} ({percent(p)})")
    return [tr("also possible: {}", ", ".join(out))] if out else []


def _because(finding: Finding, found: str) -> str:
    """What it does to the contact parameters, then what was found."""
    if not finding.matters:
        return tr("found, but it moves nothing that matters: {}", found)
    moved = _moved(finding)
    return tr("{} because {}", moved, found) if moved else found


def _moved(finding: Finding) -> str:
    """ "restitution reads 0.8 % too low (3 of its sds)"."""
    out = []
    for name, moved in finding.contact.items():
        if abs(moved.shift_sds) < MATTERS_SDS:
            continue
        off = moved.explained.value - moved.nothing_missing.value
        if moved.explained.value:
            share = 100 * abs(off / moved.explained.value)
        else:
            share = math.inf
        how = (
            tr("{} % too low", brief(share))
            if off > 0
            else tr("{} % too high", brief(share))
        )
        out.append(
            tr(
                "{} reads {} ({} of its sds)",
                name.removesuffix("_deg").replace("_", " "),
                how,
                brief(abs(moved.shift_sds)),
            )
        )
    return tr(" and ").join(out)


def _with_slope(name: str, finding: Finding) -> str:
    """`missing`, of a condition with by how much."""
    follow = next((f for f in finding.follows if f.name == name), None)
    if follow is None or follow.unlisted:
        return missing(name, finding.rig)
    return follow_in_words(follow, finding)


def _size(name: str, finding: Finding) -> str:
    """ "0.018 of the weight at 2 m/s (95 %: 0.016 to 0.020)"; of several effects,
    which, and the key that states it."""
    told, effect = finding.effects.get(name), effect_of(finding, name)
    unit = tr(effect.wording[1]) if effect and effect.wording[1] else ""
    if told is None or not unit or not math.isfinite(told.size.value):
        return ""
    key = finding.keys.get(name)
    held = key.held if key else 0.0
    # a further parameter tells that it is
    if told.size.low95 < held < told.size.high95:
        return ""
    which = f"{name} " if len(finding.names) > 1 else ""
    space = "" if unit.startswith("°") else " "
    stated = _stated(key) if key else ""
    value, ends = _value(told.size), _ends(told.size)
    return f"{which}{value}{space}{unit} ({ends}){stated}"


def _stated(key: StatedKey) -> str:
    """ ", where 0.2 is stated; [roll] slope_deg = -0.2 states it"; of several that are
    stated, what is to stand in the place of each."""
    # minus signs as TOML has them
    whole = [with_sd(one, key.sd)[0].replace("−", "-") for one in key.should_be]
    if len(whole) > 1:
        each = (tr("{} for {:g}", w, s) for w, s in zip(whole, key.stated, strict=True))
        return tr("; {} = {} state it", key.key, ", ".join(each))
    where = tr(", where {:g} is stated", key.stated[0]) if key.held else ""
    return tr("{}; {} = {} states it", where, key.key, whole[0])


def follow_in_words(follow: Follow, finding: Finding) -> str:
    """ "static friction falls by 0.00800 (95 %: 0.00680 to 0.00920) per % moisture
    (moisture_pct)"; of a curve its ends, of words each level."""
    parameter, condition = follow.parameter.replace("_", " "), follow.condition
    ends = [point.size.value for point in follow.curve]
    up = ends[-1] > ends[0]
    if follow.levels:
        each = ", ".join(
            f"{follow.levels[int(p.at)]}"
            f" {'+' if p.size.value > 0 else ''}{_value(p.size)} ({_ends(p.size)})"
            for p in follow.curve
        )
        return tr(
            "{} follows {} (beside the mean of all: {})", parameter, condition, each
        )
    if follow.shape == "line" and not follow.unlisted:
        what, _, unit = condition.rpartition("_")
        if what:
            of = f"{UNITS.get(unit, unit)} {what.replace('_', ' ')} ({condition})"
        else:
            of = tr("unit of {}", condition)
        slope = follow.slope if up else negative(follow.slope)
        size = f"{_value(slope)} ({_ends(slope)})"
        return tr(
            "{} {} by {} per {}",
            parameter,
            tr("rises") if up else tr("falls"),
            size,
            of,
        )
    told = finding.contact.get(follow.parameter)
    level = told.explained.value if told else 0.0
    digits = _value(follow.curve[0].size).partition(".")[2]

    def at(k: int) -> str:
        value = f"{level + ends[k]:.{len(digits)}f}".replace("-", "−")
        if condition == "order":
            return tr("{} at the {}", value, tr("last") if k else tr("first"))
        return tr("{} at {:g}", value, follow.curve[k].at)

    beside = "" if told else tr(" beside the mean")
    with_what = tr(ONLY_WHEN.get(condition, condition))
    if follow.shape in ("highest", "lowest"):
        end = ends.index(max(ends) if follow.shape == "highest" else min(ends))
        place = follow.curve[end]
        value = f"{level + ends[end]:.{len(digits)}f}".replace("-", "−")
        return tr(
            "{} is {} in the middle of {}: {}, {} near {:.3g}, {}{}",
            parameter,
            tr(follow.shape),
            with_what,
            at(0),
            value,
            place.at,
            at(-1),
            beside,
        )
    if follow.shape == "levels":
        each = ", ".join(at(k) for k in range(len(ends)))
        return tr("{} follows {}: {}{}", parameter, with_what, each, beside)
    bend = "" if follow.shape == "line" else f", {tr(follow.shape)}"
    how = tr("rises with {}", with_what) if up else tr("falls with {}", with_what)
    return tr("{} {}{}: {} to {}{}", parameter, how, bend, at(0), at(-1), beside)


def missing(name: str, rig: str) -> str:
    """What one effect is in a reader's words; "(unlisted)" begins what is none."""
    if name.startswith(UNSHAPED):
        sector, _, push = name[len(UNSHAPED) :].strip().partition(": ")
        where = f" {tr(WHERE.get(sector, 'somewhere'))} ({push})" if sector else ""
        return tr("something{} that no known effect explains", where)
    if found := followed_condition(name):
        if found[1] in ONLY_WHEN:
            return tr("{} changes with {}", found[0], tr(ONLY_WHEN[found[1]]))
        return tr("{} follows {}", *found)
    effect = effect_named(rig, name)
    return tr(effect.wording[0]) if effect and effect.wording[0] else name


def negative(size: Interval) -> Interval:
    """Of the opposite sign."""
    return Interval(-size.value, -size.high95, -size.low95)


def _value(size: Interval) -> str:
    """A value to the digits that its interval bears."""
    return with_interval(size.value, size.low95, size.high95).partition(" ")[0]


def _ends(size: Interval) -> str:
    """The ends of an interval, as after a value: "95 %: 0.016 to 0.020"."""
    shown = with_interval(size.value, size.low95, size.high95)
    return f"95 %: {shown.partition('(')[2][:-1]}"


def place(finding: Finding) -> str:
    """The most likely sector, in words."""
    best = next(
        (s for s in finding.sectors if math.isfinite(s.explained) and s.explained > 0),
        None,
    )
    return tr(WHERE.get(best.name, "somewhere") if best else "somewhere")


def window(f: Finding) -> str:
    """ "speed 1.2 to 2.4 m/s", "" without a window."""
    if f.window is None:
        return ""
    axis, unit = AXES.get(f.window.axis, (f.window.axis, ""))
    if f.window.axis == "n_bounce":
        numbers = range(math.ceil(f.window.low), math.floor(f.window.high) + 1)
        which = ", ".join(str(n + 1) for n in numbers)
        return tr("flight {}", which) if numbers else ""
    low, high = f.window.low, f.window.high
    found = tr("{} {:.3g} to {:.3g} {}", tr(axis), low, high, unit)
    return found.replace("-", "−").rstrip()


def chance(p: float) -> str:
    """A probability of noise alone, "p < 0.0001" where it is smaller."""
    return "p < 0.0001" if p < 1e-4 else f"p = {p:.2g}"


def odds(p: float) -> str:
    """A probability as a share of benches.

    >>> odds(0.131), odds(0.0042), odds(0.96), odds(1e-9)
    ('1 of 8 benches', '1 of 240 benches', '9 of 10 benches', 'fewer than 1 of 10 000 \
benches')
    """
    if p < 1e-4:
        return tr("fewer than 1 of 10 000 benches")
    if p < 0.35:
        return tr("1 of {:.0f} benches", float(f"{1 / p:.2g}"))
    return tr("{} of 10 benches", min(round(10 * p), 9))


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
        sentence = verdict_in_words(finding)
        out.append(f"{rig}: {sentence}")
        each = ((follow_in_words(f, finding), f) for f in finding.follows)
        out += [f"  {what} ({chance(f.p)})" for what, f in each if what not in sentence]
        if finding.matters and finding.next_record:
            out.append(tr("  to settle it, record: {}", finding.next_record))
        if (finding.matters or finding.laws) and rig in diagnosis.twins:
            out.append(f"  {diagnosis.twins[rig].in_words()}")
    out += [
        tr("{}: not diagnosed: {}", rig, why) for rig, why in diagnosis.refused.items()
    ]
    out += [f"{name}: {why}" for name, _, why in diagnosis.trouble]
    return [*out, *diagnosis.notes]
