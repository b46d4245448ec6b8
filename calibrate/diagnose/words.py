"""Findings in plain words: the verdict in a sentence, as it is printed and as a report opens."""

import math

from calibrate.diagnose.finding import Finding, Parameter

# effect → (what is missing, what its number means), in a reader's words
SAYS: dict[str, tuple[str, str]] = {
    "drag": ("air drag is missing", "of the weight at {speed} m/s"),
    "magnus": ("a side force from the spin (Magnus) is missing", "= C in C (ρ A r/2m) ω × v"),
    "draught": ("a draught is missing", "m/s along x"),
    "restitution-falls-with-speed": ("restitution falls with impact speed", "less at 2.0 than at 0.5 m/s"),
    "viscoelastic-restitution": ("restitution falls with impact speed, as viscous solids do", "less at 2.0 than at 0.5 m/s"),
    "plastic-restitution": ("restitution falls with impact speed, as yielding solids do", "less at 2.0 than at 0.5 m/s"),
    "film-adhesion": ("a sticky film takes energy at every impact", "m/s"),
    "impact-damage": ("restitution changes with every impact of a seed", "of itself per impact"),
    "plate-tilt": ("the plate is tilted", "°"),
    "plate-compliance": ("the plate gives way and carries energy off", "less restitution at 2.0 than at 0.5 m/s"),
    "shape-conversion": ("the seed's shape turns fall into spin more than allowed for", ""),
    "scale-error": ("the scale is wrong", "= true/stated − 1"),
    "clock-error": ("the frame rate is wrong", "= true/stated − 1"),
    "camera-roll": ("the camera is rolled", "° clockwise beyond what is stated"),
    "perspective": ("the scale changes with height", "per metre"),
    "silhouette-wobble": ("the tracked centre wobbles as the seed turns", "mm"),
    "kinetic-friction": ("friction falls once it slides", "= μ static − μ kinetic"),
    "stribeck": ("friction falls smoothly with sliding speed", "= μ at rest − μ at high speed"),
    "viscous-sliding": ("friction grows with sliding speed", "s/m"),
    "adhesion": ("something pulls the seeds to the plate", "mN"),
    "reading-delay": ("the angle was read too late", "mm after the onset"),
    "clock-offset": ("tilt and picture clocks disagree", "s"),
    "angle-offset": ("the tilt angle is off", "°"),
    "plate-vibration": ("the plate vibrates", "m/s²"),
    "partial-rolling": ("the block rolls in part", "= added inertia over mass"),
    "stepped-tilt": ("the tilt moves in steps", "°"),
    "viscous-rolling": ("rolling friction grows with speed", "s/m"),
    "slope": ("the plate is not level", "° rising along +x"),
    "initial-slip": ("the seed slips where the incline ends", "m/s"),
    "corner-loss": ("the corner takes speed", "of the speed"),
    "shape-barrier": ("the seed's shape makes it climb as it rolls", "mm"),
    "cohesion": ("the seeds stick together", ""),
    "wall-friction": ("friction of the side walls is missing", ""),
    "gate-speed": ("the gate moved at another speed than stated", ""),
    "base-vibration": ("the base vibrated", ""),
    "base-tilt": ("the base is tilted", "°"),
    "particle-shape": ("the seeds' shape is not as simulated", ""),
}
WHERE = {
    "flight": "in flight", "impact": "in the impacts", "measurement": "in how it was measured", "onset": "at the onset",
    "sliding": "while it slides", "incline": "on the incline", "run-out": "in the run-out", "crest": "at the crest",
    "middle": "in the middle of the slope", "toe": "at the toe",
}  # fmt: skip
AXES = {
    "t_s": ("time", "s"), "z_mm": ("height", "mm"), "v_m_s": ("speed", "m/s"), "x_mm": ("place", "mm"),
    "x_share": ("share of the flank from its crest", ""),
    "n_bounce": ("bounce number", ""), "tilt_deg": ("tilt", "°"), "travel_mm": ("travel", "mm"), "phase_deg": ("phase", "°"),
}  # fmt: skip


def verdict_in_words(finding: Finding) -> str:
    """One sentence: what is missing, and how much of it."""
    if finding.verdict == "none":
        count = len(finding.recordings)
        these = "the recording shows" if count == 1 else f"{count} recordings show"
        return f"nothing is missing that {these} ({_p(finding.p_global)})"
    if finding.verdict == "name":
        return "; ".join(named(n, finding) for n in finding.names)
    where = place(finding)
    if finding.verdict == "class":
        if len(finding.names) == 1:
            return f"something is missing {where}; the likely reason, not settled: {missing(finding.names[0])}"
        return f"something is missing {where}: {' or '.join(finding.names)}; these recordings do not tell which"
    law = f": {finding.law}" if finding.law else ""
    return f"something is missing {where} that no known effect explains{law}"


def missing(name: str) -> str:
    """What one effect is in a reader's words."""
    return SAYS.get(name, (name, ""))[0]


def named(name: str, finding: Finding) -> str:
    """ "air drag is missing: 0.018 ± 0.002 of the weight at 2 m/s" (95 %)."""
    parameter = finding.parameters.get(name)
    if parameter is None:
        return missing(name)
    unit = SAYS.get(name, ("", parameter.unit))[1].format(speed="0.5" if finding.rig == "roll" else "2")
    return f"{missing(name)}: {plus_minus(parameter)}{'' if unit.startswith('°') else ' '}{unit}".rstrip()


def plus_minus(p: Parameter) -> str:
    """Value ± half its 95 % interval, with two digits of that.

    >>> plus_minus(Parameter("1", 0.01834, 0.0163, 0.0203))
    '0.0183 ± 0.0020'
    """
    half = (p.high95 - p.low95) / 2
    if not (math.isfinite(half) and half > 0):
        return f"{p.value:.3g}"
    digits = max(0, min(8, 1 - math.floor(math.log10(half))))
    return f"{p.value:.{digits}f} ± {half:.{digits}f}".replace("-", "−")


def place(finding: Finding) -> str:
    """Where it is missing: the best sector, in words."""
    best = next((s for s in finding.sectors if math.isfinite(s.explained) and s.explained > 0), None)
    return WHERE.get(best.name, f"in {best.name}") if best else "somewhere"


def window_in_words(finding: Finding) -> str:
    """ "speed 1.2 to 2.4 m/s", "" without a window."""
    if finding.window is None:
        return ""
    axis, unit = AXES.get(finding.window.axis, (finding.window.axis, ""))
    if finding.window.axis == "n_bounce":
        numbers = range(math.ceil(finding.window.low), math.floor(finding.window.high) + 1)
        return f"flight {', '.join(str(n + 1) for n in numbers)}" if numbers else ""
    return f"{axis} {finding.window.low:.3g} to {finding.window.high:.3g} {unit}".replace("-", "−").rstrip()


def _p(p: float) -> str:
    return "p < 0.0001" if p < 1e-4 else f"p = {p:.2g}"


def lines(diagnosis) -> list[str]:
    """What the command prints: a line a rig, what to record next, what could not be used."""
    out = []
    for rig, finding in diagnosis.findings.items():
        out.append(f"{rig}: {verdict_in_words(finding)}")
        if finding.verdict != "none" and finding.next_record:
            out.append(f"  to settle it, record: {finding.next_record}")
        if rig in diagnosis.twins:
            out.append(f"  {diagnosis.twins[rig].in_words()}")
    out += [f"{rig}: not diagnosed: {why}" for rig, why in diagnosis.refused.items()]
    out += [f"{name}: {why}" for name, _, why in diagnosis.trouble]
    return [*out, *diagnosis.notes]
