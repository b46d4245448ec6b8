"""Tells the frames of a film from photos that were taken one by one, by what the
pictures and their files show."""

import itertools
import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import lru_cache
from pathlib import Path

import numpy as np
from PIL import Image

from benchtwin.bench.language import tr
from benchtwin.vision.evidence.photo import PHOTO_SUFFIXES, photo_size, read_small
from benchtwin.vision.measurement import MeasurementError

FILM, PHOTOS, UNCLEAR = "film", "photos", "unclear"
LEAST_FRAMES = 12  # fewer pictures of one name are photos
DECIDES = 1.0  # a sum of weights beyond it, in decades of the odds, is no question
LOOKED_AT = 6  # pairs of neighbours, spread over the whole
SMALL_PX = 160  # side of the pictures as they are compared
CHANGED = (12.0, 30.0)  # least and most grey levels, of 255, that count as a change
NOISE = 7.0  # times the median difference: no change
LITTLE, MUCH = 0.01, 0.02  # share of a picture that changes to the next
UNLIKE, ALIKE = 0.7, 0.5  # change to the next against that to one far off
CAMERA_NAME = re.compile(
    r"(?i)img|dsc[fn]?|dscn|pxl|mvimg|wp|p|photo|foto|whatsapp image.*|\d{8}|image"
)
EXIF, ORIGINAL, SUBSECONDS, EXPOSURE, MODEL = 0x8769, 0x9003, 0x9291, 0x829A, 0x0110


@dataclass(frozen=True)
class Judgement:
    """kind: FILM, PHOTOS, or UNCLEAR where both fit; why: what speaks for either, in
    words."""

    kind: str
    why: str = ""


def numbered_runs(
    names: Iterable[str], least: int = LEAST_FRAMES
) -> dict[str, list[str]]:
    """Pictures whose names differ in their number alone, `least` or more, in its order,
    by the rest of the name."""
    runs: dict[tuple[str, str], dict[int, list[str]]] = {}
    for name in names:
        path = Path(name)
        if path.suffix.lower() in PHOTO_SUFFIXES and (
            parts := re.fullmatch(r"(.*?)[-_ (]*(\d{1,18})\)?", path.stem)
        ):
            run = runs.setdefault((parts[1], path.suffix.lower()), {})
            run.setdefault(int(parts[2]), []).append(name)
    found: dict[str, list[str]] = {}
    for (stem, _), run in runs.items():
        ordered = [name for number in sorted(run) for name in run[number]]
        if len(ordered) >= least:
            found.setdefault(stem, []).extend(ordered)
    return found


def film_or_photos(files: Mapping[str, Path]) -> Judgement:
    """What the pictures of one numbered run are; files: those of the run, by the name
    that they were given."""
    stats = [(name, path, path.stat()) for name, path in files.items()]
    return _judged(tuple((n, p, s.st_mtime_ns, s.st_size) for n, p, s in stats))


@lru_cache(maxsize=500)
def _judged(files: tuple[tuple[str, Path, int, int], ...]) -> Judgement:
    names = [name for name, *_ in files]
    runs = numbered_runs(names)
    if len(runs) != 1 or len(next(iter(runs.values()))) != len(names):
        return Judgement(PHOTOS, tr("their names are not those of one series"))
    paths = {name: path for name, path, *_ in files}
    ordered = [paths[name] for name in next(iter(runs.values()))]
    evidence = [
        *_by_name(next(iter(runs)), next(iter(runs.values()))),
        *_by_size(ordered),
        *_by_camera(ordered),
        *_by_content(ordered),
    ]
    total = sum(weight for weight, _ in evidence)
    kind = FILM if total > DECIDES else PHOTOS if total < -DECIDES else UNCLEAR
    told = sorted(evidence, key=lambda one: -abs(one[0]))
    if kind != UNCLEAR:
        told = [one for one in told if one[0] * total > 0]
    return Judgement(kind, "; ".join(words for _, words in told[:3]))


# Each piece of evidence is (weight, words): the decades by which it multiplies the odds
# that the pictures are a film, as judged from phones, cameras and frame grabbers.
Evidence = list[tuple[float, str]]


def _by_name(stem: str, names: list[str]) -> Evidence:
    digits = [re.findall(r"\d+", Path(name).stem)[-1] for name in names]
    steps = Counter(int(b) - int(a) for a, b in itertools.pairwise(digits))
    step, times = steps.most_common(1)[0]
    from_first = int(digits[0]) <= 1 and len({*map(len, digits)}) == 1 and step == 1
    told = (
        (times < 0.8 * (len(names) - 1), -1.0, tr("their numbers have gaps")),
        (
            CAMERA_NAME.fullmatch(stem.strip("-_ ")),
            -0.5,
            tr("a camera names photos so"),
        ),
        (
            from_first,
            0.5,
            tr("they are numbered from the first on, with leading zeros"),
        ),
    )
    named = [(weight, words) for holds, weight, words in told if holds]
    phone = Path(names[0]).suffix.lower() not in (".png", ".bmp", ".tif", ".tiff")
    return [*named[:1], *([] if phone else [(0.5, tr("phones save no such files"))])]


def _by_size(files: list[Path]) -> Evidence:
    sizes: Counter[tuple[int, int]] = Counter()
    for file in files:
        with suppress(MeasurementError, OSError):
            sizes[photo_size(file)] += 1
    others = sizes.total() - max(sizes.values(), default=0)
    return [(-5.0, tr("they differ in size"))] if others > 0.05 * sizes.total() else []


def _by_camera(files: list[Path]) -> Evidence:
    """What cameras write into their files: when, how long exposed, by which camera."""
    tags = [tag for tag in map(_tags, files) if tag]
    if len(tags) < 0.8 * len(files):
        return []
    times = [t for tag in tags if (t := _taken(tag)) is not None]
    steps = [(b - a).total_seconds() for a, b in itertools.pairwise(times)]
    gap = float(np.median(np.abs(steps))) if len(times) > 0.8 * len(files) else 0.0
    words = tr("they were taken {:.3g} s apart", gap)
    told = (
        (gap >= 1 and np.std(steps) < 0.1 * gap, 0.0, f"{words}, evenly"),
        (gap >= 1, -2.0, words),
        (steps, 1.0, tr("they were taken within a second of one another")),
        (any(MODEL in tag for tag in tags), -0.5, tr("they name the camera")),
    )
    found = [(weight, words) for holds, weight, words in told if holds][:1]
    differ = len({tag.get(EXPOSURE) for tag in tags}) > len(tags) / 4
    return found + [(-0.5, tr("they were exposed for different times"))] * differ


def _tags(file: Path) -> dict:
    try:
        with Image.open(file) as picture:
            base = picture.getexif()
            return {**base, **base.get_ifd(EXIF)}
    except Exception:  # whatever damaged tags raise: then they say nothing
        return {}


def _taken(tags: dict) -> datetime | None:
    try:
        whole = datetime.strptime(str(tags[ORIGINAL]).strip("\0 "), "%Y:%m:%d %H:%M:%S")
        part = str(tags.get(SUBSECONDS) or "0").strip("\0 ")
        return whole + timedelta(seconds=float(f"0.{part}"))
    except (KeyError, ValueError):
        return None


def _by_content(files: list[Path]) -> Evidence:
    """The frames of a still camera share their background, and those that follow one
    another are more alike than those that do not."""
    starts = np.unique(np.linspace(0, len(files) - 2, LOOKED_AT).round().astype(int))
    pairs = [(_small(files[i]), _small(files[i + 1])) for i in starts]
    seen = [(a, b) for a, b in pairs if a is not None and b is not None]
    if len(seen) < 2:
        return []
    near = float(np.median([_changed(a, b) for a, b in seen]))
    rows = range(len(seen))
    apart = [(i, j) for i in rows for j in rows if abs(i - j) > 1]
    changes = [_changed(seen[i][0], seen[j][1]) for i, j in apart]
    far = float(np.median(changes or [math.nan]))
    share = tr("{:.2g} % of the picture", 100 * near)
    told = (
        (near < LITTLE, 2.0, tr("from one to the next only {} changes", share)),
        (
            near < ALIKE * far,
            1.5,
            tr("those that follow one another are more alike than others"),
        ),
        (
            near > MUCH and near > UNLIKE * far,
            -1.5,
            tr("from one to the next {} changes, as between any two", share),
        ),
        (True, 0.0, tr("from one to the next {} changes", share)),
    )
    return [next((weight, words) for holds, weight, words in told if holds)]


def _small(file: Path) -> np.ndarray | None:
    try:
        return np.asarray(read_small(file, SMALL_PX).convert("L"), dtype=float)
    except (MeasurementError, OSError, MemoryError):
        return None


def _changed(a: np.ndarray, b: np.ndarray) -> float:
    """Share of the pixels that differ when both are equally bright."""
    if a.shape != b.shape:
        return 1.0
    gain = np.median(a) / max(float(np.median(b)), 1.0)
    difference = np.abs(a - gain * b)
    return float(np.mean(difference > np.clip(NOISE * np.median(difference), *CHANGED)))
