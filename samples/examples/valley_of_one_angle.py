"""Which parameter one pile angle leaves open: one equation for three unknowns.

Every point of the sheet gives the bench's angle of repose as well as any other: more
sliding friction and less rolling friction make the same heap. The paper reports one
point of it; another experiment has to say which."""

import plotly.graph_objects as go

from benchtwin import calibrate

answer = calibrate("samples/soybean-paper", tables=True)
pile = answer.details.pile
sheet = pile.sheet.table
x, y = "seed_static_friction", "seed_rolling_friction"
spans = {
    name: (sheet[name].max() - sheet[name].min()) / (high - low)
    for name, low, high in zip(pile.box.names, pile.box.low, pile.box.high, strict=True)
}
print("share of its range that each parameter may take:", spans)
trade_off = sheet[[x, y]].corr().iloc[0, 1]

marker = {"color": sheet["seed_restitution"], "colorbar": {"title": "e"}, "size": 5}
picture = go.Figure(go.Scatter(x=sheet[x], y=sheet[y], mode="markers", marker=marker))
picture.update_layout(xaxis_title="static friction", yaxis_title="rolling friction")
