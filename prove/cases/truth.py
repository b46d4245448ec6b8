"""What a rig's file hands on: recordings as they will be written, and how visible each effect in them is."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd


@dataclass(frozen=True)
class Wish:
    """What a case shall hold. separated: with the recordings that tell the effect from its twins; None: does not matter. absent:
    keys that the bench will not state, see stated.SHARES."""

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
class Made:
    """One recording: its folder's name, recording.toml's content, and one kind of evidence.

    track: columns of track.csv (or readings.csv when `readings`); frames: (n, h, w) uint8; photos: (h, w) each.
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
    recordings: tuple[Made, ...] = field(default=())


def spread(low: float, high: float, rng: np.random.Generator) -> float:
    """Log-uniform between low and high."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
