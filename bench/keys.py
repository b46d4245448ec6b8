"""All keys of recording.toml and bench.toml, with units and ranges; read_keys.py reads
them."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from benchtwin.bench.conditions import condition_errors
from benchtwin.bench.priors import unstated_sd
from benchtwin.bench.seed_kinds import kinds
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

COMPLETE = "complete"  # type of an error whose message lacks only the name of the file

# Ranges catch the wrong unit (a 310 m drop), not the unusual bench.
# a grain of sand: 0.5, a basketball: 240
_SeedSize = Annotated[float, Field(gt=0.05, le=2000, allow_inf_nan=False)]
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
_Pixel = Annotated[int, Field(ge=0, le=65_536)]
_Frame = Annotated[int, Field(ge=0)]
_Extent = Annotated[int, Field(ge=8, le=65_536)]
_Share = Annotated[float, Field(ge=0, le=100)]
_PlaceOfFrame = Annotated[tuple[_Frame, _Finite, _Finite], _List]
_FourNumbers = Annotated[tuple[_Finite, _Finite, _Finite, _Finite], _List]

if TYPE_CHECKING:
    _Kind = str
else:
    _Kind = Literal[tuple(kinds())]


class Section(BaseModel):
    """A table of keys; the text under each says what it means and what it is for."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, use_attribute_docstrings=True
    )


class Seed(Section):
    """The seed: measure and weigh some of the lot."""

    kind: _Kind | None = None
    """What it is, "maize": `benchtwin seeds` lists the kinds. A simulation then takes
    absent sizes and density as published."""
    length_mm: _SeedSize | None = None
    """Longest axis."""
    width_mm: _SeedSize | None = None
    """Middle axis."""
    thickness_mm: _SeedSize | None = None
    """Shortest axis."""
    # sand: 0.0002, a bowling ball: 7,260
    mass_g: Annotated[float, Field(gt=0, le=100_000, allow_inf_nan=False)] | None = None
    """Of one seed; with the axes it gives the air drag. Or state the density."""
    density_kg_m3: (
        Annotated[float, Field(gt=0.1, lt=30_000, allow_inf_nan=False)] | None
    ) = None
    """Of the seed's own substance, without the gaps between seeds. Or state the
    mass."""
    length_range_mm: _SizeRange | None = None
    """Least and greatest length of about 100 seeds."""
    width_range_mm: _SizeRange | None = None
    """Least and greatest width of about 100 seeds."""
    thickness_range_mm: _SizeRange | None = None
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
    """Mesh file of the seed's true shape (STL, PLY, OBJ), which the simulation then
    fills with balls."""
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
    """Scale in the plane of the motion. Absent: read from millimetre paper in the
    picture, else answers are in pixels."""
    mm_per_px_sd: _NotNegative | None = None
    """How well the scale is known (standard deviation). Absent: 1 %."""
    plumb_deg: _Angle | None = None
    """Direction of gravity in the picture, clockwise from straight down. Absent: the
    plate's own line."""
    plumb_sd_deg: _NotNegative | None = None
    """How well the plumb line is known (standard deviation). Absent: 0.5°."""
    exposure_s: Annotated[float, Field(gt=0, lt=10, allow_inf_nan=False)] | None = None
    """How long each picture was exposed."""
    readout_s: Annotated[float, Field(ge=0, le=0.2, allow_inf_nan=False)] | None = None
    """Rolling shutter: from the first row's reading to the last's; 0 for a global
    shutter. Absent: unknown, 0 to a frame."""
    width_px: _Pixels | None = None
    """Width of the picture; only a simulated camera needs it."""
    height_px: _Pixels | None = None
    """Height of the picture; only a simulated camera needs it."""
    target_mm: _Vector | None = None
    """The point of the rig at the picture's centre; only a simulated camera needs
    it."""
    distance_mm: _Length | None = None
    """Camera to the plane of the motion. Absent: a diagnosis allows for 0.3 to 20 m,
    and sees less."""
    distortion: Annotated[float, Field(ge=-0.1, le=0.1)] | None = None
    """Radial distortion at the picture's corner, as a share; only a simulated camera
    needs it."""

    @property
    def scale_sd(self) -> float:
        """Relative sd of mm_per_px; a scale without a stated sd is not trusted beyond 1
        %."""
        if self.mm_per_px is None or self.mm_per_px_sd is None:
            return unstated_sd("scale")
        return self.mm_per_px_sd / self.mm_per_px

    @property
    def plumb_sd(self) -> float:
        """sd of plumb_deg; a plumb line without a stated sd is not known better than
        0.5°."""
        return 0.5 if self.plumb_sd_deg is None else self.plumb_sd_deg


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


class Drop(Section):
    """A seed falls on a plate and rebounds."""

    height_mm: _Length | None = None
    """Release to plate, of the seed's lowest point."""
    plate_mm: _TwoLengths | None = None
    """Length and width of the plate."""
    bounces: Annotated[int, Field(ge=1, le=100)] | None = None
    """How many bounces are simulated."""
    orientation: Literal["flat", "any"] | _FourNumbers | None = None
    """How the seed lies when released: "flat", "any", or a quaternion."""
    tip_sd_deg: _NotNegative | None = None
    """Scatter of that about flat."""
    spin_rad_s: _Vector | None = None
    """Spin at the release."""
    spin_sd_rad_s: _NotNegative | None = None
    """Scatter of the spin at the release."""
    hold_s: _NotNegative | None = None
    """How long the film runs before the release."""
    tilt_deg: Annotated[float, Field(gt=-15, lt=15)] | None = None
    """Tilt of the plate, falling towards +x."""
    impacts_added_s: Annotated[tuple[_Finite, ...], _List] | None = None
    """Moments in the sound at which an impact was not found."""
    impacts_struck_s: Annotated[tuple[_Finite, ...], _List] | None = None
    """Moments in the sound at which something was taken for an impact that is none."""


class Slide(Section):
    """A plate is raised about a hinge until the seeds on it slide."""

    tilt_rate_deg_s: (
        Annotated[float, Field(ge=0, lt=1000, allow_inf_nan=False)] | None
    ) = None
    """How fast the plate is raised, 0 where it stands; or give the angle of each row in
    the column tilt_deg of track.csv."""
    travel_mm: _Length | None = None
    """How far the seeds can slide."""
    plate_mm: _TwoLengths | None = None
    """Length and width of the plate."""
    start_mm: _Length | None = None
    """Where the seeds lie at first, from the hinge."""
    start_deg: Annotated[float, Field(ge=0, lt=80)] | None = None
    """Angle of the plate when the recording begins."""


class Roll(Section):
    """A seed rolls down an incline and runs out on a level plate."""

    incline_deg: Annotated[float, Field(gt=0, lt=90, allow_inf_nan=False)] | None = None
    """Angle of the incline against the level plate."""
    incline_length_mm: _Length | None = None
    """Path on the incline, from the release to its end."""
    direction: Literal["+x", "-x"] | None = None
    """Which way the seed rolls; the same plate run both ways tells whether it is
    level."""
    rail_gap_mm: Annotated[float, Field(gt=0, lt=2000, allow_inf_nan=False)] | None = (
        None
    )
    """Inside width between two rails that a ball rolls on. Absent: a plate."""
    level: bool | None = None
    """No where the seed stays on its incline. Absent: as the incline's length and the
    rows say."""
    plate_mm: _TwoLengths | None = None
    """Length and width of the plate."""
    orientation: Literal["across", "any"] | None = None
    """How the seed lies when released: its longest axis across the way, or any way."""
    axis_sd_deg: _NotNegative | None = None
    """Scatter of that axis."""
    slope_deg: Annotated[float, Field(gt=-5, lt=5)] | None = None
    """Slope of the level plate, rising along +x."""


class Pile(Section):
    """A box, or a cylinder, of seeds is let go and leaves a pile."""

    box_mm: _ThreeLengths | None = None
    """Inside length (gate at its +x end), width and height of the box."""
    gate_mm: _TwoLengths | None = None
    """Width and height of the gate."""
    cylinder_mm: _TwoLengths | None = None
    """Inside diameter and height of a lifted cylinder, in the box's place."""
    plate_mm: _TwoLengths | None = None
    """Length and width of the plate."""
    fill_height_mm: _Length | None = None
    """How high the seeds were filled in."""
    gate_speed_mm_s: _Positive | None = None
    """How fast the gate, or the cylinder, is lifted."""
    baseline_px: _FourNumbers | None = None
    """The plate's line in the photo, x1, y1, x2, y2 (y down). Absent: found in the
    photo."""
    roi_px: Annotated[tuple[_Pixel, _Pixel, _Extent, _Extent], _List] | None = None
    """Look only there in the photo: left, top, width, height."""
    window_pct: Annotated[tuple[_Share, _Share], _List] | None = None
    """Heights, in % of the crest's, between which the line is fitted. Absent: 20 and
    80."""
    photo_s: _Positive | None = None
    """When the photo was taken, after the gate began to move. Absent: when all seeds
    lay still."""
    side_walls_in_view: bool | None = None
    """Whether the camera looks through side walls."""
    slab: bool | None = None
    """Whether only a slice of the pile, between smooth sides, is simulated."""
    filled_mass_g: _Positive | None = None
    """What was filled in, up to fill_height_mm; weighed, it tells more than the
    angle."""
    retained_mass_g: _Positive | None = None
    """What is left when the photo is taken."""


class Drum(Section):
    """Seeds flow in a drum that turns about a level axis; the camera looks along it."""

    drum_mm: _TwoLengths | None = None
    """Inside diameter and width."""
    fill_share: Annotated[float, Field(ge=0.1, le=0.6)] | None = None
    """Share of its cross-section that the seeds fill."""
    speed_rpm: Annotated[float, Field(gt=0, le=600, allow_inf_nan=False)] | None = None
    """Turns a minute."""
    lining_friction: Annotated[float, Field(ge=0, le=3)] | None = None
    """Static friction of its inside in a simulation. Absent: 0.9, a lining on which
    nothing slips."""
    wait_s: _Positive | None = None
    """How long it turns before the film begins."""
    film_s: _Positive | None = None
    """How long a simulated film is."""


class Tracking(Section):
    """Corrections of what is followed in a film."""

    left_out_frames: Annotated[tuple[_Frame, ...], _List] | None = None
    """Numbers of frames whose place is wrong and no fit should use."""
    follow_px: Annotated[tuple[_Finite, _Finite, _Finite], _List] | None = None
    """What to follow, where another thing was followed: frame, x, y in the picture (y
    down)."""
    places_px: Annotated[tuple[_PlaceOfFrame, ...], _List] | None = None
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


class Keys(Section):
    """All keys of recording.toml; in bench.toml the same."""

    rig: Literal["drop", "slide", "roll", "pile", "drum"] | None = None
    """What was done."""
    id: str | None = None
    """Name of the recording. Absent: the folder's."""
    session: str | None = None
    """Recordings of one session share one camera set-up; a date will do."""
    provenance: Literal["measured", "simulated", "published"] | None = None
    """Where the numbers come from."""
    seed: Seed = Seed()
    camera: Camera = Camera()
    conditions: Annotated[dict[str, float | str], BeforeValidator(_checked)] = {}
    reading: Reading = Reading()
    air: Air = Air()
    track: Tracking = Tracking()
    drop: Drop = Drop()
    slide: Slide = Slide()
    roll: Roll = Roll()
    pile: Pile = Pile()
    drum: Drum = Drum()
