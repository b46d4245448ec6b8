"""On how many threads a run goes on."""


class Pace:
    """How many threads get on fastest, up to `most`: on a machine that does something
    else too, two wait for each other and are slower than one. What is computed does not
    depend on it."""

    # calls after which the slower number is tried again; a trial's length; share of the
    # past
    TRY_AGAIN = 32
    TRIAL = 0.1
    KEPT = 0.4

    def __init__(self, most: int) -> None:
        self.numbers = (most, 1) if most > 1 else (1,)
        self.calls = 0
        # seconds and ball-steps, the past counting less and less
        self.spent = dict.fromkeys(self.numbers, (0.0, 0.0))

    def next_call(self) -> tuple[int, float]:
        """Number of threads for the next call, and its length as a share of the usual
        one."""
        self.calls += 1
        for number in self.numbers:
            if not self.spent[number][1]:
                return number, self.TRIAL if len(self.numbers) > 1 else 1.0
        fastest = min(
            self.numbers,
            key=lambda number: self.spent[number][0] / self.spent[number][1],
        )
        if len(self.numbers) > 1 and self.calls % self.TRY_AGAIN == 0:
            return self.numbers[1 - self.numbers.index(fastest)], self.TRIAL
        return fastest, 1.0

    def took(self, threads: int, seconds: float, ball_steps: int) -> None:
        """What a call came to."""
        before = self.spent[threads]
        self.spent[threads] = (
            self.KEPT * before[0] + seconds,
            self.KEPT * before[1] + ball_steps,
        )
