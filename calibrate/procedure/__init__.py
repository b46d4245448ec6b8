"""The steps of a calibration.

bench        read every recording                                bench.py
seed–steel   drop → slide → roll, each alone                     steel.py
seed–seed    a design, then runs where they tell most            seed_runs.py
together     one posterior, what next                            joint.py
check        the most probable set, simulated                    check.py
published    path, Box–Behnken, variance, optimum                surface.py
"""

from benchtwin.calibrate.procedure.calibration import LEVEL, Calibration, parameters
from benchtwin.calibrate.procedure.from_tables import calibrate_tables

__all__ = ["LEVEL", "Calibration", "calibrate_tables", "parameters"]
