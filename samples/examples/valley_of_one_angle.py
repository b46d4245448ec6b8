"""Which parameter one pile angle leaves open: one equation for three unknowns.

Every point of the posterior gives the bench's angle of repose about as well as any
other: more sliding friction and less rolling friction make the same heap. The paper
reports one point of it; another experiment has to say which."""

import plotly.graph_objects as go

from benchtwin import calibrate

answer = calibrate("samples/soybean-paper", tables=True)
joint = answer.details.joint
draws = joint.posterior.draws.sample(500, random_state=1)
left = joint.table.set_index("factor")["sd_ratio"].filter(like="seed_")
print("share of its standard deviation that the angle leaves each parameter:")
print(left)
x, y = "seed_static_friction", "seed_rolling_friction"
trade_off = joint.posterior.draws[[x, y]].corr().iloc[0, 1]

marker = {"color": draws["seed_restitution"], "colorbar": {"title": "e"}, "size": 5}
picture = go.Figure(go.Scatter(x=draws[x], y=draws[y], mode="markers", marker=marker))
picture.update_layout(xaxis_title="static friction", yaxis_title="rolling friction")
