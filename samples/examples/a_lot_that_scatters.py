"""A lot of seeds with scatter, from what callipers gave of a hundred.

Least, mean and greatest of length, width and thickness are all that a paper prints. The
twin draws every seed from a scatter that keeps these, and its mean volume is more than
that of the mean seed, since sizes go together."""

import numpy as np
import plotly.graph_objects as go

from benchtwin.sim.seed.sizes import SOYBEAN

lot = 1e3 * SOYBEAN.sample(np.random.default_rng(1), 4000)  # (n, 3) in mm
length, width, thickness = lot.T
volume = np.pi / 6 * lot.prod(axis=1)
of_the_mean = np.pi / 6 * lot.mean(axis=0).prod()
mean_length, length_sd = length.mean(), length.std(ddof=1)
surplus = volume.mean() / of_the_mean - 1
print(f"length {mean_length:.2f} ± {length_sd:.2f} mm (scatter)")
print(
    f"mean volume {volume.mean():.0f} mm³, {100 * surplus:.1f} % above the mean seed's"
)

picture = go.Figure(
    [
        go.Histogram(x=v, name=n)
        for v, n in ((length, "length"), (width, "width"), (thickness, "thickness"))
    ]
)
picture.update_layout(barmode="overlay", xaxis_title="mm")
picture.update_traces(opacity=0.6)
