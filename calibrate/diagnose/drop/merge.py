"""One finding from two: flight and picture, and impacts; each has been asked at its share of the chance of a false alarm."""

from dataclasses import replace

import numpy as np

from calibrate.diagnose.effects.drop.impact import FALLING
from calibrate.diagnose.finding import Finding
from calibrate.diagnose.locate import Location, Sector

NEWS_P = 0.05  # an excess more likely than this by chance is no part of what is to be explained, where another is not


def merged(flight: Finding, above: Location, impact: Finding, below: Location, *, share: float) -> Finding:
    """p: Bonferroni over both, the flights having `share` of the chance; shares of sectors in the excess of both; names of both
    where both are named."""
    told = [f for f in (flight, impact) if f.verdict != "none"]
    first, other = (flight, impact) if above.excess >= below.excess or impact.verdict == "none" else (impact, flight)
    if flight.verdict == "none" and impact.verdict != "none":
        first, other = impact, flight
    verdict, names = _verdict(told)
    both = first.verdict != "none" and other.verdict != "none"
    return replace(
        first, recordings=flight.recordings if len(flight.recordings) >= len(impact.recordings) else impact.recordings,
        p_global=min(1.0, flight.p_global / share, impact.p_global / (1 - share)), alarm=flight.alarm or impact.alarm,
        sectors=_sectors(above, below), window=first.window or other.window, collapse=first.collapse or other.collapse,
        verdict=verdict, names=names, parameters={n: p for f in told for n, p in f.parameters.items()},
        ln_bayes_baseline=float(np.sum([f.ln_bayes_baseline for f in told])) if told else float("nan"),
        ln_bayes_runner_up=min((f.ln_bayes_runner_up for f in told), default=float("nan")),
        law="; ".join(f.law for f in told if f.law) or None,
        next_record=_next(told), held_out=first.held_out or (other.held_out if both else None),
        candidates=(*first.candidates, *other.candidates), curves=(*flight.curves, *impact.curves),
        notes=(*flight.notes, *impact.notes), left_out=flight.left_out | impact.left_out,
    )  # fmt: skip


def _verdict(told: list[Finding]) -> tuple[str, tuple[str, ...]]:
    """Unknown if either is; a class of e's laws beside a name stands by the class's own name, which is as definite."""
    if not told:
        return "none", ()
    if len(told) == 1:
        return told[0].verdict, told[0].names
    if any(f.verdict == "unknown" for f in told):
        return "unknown", tuple(n for f in told if f.verdict == "name" for n in f.names)
    falling = [f.verdict == "class" and set(f.names) <= set(FALLING) for f in told]
    parts = [((FALLING[0],), "name") if e else (f.names, f.verdict) for f, e in zip(told, falling, strict=True)]
    names = tuple(dict.fromkeys(n for part, _ in parts for n in part))
    return ("name" if all(kind == "name" for _, kind in parts) else "class"), names


def _next(told: list[Finding]) -> str | None:
    return "; ".join(dict.fromkeys(f.next_record for f in told if f.next_record)) or None


def _sectors(above: Location, below: Location) -> tuple[Sector, ...]:
    """Shares in the excess of flights and impacts together, best first."""
    news = [x.p < NEWS_P for x in (above, below)]
    excess = [x.excess if is_news or not any(news) else 0.0 for x, is_news in zip((above, below), news, strict=True)]
    whole = sum(excess)
    out = []
    for part, own in zip((above, below), excess, strict=True):
        share = own / whole if whole > 0 else float("nan")
        out += [Sector(s.name, float(np.nan_to_num(s.explained) * share), s.p) for s in part.sectors]
    return tuple(sorted(out, key=lambda s: (-np.nan_to_num(s.explained), s.p)))
