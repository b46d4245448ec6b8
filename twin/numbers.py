"""Numbers as a person reads them, for the packages that know only the twin."""

from benchtwin.vision.numbers import plus_minus, with_interval, with_sd

__all__ = ["plus_minus", "with_interval", "with_sd"]
