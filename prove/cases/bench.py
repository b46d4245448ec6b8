"""What a case shall hold, and a bench folder before it is written."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd


@dataclass(frozen=True)
class Request:
    """What a case shall hold.

    separated: with the recordings that tell the effect from those confounded with it; None: either.
    rendered: pictures instead of tracks. absent: keys that the bench will not state.
    """

    effects: tuple[str, ...] = ()
    separated: bool | None = None
    rendered: bool = False
    absent: frozenset[str] = frozenset()

    def known(self, key: str, stated: float, unstated: float) -> float:
        """The sd to which a quantity is known: as stated, or as benches have it where `key` is left out."""
        return unstated if key in self.absent else stated

    def sizes_known(self) -> bool:
        return not self.absent & {"seed.sizes", "seed.mass_g"}


@dataclass(frozen=True, eq=False)
class Recording:
    """One recording: folder, recording.toml, and one kind of evidence.

    track, readings: columns of their files; frames: (n, h, w) uint8; photos: (h, w) each.
    """

    name: str
    toml: dict
    track: pd.DataFrame | None = None
    readings: pd.DataFrame | None = None
    frames: tuple[np.ndarray, ...] = ()
    photos: tuple[np.ndarray, ...] = ()


@dataclass(frozen=True)
class Bench:
    """A bench folder: bench.toml's content and the recordings."""

    toml: dict
    recordings: tuple[Recording, ...] = field(default=())


def log_uniform(low: float, high: float, rng: np.random.Generator) -> float:
    """Log-uniform between low and high."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
