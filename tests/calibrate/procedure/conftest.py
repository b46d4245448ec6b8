"""What calibrations under test share."""

from functools import partial

import pytest

from benchtwin.calibrate.procedure import joint


@pytest.fixture
def few_draws(monkeypatch):
    """A posterior of so few steps that it costs nothing, for tests that ask about what
    comes before it."""
    monkeypatch.setattr(joint, "sample", partial(joint.sample, max_steps=60))
