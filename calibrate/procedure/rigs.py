"""The rigs of the procedure, as their folders state them (`bench/tells.py`): those that
tell one parameter each, and those, with their variants, that tell of seed on seed."""

from benchtwin.bench.tells import ByCurve, by_curve, by_surface

STEEL = by_curve()
# the first rig that tells of seed on seed chooses where the others are simulated
PILE, *_others = by_surface().values()
BESIDE = {rig.name: rig for rig in _others}
# where several rigs tell one parameter, the first one's word holds
_FIRST: dict[str, ByCurve] = {}
for _rig in STEEL.values():
    _FIRST.setdefault(_rig.parameter, _rig)
ASSUMED = {name: rig.assumed for name, rig in _FIRST.items()}
ON_SEED = {r.seed: r for r in _FIRST.values() if r.seed_range is not None}
RANGES = {name: rig.seed_range or (0.0, 1.0) for name, rig in ON_SEED.items()}
SEED_LIMITS = {name: rig.seed_limits for name, rig in ON_SEED.items()}
SEED_FACTORS = tuple(RANGES)
PARAMETERS = (*ASSUMED, *SEED_FACTORS)
