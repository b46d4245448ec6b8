"""Drops: flights and impacts."""
