"""The box of factors that a design spans, and its two units: natural (a friction of
0.5) and coded (−1 low … +1 high)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from benchtwin.bench.language import tr


@dataclass(frozen=True, eq=False)
class Box:
    """Factors with the natural values that are coded −1 and +1.

    names: k factor names, also the column names in tables; low, high: (k,) natural
    values. Raises ValueError, naming the factor, where low ≥ high, a limit is not
    finite or a name comes twice."""

    names: tuple[str, ...]
    low: np.ndarray
    high: np.ndarray

    def __post_init__(self):
        object.__setattr__(self, "names", tuple(self.names))
        for side in ("low", "high"):
            limits = np.asarray(getattr(self, side), dtype=float)
            if limits.shape != (len(self.names),):
                raise ValueError(
                    tr(
                        "{}: {} factors need as many limits; here are {}",
                        side,
                        len(self.names),
                        limits.size,
                    )
                )
            object.__setattr__(self, side, limits)
        if not self.names:
            raise ValueError(tr("a box needs at least one factor"))
        if len(set(self.names)) < len(self.names):
            raise ValueError(tr("factor names must differ: {}", ", ".join(self.names)))
        for name, low, high in zip(self.names, self.low, self.high):
            here = tr("here are {:g} and {:g}", low, high)
            if not np.isfinite([low, high]).all():
                raise ValueError(tr("{}: limits must be finite; {}", name, here))
            if low >= high:
                raise ValueError(tr("{}: low must be below high; {}", name, here))

    @classmethod
    def of(cls, ranges: Mapping[str, tuple[float, float]]) -> "Box":
        """Box from {name: (low, high)}.

        >>> Box.of({"restitution": (0.55, 0.65)}).natural([[0.5]])
        array([[0.625]])
        """
        low, high = np.array(list(ranges.values()), dtype=float).reshape(-1, 2).T
        return cls(tuple(ranges), low, high)

    @property
    def centre(self) -> np.ndarray:
        return (self.low + self.high) / 2

    @property
    def half_width(self) -> np.ndarray:
        return (self.high - self.low) / 2

    def range(self, name: str) -> tuple[float, float]:
        """A factor's low and high."""
        i = self.names.index(name)
        return float(self.low[i]), float(self.high[i])

    def with_factors(self, other: "Box | None") -> "Box":
        """This box with another's factors behind its own."""
        if other is None:
            return self
        low, high = np.r_[self.low, other.low], np.r_[self.high, other.high]
        return Box((*self.names, *other.names), low, high)

    def coded(self, natural: ArrayLike) -> np.ndarray:
        """Natural (…, k) → coded (…, k)."""
        return (np.asarray(natural, dtype=float) - self.centre) / self.half_width

    def natural(self, coded: ArrayLike) -> np.ndarray:
        """Coded (…, k) → natural (…, k)."""
        return self.centre + np.asarray(coded, dtype=float) * self.half_width

    def points(self, table: pd.DataFrame) -> np.ndarray:
        """The factor columns of a table in natural units, (n, k)."""
        return table[list(self.names)].to_numpy(float)
