"""Commands as they are typed, with simulations in closed form."""

from contextlib import contextmanager, nullcontext

import pytest
import typer

from benchtwin.calibrate.procedure import simulator as real
from benchtwin.command_line import COMMANDS


@contextmanager
def simulated_by(simulator):
    """What is simulated comes from `simulator`; None: from the campaign."""
    with pytest.MonkeyPatch.context() as patch:
        if simulator is not None:
            patch.setattr(real, "campaign", lambda *_, **__: nullcontext(simulator))
        yield


def command_code(name, simulator=None, *, quiet=False, **options) -> int:
    """The exit code of a command."""
    with simulated_by(simulator), pytest.raises(typer.Exit) as ended:
        COMMANDS[name](progress=not quiet, **options)
    return ended.value.exit_code
