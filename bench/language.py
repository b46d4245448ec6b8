"""The language of sentences: code says them in English; LANGUAGE.po beside this file
says the same in another."""

import os
from collections.abc import Mapping
from functools import cache
from importlib.resources import files

ENGLISH = "en"
LANGUAGES = (ENGLISH, "zh")
# read again for every sentence, since worker processes are handed nothing else
VARIABLE = "BENCHTWIN_LANGUAGE"


def speak(language: str) -> None:
    """Say sentences in `language` from here on, here and in processes started from
    here. ValueError where there is none of that name."""
    if language not in LANGUAGES:
        raise ValueError(f"{language}: no such language; {', '.join(LANGUAGES)}")
    os.environ[VARIABLE] = language


def spoken() -> str:
    """The language of sentences; English unless another one of LANGUAGES was asked
    for."""
    asked = os.environ.get(VARIABLE, ENGLISH)
    return asked if asked in LANGUAGES else ENGLISH


def tr(sentence: str, *values: object) -> str:
    """The sentence in the language that is spoken, its values filled in; in English
    where it was not translated.

    >>> tr("{}: {} rows", "drop-01", 3)
    'drop-01: 3 rows'
    """
    said = catalogue(spoken()).get(sentence, sentence)
    return said.format(*values) if values else said


@cache
def catalogue(language: str) -> Mapping[str, str]:
    """What sentences are in another language, by what they are in English."""
    if language == ENGLISH:
        return {}
    from polib import pofile

    text = (files("benchtwin.bench") / f"{language}.po").read_text(encoding="utf8")
    return {entry.msgid: entry.msgstr for entry in pofile(text) if entry.msgstr}
