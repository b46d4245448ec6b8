"""Posteriors with chosen probabilities, to test what is said of them."""

from types import SimpleNamespace

from benchtwin.infer.evidence import Kind
from benchtwin.infer.explanation import Alternative, Explanation, Posterior


def posterior(
    sets: dict[tuple[str, ...], float],
    p_noise: float,
    *,
    recordings: int = 8,
    sizes: dict[str, tuple[float, float]] | None = None,
) -> Posterior:
    """Explanations with these weights, () among them; names that begin with a bracket
    are unlisted. sizes: mean and sd of effects, 1 ± 0.1 where there is none."""
    sizes = sizes or {}

    def effect(name: str) -> SimpleNamespace:
        size = sizes.get(name, (1.0, 0.1))
        return SimpleNamespace(summary=lambda e: size, level="", reported=None, unit="")

    every = {n for names in sets for n in names}
    problem = SimpleNamespace(
        columns_of=lambda name: (name,),
        recordings=tuple(f"drop-{k}" for k in range(recordings)),
        effects={n: effect(n) for n in every},
    )
    table = SimpleNamespace(
        components={
            n: SimpleNamespace(kind=Kind.UNLISTED if n[0] == "(" else Kind.EFFECT)
            for n in every
        }
    )
    fit = SimpleNamespace(problem=problem)
    sets = {names: float(w) for names, w in sets.items()}
    whole = sum(sets.values())
    made = [
        Explanation(tuple(sorted(names)), 0, fit, (), None, None, table, 1.0, w / whole)
        for names, w in sets.items()
    ]
    bases = tuple(e for e in made if not e.names)
    ranked = tuple(sorted(made, key=lambda e: -e.probability))
    return Posterior(ranked, (Alternative(problem),), bases, p_noise)
