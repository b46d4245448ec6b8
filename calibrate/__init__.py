"""Bench recordings and their simulated twin → contact parameters.

from benchtwin.calibrate.procedure import calibrate_tables, parameters

print(parameters(calibrate_tables("samples/soybean-paper")))
"""
