"""report.html: one self-contained file, readable on a phone, on paper, and without a
network."""
