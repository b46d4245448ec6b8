"""Audit a bench: what it states, what is unknown, what stating it would add.

An absent key is unknown, never zero. The audit lists the keys that a measurement would
use, says what holds where nothing is stated, and which of them a recording asked for by
name."""

from benchtwin import audit

found = audit("samples/heard-drop")
print(found.unknown[["key", "unit", "absent", "asked"]].head(8))
stated = found.keys[found.keys["stated_by"] == found.keys["of"]]["key"].tolist()

picture = found.plot()
