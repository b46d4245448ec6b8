"""One stage of a run (filling, coming to rest, lifting …) as one LAMMPS input file that
also runs by hand."""

import math
from dataclasses import dataclass, replace

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.observe import Settled
from benchtwin.sim.engine.time_step import time_step
from benchtwin.sim.engine.world import World
from benchtwin.sim.lammps.contact import refuse_others, words
from benchtwin.sim.lammps.walls import name_of, wall_lines

# neighbour lists reach so much farther than contact, of the smallest ball's radius
SKIN = 0.4
OUTSIDE_EVERY_S = 0.005  # how often seeds outside the domain are taken away
RESTART_EVERY_S = 0.05
DRAG_STEPS = 10
SPINNING = (
    "# A seed on a single contact may spin about its normal for ever: no law brakes"
    " that, and no picture shows it."
)
STILL = (
    "# All lie still: over a window no seed has gone farther than a share of its"
    " diameter, and the kinetic energy is low."
)
BALANCE_EVERY_S = 0.02  # how often ranks share the seeds out anew


@dataclass(frozen=True)
class Stage:
    """name: of the files. world: seeds, walls, contacts. begin: None, from NAME.data
    and NAME.bodies, else the stage whose end it goes on from. frame_s: how often the
    seeds' places are written, look_s: how often the end is asked for; the longer is a
    multiple of the shorter. longest_s: the end at the latest. least_s: not before that.
    still: the end is when they lie as it says, None: at longest_s. over: of a single
    seed, a formula of LAMMPS in v_x, v_y, v_z [m], its place: above 0 the stage ends
    too. pushes: whether each wall's load, averaged from frame to frame, is written."""

    name: str
    world: World
    begin: str | None
    frame_s: float
    look_s: float
    longest_s: float
    least_s: float = 0.0
    still: Settled | None = None
    over: str = ""
    pushes: bool = False

    @property
    def step_s(self) -> float:
        """The engine's step, shortened so that frames and looks fall on steps."""
        shorter = min(self.frame_s, self.look_s)
        # LAMMPS damps with speeds of half a step ago, and single balls do not blow up
        longest = time_step(replace(self.world, share_damping=True))
        return shorter / math.ceil(shorter / longest - 1e-9)

    @property
    def frame_steps(self) -> int:
        return round(self.frame_s / self.step_s)

    @property
    def look_steps(self) -> int:
        return round(self.look_s / self.step_s)

    @property
    def restart_steps(self) -> int:
        """At frames, which join what comes before a restart to what comes after it."""
        return max(round(RESTART_EVERY_S / self.frame_s), 1) * self.frame_steps

    @property
    def files(self) -> tuple[str, str, str]:
        """Input, restart files in turn."""
        return f"{self.name}.in", f"{self.name}.restart.1", f"{self.name}.restart.2"


def script(stage: Stage, ranks: int, title: str) -> str:
    """The whole input; refuses by name what LAMMPS has not."""
    refuse_others(stage.world)
    walls = wall_lines(stage.world, contacts=stage.pushes)
    head, contacts = _head(stage, ranks, title), _contacts(stage.world)
    parts = [head, contacts, _seeds(stage), walls, _leaving(stage, ranks)]
    parts += [_looking(stage), _pushes(stage), _end(stage)]
    return "\n\n".join("\n".join(lines) for lines in parts if lines) + "\n"


def _head(stage: Stage, ranks: int, title: str) -> list[str]:
    name = stage.name
    # a fix is filled from data that come after it, or a restart before it
    sizes = '"fix sizes all property/atom d_size"'
    if stage.begin is None:
        first = [sizes, f'"read_data {name}.data fix sizes NULL Sizes"']
    else:
        first = [f'"read_restart {stage.begin}.end"', '"reset_timestep 0"', sizes]
    bodies = f"{name}.bodies" if stage.begin is None else f"{stage.begin}.end.rigid"
    widest = max(s.bounding_radius_m for s in stage.world.seeds[0].shapes)
    spread = 2.1 * widest + _skin(stage.world)
    begin = " ".join(first)
    again = f"lmp -in {name}.in -var from {name}.restart.1 -var part 2"
    theirs = '"variable bodies string ${from}.rigid"'
    return [
        f"# {title}",
        f"# By hand: lmp -in {name}.in; stopped, it goes on with: {again}",
        "variable from index none",
        "variable part index 1",
        "",
        "units si",
        "atom_style hybrid sphere molecular",
        "atom_modify map array",
        "boundary m m m",
        "newton off",
        f"comm_modify vel yes cutoff {spread:.8g}",
        "processors * * 1" if ranks > 2 else f"processors {ranks} 1 1",
        "# d_size: diameter of the sphere of the seed's volume [m]",
        f'if "${{part}} == 1" then {begin} else "read_restart ${{from}}" {sizes}',
        f'if "${{part}} == 1" then "variable bodies string {bodies}" else {theirs}',
        f"timestep {stage.step_s:.15g}",
        "group touching type 1 2",
        "group middle type 2 3  # the ball at each seed's centre of mass",
        f"restart {stage.restart_steps} {name}.restart.1 {name}.restart.2",
    ]


def _skin(world: World) -> float:
    return SKIN * min(float(np.min(shape.radii_m)) for shape in world.seeds[0].shapes)


def _contacts(world: World) -> list[str]:
    exclude = " ".join(f"exclude type {k} 3" for k in (1, 2, 3))
    return [
        f"neighbor {_skin(world):.8g} bin",
        f"neigh_modify every 1 delay 0 check yes exclude molecule/intra all {exclude}",
        "pair_style granular",
        "pair_coeff * * " + words(world, world.seeds[0].material.name),
    ]


def _seeds(stage: Stage) -> list[str]:
    """Weight, rigid bodies, drag."""
    down = np.asarray(stage.world.gravity, float)
    size = float(np.linalg.norm(down))
    along = " ".join(f"{v:.12g}" for v in (down / size if size else (0.0, 0.0, -1.0)))
    lines = [
        f"fix weight all gravity {size:.12g} vector {along} disable",
        "fix seeds all rigid/small molecule infile ${bodies} reinit no gravity weight",
    ]
    for chosen in stage.world.active_laws:
        if chosen.law.name == "drag":
            names = (p.name for p in chosen.law.parameters)
            lines += _drag(dict(zip(names, chosen.numbers, strict=True)))
    return lines


def _drag(number: dict[str, float]) -> list[str]:
    """Drag after Brown and Lawler, as `sim.laws.drag` has it, on the ball at the centre
    of mass. Its coefficient is computed anew every DRAG_STEPS only: as a formula it
    costs LAMMPS a third of a heap's time."""
    winds = {axis: number[f"wind_{axis}"] for axis in "xyz"}
    air = [f"(v{axis}-({w:.12g}))" if w else f"v{axis}" for axis, w in winds.items()]
    squares = "+".join(f"{v}*{v}" for v in air)
    over = number["air_density"] / number["viscosity"]
    k = -0.39269908169872414 * number["factor"] * number["viscosity"]
    by_re = "24.0*(1.0+0.15*v_re^0.681)+0.407*v_re*v_re/(v_re+8710.0)"
    drag = zip("xyz", air, strict=True)
    return [
        f'variable re atom "{over:.15g}*d_size*sqrt({squares})"',
        f'variable k atom "{k:.15g}*d_size*({by_re})"',
        f"fix resistance middle store/state {DRAG_STEPS} v_k",
        *(f'variable drag{axis} atom "f_resistance*{v}"' for axis, v in drag),
        "fix air middle addforce v_dragx v_dragy v_dragz",
    ]


def _leaving(stage: Stage, ranks: int) -> list[str]:
    """Seeds that leave the domain; ranks that keep evenly busy."""
    lines = []
    if stage.world.domain is not None:
        ends = np.transpose(stage.world.domain).ravel()
        numbers = " ".join(f"{v:.12g}" for v in ends)
        steps = max(round(OUTSIDE_EVERY_S / stage.step_s), 1)
        lines = [
            f"region domain block {numbers} side out",
            f"fix leaving middle evaporate {steps} 1000000000 domain 1 molecule yes",
        ]
    if ranks > 1:
        steps, along = max(round(BALANCE_EVERY_S / stage.step_s), 1), "xy"[: ranks - 1]
        lines.append(f"fix shares all balance {steps} 1.05 shift {along} 10 1.05")
    return lines


def _looking(stage: Stage) -> list[str]:
    turns, spin = "quatw quati quatj quatk", "omegax omegay omegaz"
    file = f"{stage.name}.${{part}}.bodies.dump"
    return [
        f"compute bodies all rigid/local seeds mol x y z {turns} vx vy vz {spin}",
        f"dump bodies all local {stage.frame_steps} {file} c_bodies[*]",
        'dump_modify bodies format float "%.14g" first yes',
        "compute moving all ke/rigid seeds",
        SPINNING,
        'variable kinetic equal "c_moving/count(middle)"  # a seed, without spin [J]',
        f"thermo {stage.look_steps}",
        "thermo_modify lost ignore flush yes",
    ]


def _pushes(stage: Stage) -> list[str]:
    """Each wall's load [N], averaged over the steps from frame to frame: what happens
    between two frames is in it."""
    if not stage.pushes:
        return []
    names = [name_of(wall) for wall in stage.world.walls]
    sums = [
        f"compute load_{n} all reduce sum f_{n}[2] f_{n}[3] f_{n}[4]" for n in names
    ]
    columns = " ".join(f"c_load_{n}[{k}]" for n in names for k in (1, 2, 3))
    each, file = stage.frame_steps, f"{stage.name}.${{part}}.push.txt"
    return [*sums, f"fix pushes all ave/time 1 {each} {each} {columns} file {file}"]


def _end(stage: Stage) -> list[str]:
    """Until nothing moves, or the seed is where it is to be, or for a time; then the
    state is kept, and how it ended."""
    look = stage.look_steps
    longest, least = (
        math.ceil(round(t / stage.step_s) / look) * look
        for t in (stage.longest_s, stage.least_s)
    )
    done = [
        f"write_restart {stage.name}.end",
        f'print "still ${{still}}" file {stage.name}.done',
    ]
    place = [
        "compute place middle reduce sum x y z",
        *(f"variable {a} equal c_place[{k}]" for k, a in enumerate("xyz", 1)),
    ]
    place = [*place, f'variable over equal "{stage.over}"'] if stage.over else []
    leave = ['if "$(v_over) > 0" then "jump SELF done"'] if stage.over else []
    if stage.still is None:
        begin = [
            *place,
            "thermo_style custom step time v_kinetic" + (" v_over" if place else ""),
            "variable still equal 0",
        ]
        if not stage.over:
            return [*begin, f"run {longest} upto", *done]
        again = f'if "$(step) < {longest}" then "jump SELF look"'
        return [*begin, "label look", f"run {look}", *leave, again, "label done", *done]
    lot = stage.world.seeds[0]
    size = float(np.mean([(6 * s.volume_m3 / np.pi) ** (1 / 3) for s in lot.shapes]))
    mass = float(np.mean([s.mass_kg for s in lot.shapes]))
    quiet = stage.still.kinetic * mass * G_M_S2 * size
    window = round(stage.still.window_s / stage.step_s / look) * look
    moved = [
        "compute moved middle displace/atom",
        "compute way middle reduce max c_moved[4]",
        "thermo_style custom step time v_kinetic c_way" + (" v_over" if place else ""),
    ]
    anew = '"uncompute way" "uncompute moved" "jump SELF anew"'
    far = f"{stage.still.displacement * size:.8g}"
    return [
        *place,
        "thermo_style custom step time v_kinetic",
        f'if "$(step) < {least}" then "run {least} upto"' if least else "",
        STILL,
        "variable still equal 0",
        "label anew",
        *moved,
        "variable since equal $(step)",
        "label look",
        f'if "$(step) >= {longest}" then "jump SELF done"',
        f"run {look}",
        *leave,
        f'if "$(v_kinetic) > {quiet:.8g} || $(c_way) > {far}" then {anew}',
        f'if "$(step-v_since) < {window}" then "jump SELF look"',
        "variable still equal 1",
        "label done",
        *done,
    ]
