"""A case of the proof as a bench and its key."""

from benchtwin.prove.cases.bench import Bench
from benchtwin.prove.make import Key, conceal
from benchtwin.prove.plan import Spec
from benchtwin.prove.rigs import RIGS


def make(spec: Spec, seed: int) -> tuple[Bench, Key]:
    made, key = conceal(spec, seed)
    return made.bench(RIGS[spec.rig]), key
