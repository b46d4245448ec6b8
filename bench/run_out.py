"""What a run-out says of rolling friction: Eq. 3 of the soybean paper where θ = 0.

    μ_r = (S sin β + L sin θ) / (S cos β + L cos θ)

S the way on an incline β, L the run-out behind it on a plate that falls by θ along the
way: an energy balance, for any moment of inertia, which counts losses to the air and at
the corner as friction."""

import numpy as np


def rolling_friction(
    length_mm: float, incline_deg: float, run_out_mm: float, falls_deg: float = 0.0
) -> tuple[float, np.ndarray]:
    """μ_r and its derivatives by S [1/mm], β [1/°], L [1/mm] and θ [1/°].

    >>> round(rolling_friction(10.0, 15.0, 214.0)[0], 5)
    0.01157
    """
    ways, angles = (
        np.array([length_mm, run_out_mm]),
        np.radians([incline_deg, falls_deg]),
    )
    sin, cos = np.sin(angles), np.cos(angles)
    down, along = float(ways @ sin), float(ways @ cos)
    by_way = (sin * along - down * cos) / along**2
    by_angle = np.radians(ways * (cos * along + down * sin) / along**2)
    return down / along, np.array([by_way[0], by_angle[0], by_way[1], by_angle[1]])
