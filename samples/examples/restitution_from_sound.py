"""Restitution from the sound of a bouncing seed, without a camera.

Between two impacts a seed flies up and down again, for t = 2 v/g. The ratio of
successive flights is the coefficient of restitution, and no length is needed. The
recordings were drawn, and samples/heard-drop/truth.csv says with which restitution."""

import pandas as pd

from benchtwin import measure

found = measure("samples/heard-drop")
heard = found.quantities.query("quantity == 'restitution_normal'")
truth = pd.read_csv("samples/heard-drop/truth.csv").query(
    "quantity == 'restitution_normal'"
)
both = heard.merge(truth, on="recording", suffixes=("", "_true"))
both["off_in_sds"] = (both["value"] - both["value_true"]) / both["sd"]
print(both[["recording", "value", "sd", "value_true", "off_in_sds"]])

picture = found.picture("drop-01")
