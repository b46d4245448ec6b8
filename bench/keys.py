"""All keys of recording.toml and bench.toml, with units and ranges; read_keys.py reads
them."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field, create_model
from pydantic_core import PydanticCustomError

from benchtwin.bench.conditions import condition_errors
from benchtwin.bench.priors import stated_sd, unstated_sd, usable_sd
from benchtwin.bench.rigs import RIGS
from benchtwin.bench.section import (
    FROM_LIST,
    SIMULATED,
    Angle,
    Finite,
    Frame,
    Length,
    NotNegative,
    Pixels,
    PlaceOfFrame,
    Section,
    SeedSize,
    SizeRange,
    Vector,
)
from benchtwin.bench.seed_kinds import kinds

COMPLETE = "complete"  # type of an error whose message lacks only the name of the file

if TYPE_CHECKING:
    _Kind = str
else:
    _Kind = Literal[tuple(kinds())]


class Seed(Section):
    """The seed: measure and weigh some of the lot."""

    kind: _Kind | None = None
    """What it is, "maize": `benchtwin seeds` lists the kinds. A simulation then takes
    absent sizes and density as published."""
    length_mm: SeedSize | None = None
    """Longest axis."""
    width_mm: SeedSize | None = None
    """Middle axis."""
    thickness_mm: SeedSize | None = None
    """Shortest axis."""
    # sand: 0.0002, a bowling ball: 7,260
    mass_g: Annotated[float, Field(gt=0, le=100_000, allow_inf_nan=False)] | None = None
    """Of one seed; with the axes it gives the air drag. Or state the density."""
    density_kg_m3: (
        Annotated[float, Field(gt=0.1, lt=30_000, allow_inf_nan=False)] | None
    ) = None
    """Of the seed's own substance, without the gaps between seeds. Or state the
    mass."""
    length_range_mm: SizeRange | None = None
    """Least and greatest length of about 100 seeds."""
    width_range_mm: SizeRange | None = None
    """Least and greatest width of about 100 seeds."""
    thickness_range_mm: SizeRange | None = None
    """Least and greatest thickness of about 100 seeds."""
    count: Annotated[int, Field(ge=1)] | None = None
    """How many are taped together (slides)."""
    inertia_factor: (
        Annotated[float, Field(gt=0.05, le=1, allow_inf_nan=False)] | None
    ) = None
    """I/(m r²) of what rolls: a solid ball 0.4, a thin shell 0.667. Absent: solid, of
    the stated axes."""
    lot: str | None = None
    """Folder written by `benchtwin shape`: the seeds' measured sizes and outlines,
    which the simulation then uses."""
    lot_seed: str | None = None
    """Which seed of the lot was recorded, as photo:seed in its seeds.csv. Absent: any
    of them."""
    shape: str | None = None
    """Mesh file of the seed's true shape (STL, PLY, OBJ) in the bench's folder, which
    the simulation then fills with balls."""
    shape_unit: Literal["mm", "cm", "m", "inch"] | None = None
    """Unit of that mesh's coordinates."""

    @property
    def sizes_mm(self) -> list[float]:
        """The stated ones of length, width and thickness."""
        return [s for s in (self.length_mm, self.width_mm, self.thickness_mm) if s]


class Camera(Section):
    """The camera: still, level, as far away as its lens allows."""

    fps: Annotated[float, Field(gt=0, le=5e6, allow_inf_nan=False)] | None = None
    """Pictures a second as the camera took them; a slowed film plays at another rate.
    Absent: the file's own times."""
    mm_per_px: Annotated[float, Field(gt=1e-5, le=1000, allow_inf_nan=False)] | None = (
        None
    )
    """Scale in the plane of the motion. Absent: read from a printed board in the
    picture (`benchtwin board`), else answers are in pixels."""
    mm_per_px_sd: NotNegative | None = None
    """How well the scale is known (standard deviation). Absent: 1 %."""
    plumb_deg: Angle | None = None
    """Direction of gravity in the picture, clockwise from straight down. Absent: read
    from a printed board in the picture, else the plate's own line."""
    plumb_sd_deg: NotNegative | None = None
    """How well the plumb line is known (standard deviation). Absent: 0.5°; 1° where
    plumb_deg is absent, too."""
    pitch_deg: Annotated[float, Field(ge=-60, le=60)] | None = None
    """By how much the camera looks down. Absent: read from a printed board in the
    picture, else from the foot of a heap."""
    pitch_sd_deg: NotNegative | None = None
    """How well that is known (standard deviation). Absent: 0.5°."""
    board_line_mm: Length | None = None
    """Length of the line on the printed board, as measured on the print. Absent: as
    printed, ± 0.5 %."""
    exposure_s: Annotated[float, Field(gt=0, lt=10, allow_inf_nan=False)] | None = None
    """How long each picture was exposed."""
    readout_s: Annotated[float, Field(ge=0, le=0.2, allow_inf_nan=False)] | None = None
    """Rolling shutter: from the first row's reading to the last's; 0 for a global
    shutter. Absent: unknown, 0 to a frame."""
    width_px: Annotated[Pixels | None, SIMULATED] = None
    """Width of the picture; only a simulated camera needs it."""
    height_px: Annotated[Pixels | None, SIMULATED] = None
    """Height of the picture; only a simulated camera needs it."""
    target_mm: Annotated[Vector | None, SIMULATED] = None
    """The point of the rig at the picture's centre; only a simulated camera needs
    it."""
    distance_mm: Length | None = None
    """Camera to the plane of the motion. Absent: a diagnosis allows for 0.3 to 20 m,
    and sees less."""
    distortion: Annotated[
        Annotated[float, Field(ge=-0.1, le=0.1)] | None, SIMULATED
    ] = None
    """Radial distortion at the picture's corner, as a share; only a simulated camera
    needs it."""

    @property
    def scale_sd(self) -> float:
        """Relative sd of mm_per_px; a scale without a stated sd is not trusted beyond 1
        %."""
        if self.mm_per_px is None or self.mm_per_px_sd is None:
            return unstated_sd("scale")
        return usable_sd("scale", self.mm_per_px_sd / self.mm_per_px)

    @property
    def plumb_sd(self) -> float:
        """sd of plumb_deg, of zero where that is not stated."""
        if self.plumb_sd_deg is not None:
            return usable_sd("plumb", self.plumb_sd_deg)
        return (unstated_sd if self.plumb_deg is None else stated_sd)("plumb")

    @property
    def pitch_sd(self) -> float:
        """sd of a stated pitch_deg."""
        sd = self.pitch_sd_deg
        return stated_sd("plumb") if sd is None else usable_sd("plumb", sd)

    @property
    def used_sds(self) -> dict[str, float]:
        used = {"plumb_sd_deg": self.plumb_sd}
        if self.pitch_deg is not None:
            used["pitch_sd_deg"] = self.pitch_sd
        if self.mm_per_px:
            used["mm_per_px_sd"] = self.scale_sd * self.mm_per_px
        return used


class Reading(Section):
    """How somebody reads an instrument."""

    resolution_deg: (
        Annotated[float, Field(ge=1e-3, le=5, allow_inf_nan=False)] | None
    ) = None
    """Step to which angles were read. Absent: unknown, 0.01° to 1°."""


class Air(Section):
    """The air around; zero density leaves air out of the simulation."""

    density_kg_m3: Annotated[float, Field(ge=0, lt=2000, allow_inf_nan=False)] = 1.20
    """1.20 at 20 °C and sea level."""
    viscosity_pa_s: Annotated[float, Field(ge=0, lt=10, allow_inf_nan=False)] = 1.81e-5
    """1.81e-5 at 20 °C."""


class Tracking(Section):
    """Corrections of what is followed in a film."""

    left_out_frames: Annotated[tuple[Frame, ...], FROM_LIST] | None = None
    """Numbers of frames whose place is wrong and no fit should use."""
    follow_px: Annotated[tuple[Finite, Finite, Finite], FROM_LIST] | None = None
    """What to follow, where another thing was followed: frame, x, y in the picture (y
    down)."""
    places_px: Annotated[tuple[PlaceOfFrame, ...], FROM_LIST] | None = None
    """Places of the seed set by hand, used instead of what is found in these frames:
    frame, x, y of its middle in the picture (y down)."""
    only_places: bool | None = None
    """Yes where these places alone are the track. Absent: only where nothing else is
    found."""


def _checked(conditions: Any) -> Any:
    if not isinstance(conditions, dict):
        return conditions
    if message := "\n".join(condition_errors(conditions)):
        raise PydanticCustomError(COMPLETE, "{message}", {"message": message})
    return {
        key: value if isinstance(value, str) else float(value)
        for key, value in conditions.items()
    }


class _Keys(Section):
    rig: str | None = None
    """What was done."""
    id: str | None = None
    """Name of the recording. Absent: the folder's."""
    session: str | None = None
    """Recordings of one session share one camera set-up; a date will do."""
    provenance: Literal["measured", "simulated", "published"] | None = None
    """Where the numbers come from."""
    seed: Seed = Seed()
    camera: Camera = Camera()
    conditions: Annotated[dict[str, float | str], BeforeValidator(_checked)] = Field(
        default_factory=dict
    )
    reading: Reading = Reading()
    air: Air = Air()
    track: Tracking = Tracking()


if TYPE_CHECKING:

    class Keys(_Keys):
        """All keys of recording.toml, a section for each rig among them; in bench.toml
        the same."""

else:
    Keys = create_model(
        "Keys",
        __base__=_Keys,
        __doc__="All keys of recording.toml; in bench.toml the same.",
        rig=(
            Literal[tuple(RIGS)] | None,
            Field(default=None, description=_Keys.model_fields["rig"].description),
        ),
        **{name: (rig.keys, rig.keys()) for name, rig in RIGS.items()},
    )
