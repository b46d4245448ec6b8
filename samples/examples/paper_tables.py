"""A surface fit and a posterior from the tables that a paper printed.

samples/soybean-paper holds the paper's simulations (drops, slides, rolls, 17 piles) and
what it measured on the bench. The calibration is recomputed from them, and what it
finds is compared with what the paper reports."""

from benchtwin import calibrate

answer = calibrate("samples/soybean-paper", tables=True)
table = answer.parameters.set_index("parameter")
print(table[["value", "low", "high", "status"]])
surface = answer.details.surface.surface  # the quadratic response over three factors
reported = {"restitution": 0.54, "static_friction": 0.34}  # the paper's own
held = {
    name: table.loc[name, "low"] < value < table.loc[name, "high"]
    for name, value in reported.items()
}

picture = answer.plot()
