"""What recordings state of what is missing, and the key that would state all of it."""

import math
from collections.abc import Iterable
from dataclasses import replace

from benchtwin.diagnose.words import effect_of
from benchtwin.infer.finding import Finding, StatedKey
from benchtwin.twin.seen import Recording, stated_by


def with_stated(finding: Finding, recordings: Iterable[Recording]) -> Finding:
    """The finding with the key that states each effect; the number of an effect that is
    told with what is stated holds that too."""
    here, keys = list(recordings), {}
    effects, parameters = dict(finding.effects), dict(finding.parameters)
    for name, told in finding.effects.items():
        effect = effect_of(finding, name)
        if not effect or not effect.key or not math.isfinite(told.size.value):
            continue
        key, size = effect.key, told.size
        place = key.section, key.name, key.absent, key.overruled_by
        stated = stated_by(here, *place)
        if not stated or any(map(math.isnan, stated)):
            continue
        more = stated[0] if key.whole and len(stated) == 1 else 0.0
        whole = tuple(key.both(one, size.value) for one in stated)
        sd = abs(key.both(stated[-1], size.high95) - whole[-1]) / 1.96
        keys[name] = StatedKey(str(key), stated, whole, sd, more)
        effects[name] = replace(told, size=_more(told.size, more))
        if name in parameters:
            parameters[name] = _more(parameters[name], more)
    return replace(finding, effects=effects, parameters=parameters, keys=keys)


def _more(size, more: float):
    """An interval moved up by `more`."""
    moved = {n: getattr(size, n) + more for n in ("value", "low95", "high95")}
    return replace(size, **moved)
