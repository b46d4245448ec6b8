"""What the names of files say: lengths, conditions, and words in which they differ."""

import re
from collections.abc import Sequence

from benchtwin.bench.conditions import NAME, UNITS
from benchtwin.bench.rigs import RIGS
from benchtwin.vision.foreign.source import LENGTH

# "drop_150mm_3", "h 15,5 cm"; a unit that goes on is another word
_LENGTH = re.compile(
    r"(?<![\d.,])(\d+(?:[.,]\d+)?)[ _]?((?i:mm|cm|dm|in|ft)|m)(?![^\W_])"
)
_CONDITION = re.compile(  # "moisture12pct", "plate_at_25degC"
    r"([^\W\d_]{2,})[ _-]?(\d+(?:[.,]\d+)?)[ _-]?"
    r"(%|pct|percent|‰|ppm|rpm|hz|h?pa|kpa|mpa|°c|degc|°|deg)(?![^\W_])",
    re.IGNORECASE,
)
_WORD = re.compile(r"[^\W\d_]{3,}")
NO_CONDITION = {
    *RIGS,
    *("run", "test", "trial", "file", "video", "film", "img", "dsc", "mov", "track"),
    *("raw", "data", "sound", "clap", "messung", "versuch", "export"),
}


def lengths_mm(name: str) -> list[float]:
    """The lengths in a name [mm].

    >>> lengths_mm("drop_150mm_3"), lengths_mm("Fall aus 15,5 cm"), lengths_mm("1-18-M")
    ([150.0], [155.0], [])
    """
    return [
        round(float(number.replace(",", ".")) * LENGTH[unit.lower()], 3)
        for number, unit in _LENGTH.findall(name)
    ]


def conditions_in(name: str) -> dict[str, float]:
    """Keys of [conditions] that a name states: a word, a number and a unit.

    >>> conditions_in("drop_moisture_12pct_3")
    {'moisture_pct': 12.0}
    """
    return {
        f"{word.lower()}_{UNITS[unit.lower()]}": float(number.replace(",", "."))
        for word, number, unit in _CONDITION.findall(name)
        if NAME.fullmatch(word)
    }


def words_that_differ(names: Sequence[str]) -> list[str]:
    """Words by which names form groups, each of more than one file on average.

    >>> words_that_differ(["steel-1", "steel-2", "glass-1", "glass-2"])
    ['glass', 'steel']
    """
    held = [{w.lower() for w in _WORD.findall(n)} - NO_CONDITION for n in names]
    groups = {frozenset(words) for words in held}
    if not 1 < len(groups) <= len(names) / 2:
        return []
    return sorted(set().union(*groups) - set.intersection(*map(set, groups)))
