"""What a run-out says of rolling friction: Eq. 3 of the soybean paper.

    μ_r = S sin β / (S cos β + L)

S the way on an incline β, L the run-out behind it: an energy balance, for any moment of
inertia, which counts losses to the air and at the corner as friction."""

import math

import numpy as np


def rolling_friction(
    length_mm: float, incline_deg: float, run_out_mm: float
) -> tuple[float, np.ndarray]:
    """μ_r and its derivatives by S [1/mm], β [1/°] and L [1/mm].

    >>> round(rolling_friction(10.0, 15.0, 214.0)[0], 5)
    0.01157
    """
    beta = math.radians(incline_deg)
    below = length_mm * math.cos(beta) + run_out_mm
    value = length_mm * math.sin(beta) / below
    by_beta = (
        length_mm * math.cos(beta) * below + length_mm**2 * math.sin(beta) ** 2
    ) / below**2
    return value, np.array(
        [math.sin(beta) * run_out_mm / below**2, math.radians(by_beta), -value / below]
    )
