"""What a second rig would narrow, before it is built.

The posterior that one pile angle leaves is a sheet. A second observable that depends on
the parameters in another direction cuts through it. For a linear observable with a
known slope the gain is closed form: Bayes' rule for a Gaussian."""

import numpy as np
import plotly.graph_objects as go

from benchtwin import calibrate

answer = calibrate("samples/soybean-paper", tables=True)
draws = answer.details.joint.posterior.draws
names = ["seed_static_friction", "seed_rolling_friction"]
covariance = np.cov(draws[names].to_numpy().T)
before = np.sqrt(np.diag(covariance))

slopes = np.array([30.0, 0.0])  # a rig whose angle sees static friction alone [°]
reading_sd_deg = 0.5
gain = covariance @ slopes / (slopes @ covariance @ slopes + reading_sd_deg**2)
after = np.sqrt(np.diag(covariance - np.outer(gain, slopes @ covariance)))
left = dict(zip(names, after / before, strict=True))
print("share of each standard deviation that a second rig leaves:", left)

picture = go.Figure(
    [
        go.Bar(x=names, y=before, name="one pile angle"),
        go.Bar(x=names, y=after, name="and a second rig"),
    ]
)
picture.update_yaxes(title="standard deviation")
