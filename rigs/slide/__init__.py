"""Slides: when a seed begins to move, and how it goes on."""
