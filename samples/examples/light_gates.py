"""Rolling resistance from light gates: the same rails, rolled along both ways.

A slope of the table of 0.15° speeds a ball up one way and slows it the other. Each run
alone blames friction for it; the mean of both ways does not, and their difference is
the slope itself."""

import pandas as pd

from benchtwin import measure

found = measure("samples/gates-roll")
table = found.quantities
friction = table[table["quantity"] == "rolling_resistance"]
right, left = (
    friction[friction["recording"].str.startswith(way)]["value"].mean()
    for way in ("right", "left")
)
both_ways = (right + left) / 2
slope_deg = table.query("quantity == 'slope'")["value"].iloc[0]
truth = pd.read_csv("samples/gates-roll/truth.csv").set_index("quantity")["value"]
print(f"to the right {right:.4f}, to the left {left:.4f}, both {both_ways:.4f}")
print(f"the table's slope is {slope_deg:.3f}°, drawn was {truth['slope']}°")

picture = found.plot()
