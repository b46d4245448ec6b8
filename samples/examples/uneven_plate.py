"""Diagnose rolls on a plate that is called level and is not.

Rolls one way run out farther than rolls the other way, by more than seeds scatter. The
diagnosis names the slope, gives its size, and says what it would do to the rolling
friction of who leaves it out. What was measured is handed on: no film is read twice."""

from benchtwin import diagnose, measure

found = measure("samples/concealed-roll")
missing = diagnose(found)
slope = missing.effects.query("effect == 'slope'").iloc[0]
print(*missing.in_words, sep="\n")
low_deg, high_deg = slope["low95"], slope["high95"]

picture = missing.plot()
