"""The comment above every card: where the numbers came from, and how they were
converted."""

import math
import textwrap

from benchtwin.bench.numbers import with_interval
from benchtwin.calibrate.export.conventions import GIVEN, Solid
from benchtwin.calibrate.export.result import Calibrated, Number, Pair

MEANING = {
    "edem": (
        "EDEM standard: torque mu_r F_n R_i against each body's own spin; R_i from its"
        " centre of mass to the contact"
    ),
    "type_a": "type A (Ai et al. 2011): torque mu_r F_n R* against relative rolling",
    "type_c": "type C (Ai et al. 2011): elastic-plastic torque, at most mu_r F_n R*",
}
# what benchtwin does with a seed that lands on several balls
SHARED_DAMPING = (
    "benchtwin shares the damping among the balls of a seed that touch at once, so"
    " that e comes out as entered; an engine that damps each with the whole seed's"
    " mass gives less (e 0.54 as 0.42 with two balls, benchtwin's docs/engine.md)."
)
WIDTH = 116  # characters of a line that an editor beside another still shows whole


def header(
    c: Calibrated, mark: str, version: str, how: dict[str, str], notes: list[str]
) -> str:
    """The comment. mark: what its lines start with; how: `restitution`, … → what was
    done to the number; notes: sentences."""
    lines = [
        f"Contact parameters of {c.seed.name}, calibrated by benchtwin; written for"
        f" {version}.",
        f"Source: {c.source}",
        "Units: SI (m, kg, s, Pa, rad) unless a name says otherwise.",
        "",
        (
            "Values below: the one set with the highest joint probability, since"
            " medians, each by itself, need not fit together. In brackets each"
            " parameter alone (median, 95 % interval) and how far to trust it."
        ),
        *_pair_lines(f"{c.seed.name} on {c.wall.name}", c.on_wall),
        *_pair_lines(f"{c.seed.name} on {c.seed.name}", c.on_seed),
        f"  rolling friction as calibrated means: {MEANING[c.rolling]}",
        *(f"  {name}: {what}" for name, what in how.items()),
        *(_solid_line(solid) for solid in (c.seed, c.wall)),
        "",
        *(f"Note: {note}" for note in notes),
    ]
    # A line that ends in & or \\ goes on in the next one, in LAMMPS and in C++, comment
    # or not.
    safe = [line.replace("&", "and").replace("\\", "/") for line in lines]
    parts = [f"{mark} {part}".rstrip() for line in safe for part in _wrapped(line)]
    return "\n".join(parts) + "\n"


def length_note(calibrated: Calibrated, length: str) -> str:
    """For what the conversion to an engine's length, "R*" or "(R1 + R2)/2", is exact,
    and what it cannot do."""
    calibrated_with = "R*" if GIVEN[calibrated.rolling] == "effective" else "R_i"
    if calibrated_with == length:
        return (
            "rolling friction was calibrated with R*, which this engine takes too:"
            " nothing was converted."
        )
    note = (
        "rolling friction is exact for equal spheres and for a sphere on a wall;"
        f" between unequal spheres no factor converts {calibrated_with} into {length}."
    )
    if calibrated_with == "R*":
        return note
    balls = calibrated.shape.balls_m
    share = max((math.hypot(*ball[:3]) + ball[3]) / ball[3] for ball in balls)
    return (
        f"{note} In a seed of several balls R_i runs from the seed's centre of mass,"
        f" this engine's length is of the ball touched: up to {share:.2f} times less"
        " (at the seed's tip)."
    )


def digits(value: float) -> str:
    """Nine digits: more than any of this is known to, few enough to read."""
    return f"{value:.9g}"


def _wrapped(line: str) -> list[str]:
    """The line in pieces of WIDTH characters, the later ones two further in."""
    text = line.lstrip()
    indent = line[: len(line) - len(text)]
    wide = textwrap.TextWrapper(WIDTH, indent, indent + "  ", break_long_words=False)
    return wide.wrap(text) or [""]


def _pair_lines(who: str, pair: Pair) -> list[str]:
    return [
        f"  {who}: {name.replace('_', ' ')} {_text(number)}"
        for name, number in vars(pair).items()
    ]


def _text(number: Number) -> str:
    alone = with_interval(number.alone, number.low, number.high)
    return f"{number.value:.6g} [{alone}; {number.status}]"


def _solid_line(solid: Solid) -> str:
    return (
        f"  {solid.name}: density {solid.density_kg_m3:.6g} kg/m3, shear modulus G"
        f" {solid.shear_modulus_pa:.6g} Pa, Poisson's ratio {solid.poisson_ratio:.6g},"
        f" Young's modulus E = 2 G (1 + nu) = {solid.young_modulus_pa:.6g} Pa"
    )
