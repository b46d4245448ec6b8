"""Effects of the slide, by name."""

from benchtwin.infer.effect import Effect, discovered

EFFECTS: dict[str, Effect] = discovered(__name__, __path__)
