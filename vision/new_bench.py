"""`benchtwin new`: a bench folder with a bench.toml that lists and explains all
keys."""

from pathlib import Path

from benchtwin.bench.keys import Keys
from benchtwin.bench.rigs import RIGS
from benchtwin.vision.measurement import MeasurementError

SECTIONS = ("seed", "camera", "air", "reading", *RIGS)
HEAD = """\
# What holds for every recording of this bench; a recording.toml beside a recording \
says what differs.
# A key that is absent is unknown: never zero, never exact. \
Take away the # of what you know.
#
#   {name}/drop-01/recording.toml      rig = "drop", and what is known of this one
#   {name}/drop-01/video.mp4           \
or frames/, track.csv, gates.csv, impacts.csv, readings.csv, photos
#
# session = "2026-03-02"               recordings of one session share one camera set-up

# [conditions]                         \
whatever differs between recordings: numbers with the unit in the name, or words
# moisture_pct = 12.5
"""


def bench_text(name: str) -> str:
    """The text of bench.toml for a new bench called `name`: valid as it is, every key
    commented out."""
    parts = [HEAD.format(name=name)]
    for section in SECTIONS:
        model = type(getattr(Keys(), section))
        lines = [
            f"[{section}]".ljust(38) + f"# {' '.join((model.__doc__ or '').split())}"
        ]
        for key, field in model.model_fields.items():
            message = " ".join((field.description or "").split())
            if field.json_schema_extra is None:  # not for simulating alone
                lines.append(f"# {key} =".ljust(38) + f"# {message}")
        parts.append("\n".join(lines) + "\n")
    return "\n".join(parts)


def new_bench(folder: Path) -> Path:
    """Write bench.toml into `folder`, made if need be; returns the file.
    MeasurementError where it is there already."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "bench.toml"
    try:
        with file.open("x", encoding="utf8") as out:
            out.write(bench_text(folder.resolve().name))
    except FileExistsError as error:
        raise MeasurementError(
            f"{file}: exists already; nothing was written"
        ) from error
    return file
