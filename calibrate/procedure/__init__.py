"""The steps of a calibration.

bench        read every recording                       bench.py
seed–steel   drop → slide → roll, each curve inverted   steel.py
seed–seed    pile: path, design, surface, optimum       pile.py
together     posterior, what is resolved, what next     joint.py
"""

from benchtwin.calibrate.procedure.calibration import LEVEL, Calibration, parameters
from benchtwin.calibrate.procedure.from_tables import calibrate_tables

__all__ = ["LEVEL", "Calibration", "calibrate_tables", "parameters"]
