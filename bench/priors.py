"""What is believed of whatever a recording does not state: one table, which measuring
and diagnosing both read."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Prior:
    """Standard deviations of one thing about its centre.

    unstated: where nothing is said of it, None where it must be stated; stated: where
    its value is stated without an sd, None where there is no such key; possible: the
    least and the greatest sd that anybody can state, None where none can be stated."""

    unit: str
    unstated: float | None
    stated: float | None
    source: str
    possible: tuple[float, float] | None = None


PRIORS = {
    # angles of a plate
    "tilt-sensor-zero": Prior(
        "deg",
        0.05,
        None,
        "data sheets of goniometers and inclinometers; common to a whole session",
    ),
    "column-step": Prior(
        "of the step",
        12**-0.5,
        None,
        "a display rounds in a way nobody knows: any error within its step is alike (a"
        " quarter of the step, as for a reader, takes rounding to nearest for granted)",
    ),
    "start-angle": Prior(
        "deg",
        30.0,
        0.5,
        "a film may begin somewhat before or after the tilting; at 2 °/s a quarter of"
        " a second",
    ),
    "tilt-rate": Prior(
        "relative", None, 0.01, "motors and winches hold a stated rate to a percent"
    ),
    "reader-zero": Prior("deg", 0.1, None, "of a protractor's zero"),
    "reader-step": Prior(
        "of the step", 0.25, None, "people read to nearest, and some cut or go upward"
    ),
    "reading": Prior("deg", 0.03, None, "of a reader, beside the slides' scatter"),
    # the camera
    "scale": Prior(
        "relative",
        0.01,
        0.01,
        "a ruler beside the plane of the motion; at best 0.1 mm of a metre",
        (1e-4, 0.5),
    ),
    "plumb": Prior(
        "deg",
        1.0,
        0.5,
        "a camera set up by eye; stated: a line seen in its picture; at best one pixel"
        " along a whole picture",
        (0.01, 45.0),
    ),
    "outline-centre": Prior(
        "px", 0.01, None, "of a turning outline, which uneven light moves"
    ),
    "board-print": Prior(
        "relative",
        0.005,
        None,
        "a printer not checked by the sheet's line",
    ),
    "board-line": Prior("mm", 0.15, None, "of the sheet's line, read off a ruler"),
    "board-bend": Prior("of its width", 0.003, None, "a sheet glued to cardboard"),
    "board-bent": Prior("of its width", 0.05, None, "a loose sheet"),
    "board-lean": Prior("deg", 0.7, None, "of a board stood upright by eye"),
    "board-lens": Prior("at the corner", 0.02, None, "a phone's lens"),
    "principal-point": Prior(
        "of half a diagonal", 0.02, None, "of an uncropped picture"
    ),
    "focal-length": Prior(
        "ln", 0.5, None, "about .75 of the diagonal: phones .6 (wide) to 2 (tele)"
    ),
    "lens": Prior("at the edge", 2e-4, None, "distortion of a good lens"),
    "perspective": Prior("1/m", 1e-3, None, "a camera that looks straight on"),
    # a drop
    "release-height": Prior(
        "mm",
        None,
        5.0,
        "held by hand and measured to a finger, to the seed's middle or from the"
        " table; common to a session; at best as gauge blocks",
        (0.01, 1000.0),
    ),
    "fall": Prior("mm", 600.0, None, "rms of heights up to 1 m"),
    "release-scatter": Prior("mm", 1.0, None, "of one release beside the others"),
    "restitution": Prior("1", 0.3, None, "about 0.5"),
    "restitution-with-speed": Prior(
        "per ln v", 0.072, None, "0.1 less at 2 than at 0.5 m/s"
    ),
    "bounce-scatter": Prior("1", 0.003, None, "of the best balls; larger is told"),
    # what acts on a seed
    "gravity": Prior(
        "relative",
        8e-4,
        None,
        "9.780 to 9.832 m/s² over the earth, 9.79 to 9.82 where most people live",
    ),
    "drag": Prior(
        "over weight at 2 m/s",
        0.018,
        None,
        "a soybean's (maize 0.012, wheat 0.03): mean and sd where no seed is described",
    ),
    "drag-coefficient": Prior("relative", 0.15, None, "of a seed beside a sphere's"),
    "drag-of-one-seed": Prior("relative", 0.05, None, "within its lot"),
    "drag-slope": Prior(
        "d ln C_d/d ln v", 0.15, None, "-0.2 for a sphere, 0 for a bluff body"
    ),
    "approach": Prior(
        "m/s",
        0.05,
        None,
        "towards the camera, common to a session's releases: 25 mm in half a second",
    ),
    "own-force": Prior(
        "m/s²",
        0.05,
        None,
        "on one flight beside the others, where a bench shows it: 0.05 to 0.15 in"
        " contact-nets' tosses, whose tracked point lies beside the centre of mass",
    ),
    # a sliding block
    "friction-scatter": Prior(
        "1", 0.003, None, "between slides of one pair; larger scatter is summed over"
    ),
    "friction-within-run": Prior(
        "1",
        0.0005,
        None,
        "of friction along one slide beside a steady one; what a bench shows counts",
    ),
    "friction-to-rest": Prior(
        "1",
        0.005,
        None,
        "the same of what was set in motion on a plate that stands; a bench tells its"
        " size: 0.005 in each of eight waves along slides of contact-nets' cube",
    ),
    "friction-settling": Prior(
        "1",
        0.3,
        None,
        "of what was set in motion, in its first hundredth of a second, beside that of"
        " a steady slide; what a bench shows counts: 0.9 where a cube lands",
    ),
    "friction-shared": Prior(
        "of own",
        3.0,
        None,
        "what all slides of a bench have in common of these, beside what each has of"
        " its own: contact-nets' cube's friction rises by 0.016 per ln v",
    ),
    "hinge": Prior("m", 0.15, None, "of rigs with a plate of 30 cm; θ̇² r is 1e-4 g"),
    "drag-beside-plate": Prior(
        "relative",
        1.0,
        0.5,
        "drag beside a plate differs from free flight's; unstated: sizes or mass of the"
        " seed are unknown as well",
    ),
    "drag-shade": Prior(
        "of a quarter of ln n", 1.0, None, "each of n seeds feels n^0 to n^-1/2"
    ),
    # a rolling seed
    "incline": Prior(
        "deg",
        5.0,
        0.1,
        "a protractor or inclinometer; half of the variance is common to a session,"
        " half each run's own. Unstated: about what the motion says",
    ),
    "way-on-incline": Prior(
        "mm", 20.0, 0.5, "a seed laid against a mark by eye. Unstated: as the incline"
    ),
    "corner-cut": Prior(
        "of r tan(β/2)",
        0.5,
        None,
        "the centre of a ball of radius r turns so far before a sharp corner and its"
        " foot after it, that of a point at it; what a track follows is not said:"
        " 0.5 ± 0.5",
    ),
    "level-plate": Prior(
        "deg",
        0.1,
        0.02,
        "tables that people call level: two public ones lean by 0.08 and 0.2°"
        " (benchmarks/learn_priors.py); a stated slope is read off an engineer's level",
    ),
    "level-both-ways": Prior(
        "deg",
        0.005,
        0.005,
        "rolls both ways tell how a plate leans: more than an engineer's spirit level"
        " shows, 0.1 mm/m, is named",
    ),
    "sharp-corner": Prior(
        "normal rank", 1.0, None, "a corner takes nothing to what a sharp one takes"
    ),
    "rolling-scatter": Prior(
        "relative", 0.03, None, "between runs of one lot; larger scatter is summed over"
    ),
    "inertia": Prior(
        "relative",
        0.02,
        0.003,
        "of 1 + I/(m r²): of what is no ball or of unknown shape; of a stated ball",
    ),
    "gate-place": Prior(
        "mm", 0.3, None, "read off a ruler: a light gate's beam is some mm wide"
    ),
    # a plate of seeds
    "plate-coverage": Prior(
        "1",
        0.05,
        0.01,
        "of seeds laid by hand side by side: about 0.78; counted on a square of known"
        " sides",
    ),
    "plate-glue": Prior(
        "of what an impact gives back",
        0.02,
        None,
        "10 mm² of hard glue, 0.3 mm of 0.1 to 1 GPa, store 1 to 8 % of what a contact"
        " does",
    ),
    # a heap, a draw-down
    "pane-friction": Prior("1", 0.1, None, "of seeds on glass or acrylic, about 0.3"),
    "row-of-few": Prior("mm", 0.5, None, "of a row where too few show their scatter"),
    "depth": Prior("mm", 2.0, None, "a run beside the plane in which the scale holds"),
    "astray": Prior("1", 0.01, None, "tangent of a run's angle to that plane"),
    "ruler-zero": Prior("mm", 0.2, None, "of a ruler, the same in all readings"),
    "step-climb": Prior("of ln t", 1.0, None, "ratchets climb a step in 0.03 to 0.2 s"),
}


# of a camera whose distance is not stated: any between these, log-uniform
NEAREST_M, FARTHEST_M = 0.3, 20.0
# its inverse is the root mean square of inverse distances, with which perspective goes
UNKNOWN_DISTANCE_M = math.sqrt(
    2 * math.log(FARTHEST_M / NEAREST_M) / (NEAREST_M**-2 - FARTHEST_M**-2)
)


def unstated_sd(name: str) -> float:
    """sd of something of which a recording says nothing."""
    return _known(name, PRIORS[name].unstated, "has to be stated")


def stated_sd(name: str) -> float:
    """sd of something that a recording states without an sd."""
    return _known(name, PRIORS[name].stated, "cannot be stated")


def usable_sd(name: str, stated: float) -> float:
    """An sd that a recording states, within what anybody can know or mean."""
    least, greatest = PRIORS[name].possible or (0.0, math.inf)
    return min(max(stated, least), greatest)


def _known(name: str, sd: float | None, why: str) -> float:
    if sd is None:
        raise KeyError(f"{name} {why}")
    return sd
