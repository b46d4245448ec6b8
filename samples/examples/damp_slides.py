"""Conditions: what friction follows when seeds differ in moisture.

Each recording states a condition, [conditions] moisture_pct, and it becomes a column of
every table. A straight line through the measured frictions tells how much a per cent of
moisture changes."""

import numpy as np
import plotly.graph_objects as go

from benchtwin import measure

found = measure("samples/damp-slides")
table = found.table.dropna(subset="static_friction")
films = table[table["recording"].str.startswith("film")]
moisture, friction = films["moisture_pct"], films["static_friction"]
(per_pct, at_zero), covariance = np.polyfit(moisture, friction, 1, cov=True)
per_pct_sd = np.sqrt(covariance[0, 0])
print(f"static friction changes by {per_pct:+.4f} ± {per_pct_sd:.4f} a per cent")

line = np.array([moisture.min(), moisture.max()])
dots = go.Scatter(x=moisture, y=friction, mode="markers", name="measured")
fit = go.Scatter(x=line, y=at_zero + per_pct * line, mode="lines", name="fit")
picture = go.Figure([dots, fit])
picture.update_layout(xaxis_title="moisture (%)", yaxis_title="static friction")
