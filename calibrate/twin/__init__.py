"""The bridge: bench and twin seen through the same eyes. The only place that knows both the measuring and the simulating.

from calibrate.twin import Parameters, observe, simulate

recording = simulate("drop", Parameters(restitution=0.6), rng=np.random.default_rng(1), out=Path("twin/drop-01"))
for q in observe(recording).quantities:
    print(q.name, q.value, q.sd, q.unit)
"""

from calibrate.twin.parameters import Parameters
from calibrate.twin.run import observe, simulate

__all__ = ["Parameters", "observe", "simulate"]
