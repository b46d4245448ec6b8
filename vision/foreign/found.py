"""What a file of another tool comes down to, whichever tool wrote it."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd


@dataclass(frozen=True)
class Trail:
    """One tracked thing: arrays of one length in the order of time, without gaps; x to the right, y up."""

    name: str
    time: np.ndarray
    x: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class Found:
    """All that a file of `tool` says.

    trails: in `length_unit` (mm or px) and `time_unit` (s or frame). runs: of impact times [s], each by its name. tilt: t_s and
    tilt_deg of a plate. keys: of recording.toml, {section: {key: value}}, that the file states. guesses: what was assumed, and
    why. questions: what the file leaves open, to be asked of its owner. doubt: why its units cannot be what it says they are.
    bare: its lengths have no unit, and nothing tells which; they count as pixels.
    """

    tool: str
    trails: tuple[Trail, ...] = ()
    time_unit: str = "s"
    length_unit: str = "px"
    runs: tuple[tuple[str, np.ndarray], ...] = ()
    tilt: pd.DataFrame | None = None
    keys: dict[str, dict[str, Any]] = field(default_factory=dict)
    guesses: tuple[str, ...] = ()
    questions: tuple[str, ...] = ()
    doubt: str = ""
    bare: bool = False
