"""Which of the flights that a track was cut into are free ones: what rocks, rolls or leaves the picture has lowest points too."""

import numpy as np

SCATTER = 6.0  # times what the first two scatter: no parabola
FREE_SHARE, FREE_SD = 0.3, 5.0  # of its fall, and in its sds: by how much a flight may differ from the first two; air does less
PLATE_SHARE = 0.15  # of the track's height: contacts lie no farther from its lowest place, however the seed lies there


def free_flights(
    rows: tuple[np.ndarray, ...],
    time: np.ndarray,
    height: np.ndarray,
    residual: np.ndarray,
    meets: list[tuple[float, float]],
    step_s: float,
) -> int:
    """How many flights to keep: those before the first (after two) that is no parabola, falls otherwise or ends in mid-air."""
    return min(_like_the_first(rows, residual), _falling(rows, time, height), _at_plate(meets, height, step_s))


def _like_the_first(rows, residual: np.ndarray) -> int:
    """How many flights to keep: up to the first (after two) that scatters SCATTER times what the first two do."""
    parts = np.split(residual, np.cumsum([len(r) for r in rows])[:-1])
    scatter = [float(np.sqrt(np.median(p**2))) for p in parts]
    usual = max(scatter[:2])
    return next((k for k in range(2, len(rows)) if scatter[k] > SCATTER * usual), len(rows))


def _falling(rows, time: np.ndarray, height: np.ndarray) -> int:
    """How many flights to keep: up to the first (after two) that does not fall as the first two do. A seed that rocks or rolls to
    rest has lowest points too."""
    gammas, sds = np.array([_fall(time[r], height[r]) for r in rows]).T
    weight = 1 / np.maximum(sds[:2], 1e-12) ** 2
    if not weight.any():
        return len(rows)
    usual = float((weight * gammas[:2]).sum() / weight.sum())
    off = np.abs(gammas - usual) > FREE_SHARE * abs(usual) + FREE_SD * sds
    return next((k for k in range(2, len(rows)) if off[k]), len(rows))


def _at_plate(meets: list[tuple[float, float]], height: np.ndarray, step_s: float) -> int:
    """How many flights to keep: up to the first contact that is not at the plate. Where a seed left the picture and came back
    there were more contacts than one. meets: height and speed at each contact."""
    plate, reach = np.quantile(height, 0.01), np.ptp(height)
    off = [abs(h - plate) > PLATE_SHARE * reach + step_s * abs(v) for h, v in meets]
    return off.index(True) + 1 if any(off) else len(meets) + 1


def _fall(time: np.ndarray, height: np.ndarray) -> tuple[float, float]:
    """γ of one flight by itself and its sd, successive rows erring together; of fewer than 6 rows nothing is known."""
    if len(time) < 6:
        return 0.0, np.inf
    tau = (time - time.mean()) / np.ptp(time)
    design = np.column_stack([np.ones_like(tau), tau, -(tau**2) / 2])
    params = np.linalg.lstsq(design, height, rcond=None)[0]
    left = height - design @ params
    power = float((left**2).sum()) / (len(tau) - 3)
    rho = float(np.clip((left[1:] * left[:-1]).sum() / max((left**2).sum(), 1e-300), 0.0, 0.99))
    sd = np.sqrt(power * (1 + rho) / (1 - rho) * np.linalg.inv(design.T @ design)[2, 2])
    return float(params[2] / np.ptp(time) ** 2), float(sd / np.ptp(time) ** 2)
