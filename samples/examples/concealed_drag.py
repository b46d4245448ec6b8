"""Diagnose what six drops conceal: their recordings state no air.

No restitution explains the tracks: each flight falls too slowly, and the more so the
faster it is. The diagnosis weighs every effect that it knows against the recordings and
names one. Run samples/concealed.py reveal samples/concealed-drop afterwards."""

from benchtwin import diagnose

missing = diagnose("samples/concealed-drop")
verdict = missing.verdicts.iloc[0]
print(*missing.in_words, sep="\n")
sizes = missing.effects[missing.effects["effect"] == verdict["names"].split(", ")[0]]

picture = missing.plot()
