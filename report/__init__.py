"""report.html: one self-contained file, readable on a phone, on paper, and without a
network."""

from benchtwin.report.page import render, write_report

__all__ = ["render", "write_report"]
