"""How often a condition that acts is found in a table of numbers, called by its shape,
and how often one is found where none acts.

Tables of R recordings, usual scatter, each stating a moisture, a pressure and a plate,
in their order; ten kinds of truth at a signal-to-noise ratio from 7 to 20."""

import argparse
from collections.abc import Callable

import numpy as np

from benchtwin.infer.condition_table import Numbers, condition_table
from benchtwin.infer.conditions import Contact, conditions_of

CONTACT = Contact("restitution", "e", 1.0, "impact")
PLATES = ("steel", "glass", "rubber")
LEAST_SNR, MOST_SNR = 7.0, 20.0
Shape = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]  # of u, plate, order
# name → (shape, conditions due, shapes that are right)
TRUTHS: dict[str, tuple[Shape, set[str], set[str]]] = {
    "line": (lambda u, p, o: u, {"moisture_pct"}, {"line"}),
    "falling line": (lambda u, p, o: -u, {"moisture_pct"}, {"line"}),
    "levels off": (
        lambda u, p, o: 1 - np.exp(-6 * u),
        {"moisture_pct"},
        {"levelling off"},
    ),
    "steepens": (
        lambda u, p, o: np.exp(-6 * (1 - u)),
        {"moisture_pct"},
        {"steepening"},
    ),
    "lowest": (lambda u, p, o: (u - 0.5) ** 2, {"moisture_pct"}, {"lowest"}),
    "highest": (lambda u, p, o: -((u - 0.45) ** 2), {"moisture_pct"}, {"highest"}),
    "three levels": (
        lambda u, p, o: np.array([0.0, 0.3, 1.0])[p],
        {"plate"},
        {"levels"},
    ),
    "one other level": (
        lambda u, p, o: np.array([0.0, 0.0, 1.0])[p],
        {"plate"},
        {"levels"},
    ),
    "drift": (lambda u, p, o: o, {"order"}, {"line"}),
    "half stated": (lambda u, p, o: u, {"moisture_pct"}, {"line"}),
    "nothing": (lambda u, p, o: 0 * u, set(), set()),
}


def table(kind: str, count: int, snr: float, rng: np.random.Generator):
    """What is found in one table."""
    x = rng.permutation(np.linspace(8, 20, count)) + rng.uniform(0, 0.3, count)
    pressure = rng.uniform(980, 1030, count)
    plate = rng.permutation(np.arange(count) % len(PLATES))
    u, order = (x - x.min()) / np.ptp(x), np.linspace(0, 1, count)
    shape = TRUTHS[kind][0](u, plate, order)
    stated = np.ones(count, dtype=bool)
    if kind == "half stated":
        stated = np.arange(count) % 2 == 0
    about = np.where(stated, shape - shape[stated].mean(), 0.0)
    size = float(np.sqrt(about @ about))
    y = (snr * about / size if size else about) + rng.standard_normal(count)
    names = tuple(f"r{k:02d}" for k in range(count))
    told = [
        {
            "conditions": {"pressure_mbar": pressure[k], "plate": PLATES[plate[k]]}
            | ({"moisture_pct": x[k]} if stated[k] else {})
        }
        for k in range(count)
    ]
    conditions, _ = conditions_of(names, told, [""] * count)
    numbers = Numbers(names, y, np.eye(count))
    return condition_table(numbers, CONTACT, conditions, rng)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tables", type=int, default=100, help="of each kind")
    parser.add_argument("--recordings", type=int, default=12)
    parser.add_argument("--rng", type=int, default=1)
    asked = parser.parse_args()
    rng = np.random.default_rng(asked.rng)
    print("truth            found  right shape  another found")
    for kind, (_, due, right) in TRUTHS.items():
        found, shaped, wrong = 0, 0, 0
        for _ in range(asked.tables):
            snr = float(np.exp(rng.uniform(np.log(LEAST_SNR), np.log(MOST_SNR))))
            made = table(kind, asked.recordings, snr, rng).found
            hits = [f for f in made if f.condition in due]
            found += bool(hits)
            shaped += bool(hits) and hits[0].shape in right
            wrong += any(not due & {f.condition, *f.as_well} for f in made)
        share = shaped / found if found else np.nan
        print(
            f"{kind:16s} {found / asked.tables:5.2f}  {share:11.2f}"
            f"  {wrong / asked.tables:13.3f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
