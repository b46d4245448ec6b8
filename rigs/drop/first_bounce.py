"""Restitution of a drop's first bounce, of which only the stated height tells the
speed, together with what the later bounces tell of themselves.

    e_k = a + b ln(v_k/v₁) + c [k > 1] + u_k,    e₁ as read = e₁ √(1 + δ/H)

a, b, c (a seed lies flat at first) and δ, the error of the height H, have priors, the
scatter u an unknown sd, over which is averaged. All is linear in normal numbers: the
posterior is that of Gaussian processes (Rasmussen & Williams 2006, eq. 2.23)."""

from dataclasses import dataclass

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.priors import unstated_sd

USUAL = 0.5  # centre of the prior of restitution
SCATTERS = np.geomspace(1.0, 100.0, 25)  # of the least, each as likely
CONTRADICTION_SDS = 2.0


def first_flat_sd(elongation: float, *, spun: bool = False) -> float:
    """By how much the restitution of a seed that is let go flat differs from that of
    its later impacts; spun: where the spin of the seed is known."""
    return 0.002 + (0.55 if spun else 0.8) * elongation**2


@dataclass(frozen=True)
class FirstBounce:
    """Restitution with sd, and by_height, its change [1] with one sd of the height;
    low_mm, low_sd_mm: by how much the height is stated too low, by the later bounces
    alone."""

    value: float
    sd: float
    by_height: float
    low_mm: float
    low_sd_mm: float

    def doubt(self, height_sd_mm: float) -> str:
        """Why the stated height is not believed; "" where it may be."""
        if abs(self.low_mm) < max(CONTRADICTION_SDS * self.low_sd_mm, height_sd_mm):
            return ""
        side = (
            tr("low") if self.low_mm > 0 else tr("high, or the first impact is missing")
        )
        return tr(
            "the stated height is {:.2g} ± {:.1g} mm {}, if restitution is that of the"
            " later bounces",
            abs(self.low_mm),
            self.low_sd_mm,
            side,
        )


def first_bounce(
    e: np.ndarray,
    error: np.ndarray,
    speed: np.ndarray,
    height_mm: float,
    height_sd_mm: float,
    flat_sd: float,
) -> FirstBounce:
    """e (n,) as read, with the covariance `error` of all but the height; speed (n,)
    before each; flat_sd: by how much first bounces differ from later ones."""
    later = np.arange(len(e)) > 0
    ln = np.log(speed / speed[0])
    alike = unstated_sd("restitution") ** 2 + np.outer(later, later) * flat_sd**2
    alike = alike + unstated_sd("restitution-with-speed") ** 2 * np.outer(ln, ln)
    per_mm = e[0] / (2 * height_mm)  # of e as read
    mean, sd, by_height = _posterior(e, error, alike, per_mm * height_sd_mm)
    low, low_sd, _ = _posterior(e, error, alike, per_mm * height_mm)
    true = 1 - min(low[1] / 2, 0.9)  # e₁ over e₁ as read, whose square the heights have
    return FirstBounce(
        mean[0],
        sd[0],
        by_height,
        height_mm * (true**-2 - 1),
        height_mm * low_sd[1] * true**-3,
    )


def _posterior(
    e: np.ndarray, error: np.ndarray, alike: np.ndarray, by_height: float
) -> tuple[list[float], list[float], float]:
    """Means and sds of e₁ and of the height's error in its prior sds, which changes e₁
    as read by `by_height`; and by how much it changes the mean of e₁."""
    first = np.zeros(len(e))
    first[0] = by_height
    off = e - USUAL
    ln_weight, found = [], []
    for s in unstated_sd("bounce-scatter") * SCATTERS:
        true = alike + s**2 * np.eye(len(e))
        whole = true + error + np.outer(first, first)
        told = np.column_stack([true[0], first])  # covariances with e as read
        gain = np.linalg.solve(whole, told).T
        ln_det = np.linalg.slogdet(whole)[1]
        ln_weight.append(-0.5 * (ln_det + off @ np.linalg.solve(whole, off)))
        variance = [true[0, 0], 1.0] - (gain * told.T).sum(axis=1)
        found.append([*(gain @ off + [USUAL, 0.0]), *variance, gain[0] @ first])
    weight = np.exp(np.array(ln_weight) - max(ln_weight))
    values = np.array(found)
    mean = np.average(values, axis=0, weights=weight)
    spread = np.average((values - mean)[:, :2] ** 2, axis=0, weights=weight)
    sd = np.sqrt(mean[2:4] + spread)
    return mean[:2].tolist(), sd.tolist(), float(abs(mean[4]))
