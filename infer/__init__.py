"""Statistics of a diagnosis: explanations are fitted, weighed and judged, whatever the
rig."""
