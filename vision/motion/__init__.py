"""Frames or tracks → what a drop, a slide, a roll is read for."""
