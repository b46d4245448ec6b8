"""How visible an effect is: √Δχ² of its change of the tracks, after the nuisance
parameters were fitted.

    SNR² = sᵀ C⁻¹ s − sᵀ C⁻¹ B (Bᵀ C⁻¹ B + P)⁻¹ Bᵀ C⁻¹ s

s the change, C the noise's covariance, B the tracks' change with each nuisance, P the
nuisances' prior precisions."""

from dataclasses import dataclass

import numpy as np

from benchtwin.prove.cases.noise import Noise, whitened


@dataclass(frozen=True)
class Channel:
    """One coordinate of one recording, each (n, …) in mm: the effect's change; own
    nuisances, with sds; shared ones."""

    change: np.ndarray
    own: np.ndarray
    shared: np.ndarray


@dataclass(frozen=True)
class RecordingChange:
    """One recording: its coordinates, and the sds of its own nuisances (inf: free)."""

    channels: tuple[Channel, ...]
    own_sd: np.ndarray


@dataclass(frozen=True)
class Visibility:
    """moved: error of the contact parameter where the effect is left out, in its
    sds."""

    snr: float
    moved: float | None = None


@dataclass(frozen=True)
class Fitted:
    """SNR of a change, and what the nuisances make of it: shared ones (q,) with their
    sds, and each recording's own."""

    snr: float
    shared: np.ndarray
    shared_sd: np.ndarray
    own: list[np.ndarray]


def fitted(
    recordings: list[RecordingChange], shared_sd: np.ndarray, noise: Noise
) -> Fitted:
    """The change over all recordings; `shared_sd` are the prior sds of what recordings
    share."""
    q, parts = len(shared_sd), []
    corner, side, total = np.diag(_precision(shared_sd)), np.zeros(q), 0.0
    for recording in recordings:
        p = len(recording.own_sd)
        normal, right = np.zeros((p + q, p + q)), np.zeros(p + q)
        normal[:p, :p] = np.diag(_precision(recording.own_sd))
        for c in recording.channels:
            columns = np.column_stack([c.own, c.shared, c.change])
            white = whitened(columns, noise.rho, noise.white, noise.sd)
            basis, signal = white[:, :-1], white[:, -1]
            normal += basis.T @ basis
            right += basis.T @ signal
            total += float(signal @ signal)
        # what is this recording's own is projected out here, so that only the shared
        # ones are carried on
        solved = np.linalg.lstsq(
            normal[:p, :p], np.column_stack([normal[:p, p:], right[:p]]), rcond=1e-12
        )[0]
        corner += normal[p:, p:] - normal[p:, :p] @ solved[:, :-1]
        side += right[p:] - normal[p:, :p] @ solved[:, -1]
        total -= float(right[:p] @ solved[:, -1])
        parts.append(solved)
    inverse = np.linalg.pinv(corner, rcond=1e-12, hermitian=True)
    shared = inverse @ side
    own = [solved[:, -1] - solved[:, :-1] @ shared for solved in parts]
    snr = np.sqrt(max(total - float(side @ shared), 0.0))
    return Fitted(float(snr), shared, np.sqrt(np.diag(inverse).clip(0)), own)


def _precision(sd: np.ndarray) -> np.ndarray:
    return np.where(np.isinf(sd), 0.0, 1 / np.maximum(sd, 1e-300) ** 2)


def scatter_snr(
    change: np.ndarray,
    sd: np.ndarray,
    floating: np.ndarray,
    floating_sd: np.ndarray | None = None,
) -> float:
    """SNR of changes (n,) of independent numbers with sds (n,), `floating` (n, p) free,
    or known to floating_sd (p,)."""
    s, b = change / sd, floating / sd[:, None]
    if floating_sd is not None:
        s = np.r_[s, np.zeros(len(floating_sd))]
        b = np.vstack([b, np.diag(1 / floating_sd)])
    if b.shape[1]:
        s = s - b @ np.linalg.lstsq(b, s, rcond=None)[0]
    return float(np.sqrt(s @ s))


def spread_snr(ratio: float, count: int) -> float:
    """SNR of `count` numbers scattering `ratio` times as much as stated: 2 ln of the
    likelihoods' ratio, expected."""
    return float(
        np.sqrt(max(count * (ratio**2 - 1 - 2 * np.log(max(ratio, 1e-9))), 0.0))
    )
