"""Terms of no candidate's, few and common to all drops: they see what nobody listed where curves of each flight see too little.

In flight: forces along x and z that are constant or grow with the place or the speed; a force knows nothing of the time since the
release. Of the camera: its lens, and a clock that drifts,  t' = t + c t²,  by which a seed seems pushed by 4 c t g − 2 c v.
"""

import numpy as np

from calibrate.diagnose.air import G_M_S2
from calibrate.diagnose.drop.windows import axes_of, flown
from calibrate.diagnose.problem import Fit

LENS = "lens"  # with this begin the names of the nuisances that are the camera's terms


def pushes_of(part: Fit) -> np.ndarray:
    """(K, F, POINTS, 2): accelerations of one session, of unit size where they are usual; the last is the clock's."""
    axes, (places, speeds) = axes_of(part), flown(part)
    late, speed = axes["t_s"][..., None], axes["v_m_s"][..., None]
    grow = [np.ones_like(speed), axes["z_mm"][..., None] / 1000, speed, places[..., :1] - places[..., :1].mean()]
    ways = np.array([1.0, 0.0]), np.array([0.0, 1.0])
    return np.array([*(size * way for size in grow for way in ways), 4 * late * G_M_S2 * ways[1] - 2 * speeds])
