"""One simulated run as data: everything that decides its outcome, the key that it is
known by, and how to run it."""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import partial
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import numpy as np

from benchtwin.bench.rigs import RIGS, VARIANTS
from benchtwin.sim.ondem import STATE
from benchtwin.sim.ondem.read import read_state
from benchtwin.sim.rigs.bench import no_watch
from benchtwin.sim.rigs.filling import Filled
from benchtwin.twin.engine import OWN, Engine
from benchtwin.twin.lot import file_digest, lot_digest
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.run import MODEL, RECORD, simulate
from benchtwin.twin.scene import rig_of, setup_of
from benchtwin.vision.evidence.read_keys import merge, read_toml, validate
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording, read_recording

SECTIONS = ("seed", "camera", "air", *RIGS)
RIG_NAMES = (*RIGS, *VARIANTS)


@dataclass(frozen=True)
class Job:
    """rig; parameters; description: sections of a recording.toml as {"section": {"key":
    value}}; rng: seed numbers of the generator; rendered or not; the engine that
    computes it; start: a file with the heap to begin with. Two jobs of one key
    give the same recording."""

    rig: str
    parameters: Parameters
    description: dict = field(default_factory=dict)
    rng: tuple[int, ...] = (1,)
    rendered: bool = True
    engine: Engine = OWN
    start: Path | None = None

    def __post_init__(self) -> None:
        if self.rig not in RIGS:
            raise ValueError(f"rig = {self.rig!r}: one of {', '.join(RIGS)}")
        # so that a rig that does not fit is refused before anything runs
        rig_of(self.recording(Path("job")))
        if self.start is not None:
            self._check_start(self.start)

    @property
    def heaps(self) -> bool:
        """Whether it can begin with a heap."""
        return setup_of(self.recording(Path("job"))).begins

    def _check_start(self, start: Path) -> None:
        if not self.heaps:
            what = "only a pile or cylinder can begin with a heap"
            raise ValueError(f"--start: {what}, not a {self.rig}")
        read_state(start)

    @property
    def input(self) -> dict:
        """All of it as plain JSON values."""
        told = {name: values for name, values in self.description.items() if values}
        return {
            "model": MODEL,
            "rig": self.rig,
            "parameters": self.parameters.for_rig(self.rig).to_dict(),
            "description": told,
            "rng": list(self.rng),
            "rendered": self.rendered,
            **self.engine.for_rig(self.rig).told,
            **({"start": file_digest(self.start)} if self.start else {}),
        }

    @property
    def key(self) -> str:
        """SHA-256 of the canonical JSON of `input`, 16 hexadecimal digits."""
        text = json.dumps(
            self._identity(), sort_keys=True, separators=(",", ":"), ensure_ascii=False
        )
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def _identity(self) -> dict:
        """`input` with what a lot or a mesh holds in the place of where it lies."""
        told = self.input
        seed = told["description"].get("seed", {})
        digests = {
            name: of(Path(seed[name]))
            for name, of in (("lot", lot_digest), ("shape", file_digest))
            if name in seed
        }
        return (
            told | {"description": told["description"] | {"seed": seed | digests}}
            if digests
            else told
        )

    def recording(self, out: Path) -> Recording:
        """The recording to be like, without evidence."""
        known = validate(self.description, Path("settings"))
        told = {name: getattr(known, name) for name in SECTIONS}
        return Recording(out.name, out, self.rig, "", (), **told)

    def run(
        self,
        out: Path,
        *,
        watch: Callable[[str, float], None] = no_watch,
        threads: int = 2,
        save: bool = False,
    ) -> Recording:
        """Run it into `out`, or read what is there when that is this very job;
        FileExistsError for anything else. save: with state.vtkhdf."""
        if out.exists():
            if save and not (out / STATE).is_file():
                raise FileExistsError(
                    f"{out} is there already, without {STATE}; choose another --out"
                )
            if self.is_done(out):
                return read_recording(out)
            raise FileExistsError(
                f"{out} is there already, and is not this run; choose another --out"
            )
        rng = np.random.default_rng(list(self.rng))
        like = self.recording(out)
        more = {"key": self.key, "input": self.input}
        return simulate(
            self.rig,
            self.parameters,
            rng=rng,
            out=out,
            like=like,
            rendered=self.rendered,
            watch=watch,
            threads=threads,
            engine=self.engine,
            more=more,
            save=save,
            lying=self._lying(),
        )

    def _lying(self) -> Filled | None:
        """The heap to begin with."""
        if self.start is None:
            return None
        saved = read_state(self.start)
        return Filled(saved.shapes, saved.shape_of, saved.positions, saved.orientations)

    def converted(self) -> tuple[str, ...]:
        """What its engine converts of the law; ValueError for a law or a rig that the
        engine has not."""
        return self.engine.bench(self.parameters, self.recording(Path("job")))[1]

    def is_done(self, out: Path) -> bool:
        """Whether `out` holds this job's recording."""
        try:
            return (
                json.loads((out / RECORD).read_text(encoding="utf8")).get("key")
                == self.key
            )
        except (OSError, ValueError):
            return False


def described(file: Path) -> tuple[str | None, dict]:
    """Rig and description in a recording.toml (or the folder that holds it), bench.toml
    beside its folder included."""
    file = file / "recording.toml" if file.is_dir() else file
    if not file.is_file():
        raise MeasurementError(f"{file}: no such file")
    defaults = file.parent.parent / "bench.toml"
    content = merge(read_toml(defaults) if defaults.is_file() else {}, read_toml(file))
    return content.get("rig"), {
        name: content[name] for name in SECTIONS if name in content
    }


def assigned(
    parameters: Parameters, description: dict, settings: Mapping[str, Any]
) -> tuple[Parameters, dict]:
    """Both with {key: value} applied: section.key of recording.toml, a field of
    `Parameters`, or laws.NAME.NUMBER."""
    names = {f.name for f in fields(Parameters)}
    for key, value in settings.items():
        path = [part.strip() for part in key.split(".")]
        if path[0] == "laws" and len(path) == 3:
            laws = {
                **parameters.laws,
                path[1]: {**parameters.laws.get(path[1], {}), path[2]: value},
            }
            parameters = replace(parameters, laws=laws)
        elif len(path) == 1 and path[0] in names - {"laws"}:
            parameters = _with(parameters, path[0], value)
        elif len(path) == 2 and path[0] in SECTIONS:
            description = merge(description, {path[0]: {path[1]: value}})
            validate(description, Path(f"setting {key} = {value}"))
        else:
            known = (
                f"{', '.join(sorted(names - {'laws'}))}, laws.NAME.NUMBER, or KEY of"
                f" recording.toml as {'|'.join(SECTIONS)}.KEY"
            )
            raise ValueError(f"setting {key}: unknown key {key}; known are {known}")
    return parameters, description


def _with(parameters: Parameters, name: str, value: Any) -> Parameters:
    """A field changed; ValueError for a value of another kind."""
    before = getattr(Parameters(), name)
    kind: type = type(before) if isinstance(before, str | int) else float
    number = isinstance(value, Real) and not isinstance(value, bool)
    fits = {
        str: isinstance(value, str),
        bool: isinstance(value, bool),
        int: number and isinstance(value, Integral),
        float: number,
    }
    if not fits[kind]:
        said = {
            str: "word",
            bool: "true or false",
            int: "whole number",
            float: "number",
        }[kind]
        raise ValueError(f"setting {name} = {value}: must be a {said}")
    changed: dict[str, Any] = {name: kind(value)}
    return replace(parameters, **changed)


def rig_named(name: str) -> tuple[str, dict]:
    """The rig behind a name that `simulate` knows, and the keys that the name stands
    for."""
    variant = VARIANTS.get(name)
    return (variant.name, dict(variant.variants[name])) if variant else (name, {})


def jobs(
    rig: str,
    parameters: Parameters,
    description: dict,
    *,
    repeats: int,
    rng: int,
    rendered: bool,
    engine: Engine = OWN,
    start: Path | None = None,
) -> list[Job]:
    """One job a repeat, each with its own generator, and with the keys that the rig's
    runs have by turns."""
    kind, default = rig_named(rig)
    description = merge(default, description)
    make = partial(Job, kind, parameters, rendered=rendered, engine=engine, start=start)
    own, rig_of_kind = description.get(kind, {}), RIGS[kind]
    turns = [description | {kind: rig_of_kind.turn(k, own)} for k in range(repeats)]
    return [make(description=d, rng=(rng, k)) for k, d in enumerate(turns)]
