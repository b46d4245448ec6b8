"""Noise that is correlated: what it does to an interval.

A track's errors are alike from frame to frame: a highlight or a shadow moves slowly.
Who takes n correlated rows for n independent ones states an sd that is too small, by
√((1 + ρ)/(1 − ρ)) for a mean of AR(1) noise."""

import numpy as np
import plotly.graph_objects as go

ROWS, RHO, REPEATS = 400, 0.8, 2000
rng = np.random.default_rng(1)
white = rng.normal(0.0, np.sqrt(1 - RHO**2), (REPEATS, ROWS))
noise = np.empty_like(white)
noise[:, 0] = rng.normal(0.0, 1.0, REPEATS)
for k in range(1, ROWS):
    noise[:, k] = RHO * noise[:, k - 1] + white[:, k]

means = noise.mean(axis=1)
stated = noise.std(axis=1, ddof=1) / np.sqrt(ROWS)  # as if rows were independent
too_small = means.std(ddof=1) / stated.mean()
by_formula = np.sqrt((1 + RHO) / (1 - RHO))
held = (np.abs(means) < 1.96 * stated).mean()
rho_seen = (noise[:, 1:] * noise[:, :-1]).sum(axis=1) / (noise**2).sum(axis=1)
honest = stated * np.sqrt((1 + rho_seen) / (1 - rho_seen))
held_honestly = (np.abs(means) < 1.96 * honest).mean()
print(f"too small by {too_small:.2f} ({by_formula:.2f} by the formula)")
print(f"95 % intervals hold {100 * held:.0f} %; mended, {100 * held_honestly:.0f} %")

picture = go.Figure(go.Scatter(y=noise[0], name="AR(1)"))
picture.add_scatter(y=4 + white[0] / white[0].std(), name="independent")
picture.update_layout(xaxis_title="row", yaxis_title="error (sds)")
