"""Implausible sizes, masses and densities of a seed are questioned, and used as
stated."""

import pytest

from benchtwin.bench.keys import Seed
from benchtwin.measure.observe import seed_questions
from benchtwin.rigs.roll.inertia import inertia_of


@pytest.mark.parametrize(
    ("seed", "asks"),
    [
        (
            Seed(length_mm=2000, width_mm=2000, thickness_mm=2000),
            ["a seed of 2,000 mm: is it in millimetres?"],
        ),
        (Seed(mass_g=7260), ["a seed of 7,260 g: is it in grams?"]),
        (
            Seed(length_mm=240, width_mm=240, thickness_mm=240, mass_g=600),
            ["240 mm", "600 g", "82.9 kg/m³"],
        ),
        (Seed(length_mm=0.5, width_mm=0.5, thickness_mm=0.5, mass_g=1e-4), []),
        (Seed(length_mm=8, width_mm=7, thickness_mm=6, mass_g=0.2), []),
    ],
)
def test_implausible_seeds_are_questioned(seed, asks):
    said = seed_questions(seed)
    assert len(said) == len(asks) and all(a in s for a, s in zip(asks, said))
    assert inertia_of(seed, None).factor >= 1.3  # and nothing is refused
