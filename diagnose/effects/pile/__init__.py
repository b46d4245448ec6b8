"""Effects of the pile, by name."""

from benchtwin.diagnose.effects.effect import discovered
from benchtwin.diagnose.effects.pile.shapes import HeapEffect

EFFECTS: dict[str, HeapEffect] = {
    n: e for n, e in discovered(__name__, __path__).items() if isinstance(e, HeapEffect)
}
