"""Effects of the pile, by name."""

from benchtwin.infer.effect import discovered
from benchtwin.rigs.pile.effects.shapes import HeapEffect

EFFECTS: dict[str, HeapEffect] = discovered(__name__, __path__, HeapEffect)
