"""Makes one case from its line of the plan and the seed: the bench folder and the
answer key."""

import math
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from benchtwin.prove.cases.bench import Bench, Request, Scene, write_bench
from benchtwin.prove.cases.conditions import Condition, draw_conditions
from benchtwin.prove.cases.record import FOLLOWS, ORDER_DRIFT, Cases, field_of
from benchtwin.prove.cases.snr import Visibility
from benchtwin.prove.cases.stated import draw_absent_keys, without_absent_keys
from benchtwin.prove.plan import Spec
from benchtwin.prove.rigs import RIGS

SCENES, ROUNDS = 5, 5
CLOSE = 1.08  # it is not sought nearer
NEAR = 1.25  # a size that makes the wanted SNR within this factor will do
# sds of a contact parameter: half an sd, give or take the factor of 3 by which fits
# differ
MATTERS = 1.5
TRIFLES = 0.17


@dataclass(frozen=True)
class Concealed:
    """One effect of a case. unit None: without a parameter. scored: whether one number
    is true of all recordings."""

    name: str
    value: float
    unit: str | None
    snr: float
    either: bool = False
    scored: bool = True


@dataclass(frozen=True)
class Key:
    """The answer key of a case."""

    case: str
    rig: str
    kind: str
    effects: tuple[Concealed, ...]
    sectors: tuple[str, ...]  # where the effect shows
    separated: bool | None
    rendered: bool
    noise: dict = field(default_factory=dict)
    matters: bool | None = None  # whether it moves the rig's contact parameter
    absent: tuple[str, ...] = ()  # keys that the bench does not state
    conditions: tuple[str, ...] = ()  # that it states

    @property
    def snr(self) -> float:
        """Of the least visible effect; 0 when clean."""
        return min((e.snr for e in self.effects), default=0.0)

    @staticmethod
    def from_dict(content: dict) -> "Key":
        effects = tuple(Concealed(**e) for e in content["effects"])
        lists = {
            name: tuple(content[name]) for name in ("sectors", "absent", "conditions")
        }
        return Key(**{**content, **lists, "effects": effects})


@dataclass(frozen=True)
class MadeCase:
    """A scene with what is concealed in it, and the conditions that its recordings
    state."""

    scene: Scene
    conditions: tuple[Condition, ...]

    def bench(self, rig: Cases) -> Bench:
        recordings = []
        for k, world in enumerate(self.scene.worlds):
            name = f"{rig.rig}-{k + 1:02d}"
            made = rig.record(self.scene, world, name)
            toml = {"rig": rig.rig, "id": name} | made.toml
            stated = {c.name: c.values[k] for c in self.conditions}
            if stated := {n: v for n, v in stated.items() if v is not None}:
                toml["conditions"] = stated
            recordings.append(replace(made, toml=toml))
        bench = Bench(self.scene.toml, tuple(recordings))
        return without_absent_keys(bench, self.scene.request.absent)


def conceal(spec: Spec, seed: int) -> tuple[MadeCase, Key]:
    """The scene in which the wished effects come nearest to the wished SNRs, and the
    key."""
    rig, tried = RIGS[spec.rig], []
    for attempt in range(SCENES if spec.effects else 1):
        rng = np.random.default_rng([seed, spec.index, attempt])
        absent = draw_absent_keys(spec.effects, rng)
        asked = Request(spec.effects, spec.separated, spec.rendered, absent)
        scene = rig.draw(asked, rng)
        scene, conditions = _with_conditions(scene, rig, spec, rng)
        scene, seen = sized(rig, scene, spec, rng)
        ratios = [max(one.snr, 1e-3) / w for one, w in zip(seen, spec.wanted_snr)]
        off = max((abs(math.log(ratio)) for ratio in ratios), default=0.0)
        tried.append((off, MadeCase(scene, conditions), seen))
        if off < math.log(NEAR):
            break
    _, made, seen = min(tried, key=lambda one: one[0])
    return made, _key(spec, made, seen)


def _with_conditions(
    scene: Scene, rig: Cases, spec: Spec, rng: np.random.Generator
) -> tuple[Scene, tuple[Condition, ...]]:
    """The scene, its parameters following the condition that matters or their order;
    and what the recordings state."""
    worlds = scene.worlds
    order = np.linspace(-1, 1, len(worlds))
    design = [[float(getattr(world, name)) for name in rig.design] for world in worlds]
    beside = np.column_stack([order, np.array(design)])
    follows = FOLLOWS in spec.effects
    conditions = draw_conditions(beside, follows, not spec.effects, rng)
    places = conditions[0].follows if follows else order
    if follows or ORDER_DRIFT in spec.effects:
        pairs = zip(worlds, places, strict=True)
        worlds = tuple(world._replace(followed=float(at)) for world, at in pairs)
    return replace(scene, worlds=worlds), conditions


def sized(
    rig: Cases, scene: Scene, spec: Spec, rng: np.random.Generator
) -> tuple[Scene, list[Visibility]]:
    """The scene with effects of about the SNR that is wanted, as far as sizes are
    believable; how visible they are."""
    fields = [field_of(name) for name in spec.effects]
    for name, key, wanted in zip(spec.effects, fields, spec.wanted_snr):
        of = rig.effects[name]
        low, high, sign = of.least, of.most, of.sign or int(rng.choice([-1, 1]))
        # nothing is seen of nothing; what a nuisance hides is a hinge
        size, before, seen = math.sqrt(low * high), 0.0, 0.0
        for _ in range(ROUNDS):
            snr = rig.visibility(scene.changed(**{key: sign * size}), key).snr
            if max(snr / wanted, wanted / max(snr, 1e-9)) < CLOSE:
                break
            slope = (snr - seen) / (size - before)
            better = size + (wanted - snr) / slope if slope > 0 else math.inf
            better = float(np.clip(np.clip(better, 0.1 * size, 6.0 * size), low, high))
            if better == size:
                break
            size, before, seen = better, size, snr
        scene = scene.changed(**{key: sign * float(f"{size:.4g}")})
    return scene, [rig.visibility(scene, key) for key in fields]


def _key(spec: Spec, made: MadeCase, seen: list[Visibility]) -> Key:
    rig, scene = RIGS[spec.rig], made.scene
    effects = []
    for name, one in zip(spec.effects, seen):
        of, snr = rig.effects[name], round(one.snr, 3)
        value = float(getattr(scene.worlds[0], field_of(name)))
        if name == FOLLOWS:
            effects.append(_following(rig.follows, made.conditions[0], value, snr))
        else:
            scored = bool(of.unit) and rig.scored(scene, name)
            effects.append(Concealed(name, value, of.unit, snr, of.either, scored))
    noise = asdict(scene.noise) if scene.noise else {}
    others = set(RIGS) - {spec.rig}
    absent = scene.request.absent
    return Key(
        spec.name,
        spec.rig,
        spec.kind,
        tuple(effects),
        # a compound shows in several places; where is then not asked
        rig.effects[spec.effects[0]].sectors if len(effects) == 1 else (),
        spec.separated,
        spec.rendered,
        {k: v if math.isfinite(v) else None for k, v in noise.items()},
        _matters(spec, seen),
        tuple(sorted(k for k in absent if k.split(".")[0] not in others)),
        tuple(c.name for c in made.conditions),
    )


def _following(
    follows: str, condition: Condition, value: float, snr: float
) -> Concealed:
    """A parameter that follows a condition: its slope in the condition's unit; of words
    the greatest difference, halved."""
    slope = value if condition.per is None else value / condition.per
    name = f"{follows}-follows-{condition.name}"
    return Concealed(name, slope, condition.unit, snr, False, bool(condition.unit))


def _matters(spec: Spec, seen: list[Visibility]) -> bool | None:
    """Whether the effects, left out, shift the contact parameter; None: not known."""
    moved = [one.moved for one in seen]
    if not moved or None in moved:
        return None
    off = abs(sum(m for m in moved if m is not None))
    listed = RIGS[spec.rig].effects
    places = any("measurement" in listed[name].sectors for name in spec.effects)
    return True if off > MATTERS else False if off < TRIFLES and not places else None


def make_folder(spec: Spec, seed: int, folder: Path) -> dict:
    """Make the case, write its bench folder unless it is there, return its key as a
    dict (for worker processes)."""
    made, key = conceal(spec, seed)
    if not folder.exists():
        write_bench(made.bench(RIGS[spec.rig]), folder)
    return asdict(key)
