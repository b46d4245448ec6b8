"""How far a campaign is, and how long it will take."""

import math
import time
from collections import defaultdict
from dataclasses import dataclass

from benchtwin.twin.campaign.results import FAILED, Outcome


@dataclass(frozen=True)
class Progress:
    """Jobs, each key once.

    finished: with an outcome, `found` and `failed` ones included; elsewhere: another
    campaign has them; left: without an outcome, running and elsewhere included; left_s:
    NaN as long as nothing is known."""

    total: int
    finished: int
    found: int
    failed: int
    running: int
    elsewhere: int
    left_s: float

    @property
    def left(self) -> int:
        return self.total - self.finished

    def __str__(self) -> str:
        parts = [f"{self.finished} of {self.total} done"]
        parts += [
            f"{n} {what}"
            for n, what in ((self.failed, "failed"), (self.running, "running"))
            if n
        ]
        parts += [f"{self.elsewhere} in another campaign"] if self.elsewhere else []
        if self.left and math.isfinite(self.left_s):
            parts.append(
                f"about {self.left_s:.0f} s left"
                if self.left_s < 90
                else f"about {self.left_s / 60:.0f} min left"
            )
        return ", ".join(parts)


class Tally:
    """Counts outcomes, and estimates the time left from what jobs of the same kind
    took, here or when they were stored."""

    def __init__(self, kinds: dict[str, str]) -> None:
        self.kinds = kinds  # of every key
        self.open = set(kinds)
        self.found = self.failed = 0
        self.took: dict[str, list[float]] = defaultdict(list)
        self.last = time.monotonic()

    def add(self, outcome: Outcome, *, found: bool) -> None:
        self.open.discard(outcome.key)
        self.found += found
        self.failed += outcome.status == FAILED
        self.last = self.last if found else time.monotonic()
        if math.isfinite(outcome.seconds):
            self.took[self.kinds[outcome.key]].append(outcome.seconds)

    def progress(self, slots: int, elsewhere: int) -> Progress:
        """slots: jobs that run at a time."""
        now = time.monotonic()
        running = max(0, min(slots, len(self.open) - elsewhere))
        return Progress(
            len(self.kinds),
            len(self.kinds) - len(self.open),
            self.found,
            self.failed,
            running,
            elsewhere,
            self._left_s(slots, running, now - self.last),
        )

    def _left_s(self, slots: int, running: int, since_last_s: float) -> float:
        means = {kind: sum(values) / len(values) for kind, values in self.took.items()}
        if not self.open:
            return 0.0
        if not means or not slots:
            return math.nan
        others = sum(means.values()) / len(means)  # a kind that none has finished of
        each = [means.get(self.kinds[key], others) for key in self.open]
        under_way = running * min(since_last_s, sum(each) / len(each))
        return max(0.0, sum(each) - under_way) / min(slots, len(each))
