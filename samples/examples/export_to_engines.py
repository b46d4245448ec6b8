"""Take calibrated parameters to LAMMPS, LIGGGHTS and YADE, in their own conventions.

A calibration knows its convention of rolling friction, its moduli and its time step;
the cards convert what the other engine defines in another way and say so."""

import tempfile

import plotly.graph_objects as go

from benchtwin import calibrate, export

answer = calibrate("samples/soybean-paper", tables=True, out=tempfile.mkdtemp())
cards = {e: export(answer, e) for e in ("lammps", "liggghts", "yade")}
for engine, card in cards.items():
    print(engine, *card.texts)
lines = {
    e: sum(t.count("\n") for t in card.texts.values()) for e, card in cards.items()
}
text = "\n".join(cards["lammps"].texts.values())

picture = go.Figure()
head = [line for line in text.splitlines() if line.strip()][:18]
for row, line in enumerate(head):
    look = {"size": 11, "family": "monospace"}
    place = {"x": 0, "y": -row, "xanchor": "left", "showarrow": False}
    picture.add_annotation(text=line[:90], font=look, **place)
picture.update_xaxes(visible=False, range=[0, 1])
picture.update_yaxes(visible=False, range=[-len(head), 1])
