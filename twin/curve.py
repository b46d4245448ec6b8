"""What a recording shows, as a line to be laid over that of its twin."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Curve:
    """What a recording shows: y (n,) over x (n,), ascending; where x begins is the
    recording's own, unless `fixed`; frame (n,): numbers of the pictures, None of what
    is not over time."""

    x_name: str
    y_name: str
    x: np.ndarray
    y: np.ndarray
    fixed: bool = False
    frame: np.ndarray | None = None
