"""How visible an effect is: √Δχ² of its change of the rows, after the nuisance
parameters were fitted.

    SNR² = sᵀ C⁻¹ s − sᵀ C⁻¹ B (Bᵀ C⁻¹ B + P)⁻¹ Bᵀ C⁻¹ s

s the change, C the noise's covariance, B the rows' change with each nuisance, P the
nuisances' prior precisions."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from benchtwin.prove.cases.noise import Noise, whitened

WHITE = Noise(1.0, 0.0, 1.0, np.inf, 0.0, 1.0, 0.0)  # of rows that are given in sds


@dataclass(frozen=True)
class Change:
    """What an effect makes of one recording, rows (channels, n) in the noise's unit.

    columns: the rows' change with each nuisance; own, shared: sds to which a nuisance
    is known of this recording, of all together (inf: free)."""

    rows: np.ndarray
    columns: dict[str, np.ndarray]
    own: dict[str, float]
    shared: dict[str, float]


@dataclass(frozen=True)
class Fitted:
    """SNR of a change, and what the nuisances make of it: shared ones in sds of their
    estimates, and each recording's own."""

    snr: float
    shared_in_sds: dict[str, float]
    own: list[dict[str, float]]


@dataclass(frozen=True)
class Visibility:
    """moved: error of the contact parameter where the effect is left out, in its
    sds."""

    snr: float
    moved: float | None = None


def fitted(changes: list[Change], noise: Noise) -> Fitted:
    """The change over all recordings."""
    shared_sd = {name: sd for change in changes for name, sd in change.shared.items()}
    solved, left = [], [_priors(shared_sd.values(), 1)]
    for change in changes:
        p = len(change.own)
        names = [*change.own, *shared_sd]
        nothing = np.zeros_like(change.rows)
        parts = [change.columns.get(name, nothing) for name in names]
        own = change.own.values()
        white = np.vstack(
            [
                whitened(np.column_stack(channel), noise.rho, noise.white, noise.sd)
                for channel in zip(*parts, change.rows)
            ]
            + [_priors(own, len(shared_sd) + 1)]
        )
        # what is this recording's own is projected out here, so that only the shared
        # ones are carried on
        solved.append(np.linalg.lstsq(white[:, :p], white[:, p:], rcond=1e-6)[0])
        left.append(white[:, p:] - white[:, :p] @ solved[-1])
    rest = np.vstack(left)
    inverse = np.linalg.pinv(rest[:, :-1].T @ rest[:, :-1], 1e-12, hermitian=True)
    shared = inverse @ rest[:, :-1].T @ rest[:, -1]
    return Fitted(
        float(np.linalg.norm(rest[:, -1] - rest[:, :-1] @ shared)),
        dict(zip(shared_sd, shared / np.sqrt(np.diag(inverse).clip(1e-300)))),
        [
            dict(zip(change.own, one[:, -1] - one[:, :-1] @ shared))
            for change, one in zip(changes, solved)
        ],
    )


def _priors(sds: Iterable[float], others: int) -> np.ndarray:
    """A row for each nuisance, with no entry in `others` further columns."""
    rows = np.diag([1 / sd for sd in sds])
    return np.hstack([rows, np.zeros((len(rows), others))])


def slopes(
    rows: Callable[[Any], np.ndarray], world: Any, steps: dict[str, float]
) -> dict[str, np.ndarray]:
    """Change of the rows of a world with fields of it, by differences of `steps`."""
    base = rows(world)
    return {
        name: (rows(world._replace(**{name: getattr(world, name) + h})) - base) / h
        for name, h in steps.items()
    }


def matched(
    end: Callable[[Any], float], wanted: float, world: Any, **between: tuple
) -> Any:
    """The world whose one field, `between` two values, makes it end as wanted; the
    world itself where none does."""
    ((name, ends),) = between.items()

    def off(value: float) -> float:
        return end(world._replace(**{name: value})) - wanted

    if off(ends[0]) * off(ends[1]) >= 0:
        return world
    return world._replace(**{name: brentq(off, *ends, xtol=1e-6)})
