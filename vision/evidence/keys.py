"""What recording.toml and bench.toml may hold: every key with its unit and range, and errors in a bench worker's words."""

import difflib
import math
import reprlib
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from vision.evidence.conditions import complaints
from vision.measurement import MeasurementError

MOST_BYTES = 30_000  # all keys there are, with comments, fill 5,000
SAID = "said"  # type of an error whose message says all but the file

# Ranges catch the wrong unit (a 310 m drop), not the unusual bench.
_SeedSize = Annotated[float, Field(gt=0.05, le=2000, allow_inf_nan=False)]  # a grain of sand: 0.5, a basketball: 240
_Length = Annotated[float, Field(gt=0, lt=100_000, allow_inf_nan=False)]
_Angle = Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False)]
_Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
_NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
_Finite = Annotated[float, Field(allow_inf_nan=False)]
_Pixels = Annotated[int, Field(ge=8, le=16384)]
_List = Field(strict=False)  # TOML has lists only: one is taken for a tuple
_SizeRange = Annotated[tuple[_SeedSize, _SeedSize], _List]
_TwoLengths = Annotated[tuple[_Length, _Length], _List]
_ThreeLengths = Annotated[tuple[_Length, _Length, _Length], _List]
_Vector = Annotated[tuple[_Finite, _Finite, _Finite], _List]
_FourNumbers = Annotated[tuple[_Finite, _Finite, _Finite, _Finite], _List]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Seed(_Section):
    length_mm: _SeedSize | None = None
    width_mm: _SeedSize | None = None
    thickness_mm: _SeedSize | None = None
    mass_g: Annotated[float, Field(gt=0, le=100_000, allow_inf_nan=False)] | None = None  # a grain of sand: 0.0002, a bowling ball: 7,260
    inertia_factor: Annotated[float, Field(gt=0.05, le=1, allow_inf_nan=False)] | None = None  # I/(m r²): solid 0.4, a shell 0.667
    density_kg_m3: Annotated[float, Field(gt=0.1, lt=30_000, allow_inf_nan=False)] | None = None
    length_range_mm: _SizeRange | None = None  # least and greatest of about 100 seeds
    width_range_mm: _SizeRange | None = None
    thickness_range_mm: _SizeRange | None = None
    count: Annotated[int, Field(ge=1)] | None = None


class Camera(_Section):
    fps: Annotated[float, Field(gt=0, le=5e6, allow_inf_nan=False)] | None = None
    mm_per_px: Annotated[float, Field(gt=1e-5, lt=1000, allow_inf_nan=False)] | None = None
    mm_per_px_sd: _NotNegative | None = None
    plumb_deg: _Angle | None = None
    plumb_sd_deg: _NotNegative | None = None
    exposure_s: Annotated[float, Field(gt=0, lt=10, allow_inf_nan=False)] | None = None
    readout_s: Annotated[float, Field(ge=0, le=0.2, allow_inf_nan=False)] | None = None  # rolling shutter: first row to last
    # Where a twin's camera stands; measuring needs none of these.
    width_px: _Pixels | None = None
    height_px: _Pixels | None = None
    target_mm: _Vector | None = None  # the point of the rig that is seen at the picture's centre
    distance_mm: _Length | None = None
    distortion: Annotated[float, Field(ge=-0.1, le=0.1)] | None = None

    @property
    def scale_sd(self) -> float:
        """Relative sd of mm_per_px; a scale without a stated sd is not trusted beyond 1 %."""
        if self.mm_per_px is None or self.mm_per_px_sd is None:
            return 0.01
        return self.mm_per_px_sd / self.mm_per_px

    @property
    def plumb_sd(self) -> float:
        """sd of plumb_deg; a plumb line without a stated sd is not known better than 0.5°."""
        return 0.5 if self.plumb_sd_deg is None else self.plumb_sd_deg


class Reading(_Section):
    """How somebody reads an instrument."""

    resolution_deg: Annotated[float, Field(ge=1e-3, le=5, allow_inf_nan=False)] | None = None


class Air(_Section):
    density_kg_m3: Annotated[float, Field(ge=0, lt=2000, allow_inf_nan=False)] = 1.20
    viscosity_pa_s: Annotated[float, Field(ge=0, lt=10, allow_inf_nan=False)] = 1.81e-5


class Drop(_Section):
    height_mm: _Length | None = None
    plate_mm: _TwoLengths | None = None
    bounces: Annotated[int, Field(ge=1, le=100)] | None = None
    orientation: Literal["flat", "any"] | _FourNumbers | None = None
    tip_sd_deg: _NotNegative | None = None
    spin_rad_s: _Vector | None = None
    spin_sd_rad_s: _NotNegative | None = None
    hold_s: _NotNegative | None = None
    tilt_deg: Annotated[float, Field(gt=-15, lt=15)] | None = None  # of the plate, falling towards +x


class Slide(_Section):
    tilt_rate_deg_s: Annotated[float, Field(gt=0, lt=1000, allow_inf_nan=False)] | None = None
    travel_mm: _Length | None = None
    plate_mm: _TwoLengths | None = None
    start_mm: _Length | None = None  # from the hinge
    start_deg: Annotated[float, Field(ge=0, lt=80)] | None = None


class Roll(_Section):
    incline_deg: Annotated[float, Field(gt=0, lt=90, allow_inf_nan=False)] | None = None
    incline_length_mm: _Length | None = None
    direction: Literal["+x", "-x"] | None = None
    rail_gap_mm: Annotated[float, Field(gt=0, lt=2000, allow_inf_nan=False)] | None = None  # inside, of two rails; absent: a plate
    level: bool | None = None  # false: the seed stays on its incline; absent: as incline_length_mm and the rows say
    plate_mm: _TwoLengths | None = None
    orientation: Literal["across", "any"] | None = None
    axis_sd_deg: _NotNegative | None = None
    slope_deg: Annotated[float, Field(gt=-5, lt=5)] | None = None


class Pile(_Section):
    box_mm: _ThreeLengths | None = None
    gate_mm: _TwoLengths | None = None
    cylinder_mm: _TwoLengths | None = None  # inside diameter and height: a lifting cylinder in the box's place
    plate_mm: _TwoLengths | None = None
    fill_height_mm: _Length | None = None
    gate_speed_mm_s: _Positive | None = None
    baseline_px: _FourNumbers | None = None  # the plate's line in the photo: x1, y1, x2, y2, y down
    photo_s: _Positive | None = None  # after the gate began to move; absent: when all seeds lie still
    side_walls_in_view: bool | None = None
    slab: bool | None = None
    filled_mass_g: _Positive | None = None  # what was filled in up to fill_height_mm; what is left when the photo is taken
    retained_mass_g: _Positive | None = None


def _checked(conditions: Any) -> Any:
    if not isinstance(conditions, dict):
        return conditions
    if said := "\n".join(complaints(conditions)):
        raise PydanticCustomError(SAID, "{said}", {"said": said})
    return {key: value if isinstance(value, str) else float(value) for key, value in conditions.items()}


class Keys(_Section):
    """All keys of recording.toml; in bench.toml the same."""

    rig: Literal["drop", "slide", "roll", "pile"] | None = None
    id: str | None = None
    session: str | None = None
    provenance: Literal["measured", "simulated", "published"] | None = None
    seed: Seed = Seed()
    camera: Camera = Camera()
    conditions: Annotated[dict[str, float | str], BeforeValidator(_checked)] = {}
    reading: Reading = Reading()
    air: Air = Air()
    drop: Drop = Drop()
    slide: Slide = Slide()
    roll: Roll = Roll()
    pile: Pile = Pile()


def read_toml(path: Path) -> dict:
    """The keys in a recording.toml or bench.toml. MeasurementError, naming the file and the field, for anything else."""
    if (size := path.stat().st_size) > MOST_BYTES:
        raise MeasurementError(f"{path}: {size:,} bytes; a file of keys has {MOST_BYTES:,} at most")
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except RecursionError as error:
        raise MeasurementError(f"{path}: not valid TOML: brackets within brackets, too deep") from error
    except tomllib.TOMLDecodeError as error:
        raise MeasurementError(f"{path}: not valid TOML: {error}") from error
    except UnicodeDecodeError as error:
        raise MeasurementError(f"{path}: not UTF-8 text (byte {error.start})") from error
    validate(content, path)  # so that the error names this file, not the one it is merged into
    return content


def merge(base: dict, over: dict) -> dict:
    """`over` wins, section by section and key by key."""
    merged = dict(base)
    for key, value in over.items():
        merged[key] = {**base[key], **value} if isinstance(value, dict) and isinstance(base.get(key), dict) else value
    return merged


_OTHER_UNITS = {  # end of a key → what its number is in another unit, and its own
    "_mm": (1e-3, "m", "millimetres"),
    "_g": (1e-3, "kg", "grams"),
    "readout_s": (1e3, "ms", "seconds"),
}


def validate(content: dict, path: Path) -> Keys:
    try:
        return Keys.model_validate(content)
    except ValidationError as error:
        raise MeasurementError("\n".join(_explain(e, path) for e in error.errors()[:10])) from error


def _explain(error: ErrorDetails, path: Path) -> str:
    """One pydantic complaint in a bench worker's words: file, field, what it should hold."""
    if error["type"] == SAID:
        return "\n".join(f"{path}: {line}" for line in error["msg"].splitlines())
    *section, key = [part for part in error["loc"] if isinstance(part, str)][:2] or [""]  # then which of several kinds it is not
    place = f"[{section[0]}] {key}" if section else key
    if error["type"] == "extra_forbidden":
        owner = Keys.model_fields[section[0]].annotation if section else Keys
        if isinstance(owner, type) and issubclass(owner, _Section):
            known = list(owner.model_fields)
            near = difflib.get_close_matches(key, known, n=1, cutoff=0.5)
            hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}"
            return f"{path}: unknown key {place}; {hint}"
    given = error.get("input")
    unit = next((u for end, u in _OTHER_UNITS.items() if key.endswith(end)), None)
    if unit and isinstance(given, float | int) and not isinstance(given, bool) and math.isfinite(given):
        times, other, meant = unit
        return f"{path}: {place} = {given} means {times * given:g} {other}: {error['msg'].lower()}; is it in {meant}?"
    said = error["msg"].replace("tuple", "list").replace("dictionary", "section").split(" or instance of ")[0]
    return f"{path}: {place} = {reprlib.repr(given)}: {said[0].lower()}{said[1:]}"
