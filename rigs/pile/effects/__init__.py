"""Effects of the pile, by name."""

from benchtwin.infer.effect import discovered
from benchtwin.rigs.pile.effects.shapes import HeapEffect

EFFECTS: dict[str, HeapEffect] = {
    n: e for n, e in discovered(__name__, __path__).items() if isinstance(e, HeapEffect)
}
