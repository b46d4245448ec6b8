"""What a rig tells a calibration: one parameter of a seed on the plate, or how seeds
act on each other. A rig's record names its own as `tells`."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from benchtwin.bench.language import tr
from benchtwin.bench.rig import Rig
from benchtwin.bench.rigs import RIGS


def as_it_is(section: dict, value: float) -> dict:
    """The rig's section, unchanged."""
    return section


@dataclass(frozen=True, kw_only=True)
class Reading:
    """A rig whose recordings are calibrated on the first column of its readings."""

    rig: Rig

    @property
    def name(self) -> str:
        """Of the rig, and of its section of recording.toml."""
        return self.rig.name

    @property
    def response(self) -> str:
        """Column of its reading."""
        return next(iter(self.rig.readings))

    @property
    def unit(self) -> str:
        """Of its reading, as "mm" or "deg"."""
        return self.rig.readings[self.response][1]


@dataclass(frozen=True, kw_only=True)
class ByCurve(Reading):
    """A rig that tells one contact parameter of seed on steel: simulated at some values
    of it, through which a curve is laid and inverted.

    parameter: a field of `twin.Parameters`; limits: its physical ends; step: smallest
    half width that a range of it is simulated over; first: where a range begins when
    the readings say nothing; assumed: where the rig gives nothing. formula(reading,
    section): the parameter straight from a reading and the rig's own section of
    recording.toml, None where its lengths are not stated; formula_name, equation: what
    a publication calls that, and the curve, a polynomial of this degree.
    begun(section, value): the section with which a run at this value is simulated.

    seed_range: where the same parameter of seed on seed is looked for by the rigs that
    tell it, None: it is not; seed_limits: what can be simulated of it."""

    parameter: str
    limits: tuple[float, float]
    step: float
    first: float
    assumed: float
    formula: Callable[[float, dict], float | None]
    formula_name: str = "the rig's formula"
    equation: str = "the polynomial"
    degree: int = 2
    begun: Callable[[dict, float], dict] = as_it_is
    seed_range: tuple[float, float] | None = None
    seed_limits: tuple[float, float] = (0.0, 1.0)

    @property
    def sd(self) -> str:
        """Column with the standard deviation of single runs."""
        return f"sd_{self.unit}"

    @property
    def seed(self) -> str:
        """Name of the parameter of seed on seed."""
        return f"seed_{self.parameter}"

    def direct(self, reading: float, description: dict) -> float | None:
        """The parameter straight from a reading, without simulation; None where the
        rig's own lengths are not stated."""
        return self.formula(reading, description.get(self.name, {}))


@dataclass(frozen=True)
class Believed:
    """What is believed of a key that a bench does not state: normal about the mean, cut
    off at the ends (low, high) between which it is simulated."""

    mean: float
    sd: float
    ends: tuple[float, float]


def nothing_open(section: dict) -> dict[str, Believed]:
    """No key."""
    return {}


def nothing_left_out(section: dict) -> float:
    """The simulation has all of it."""
    return 0.0


@dataclass(frozen=True, kw_only=True)
class BySurface(Reading):
    """A rig that tells the parameters of seed on seed together: simulated at the points
    of a design, through which a surface is laid.

    simulated(section, width_mm, fill_mm): the section of what is simulated in its
    place, and a note where that is another; shown(section): the camera of the picture
    that is shown beside the bench's; not_seen: columns of a simulated run that no bench
    can show; minutes: that what one simulated run shows takes at a bench.
    ratios: {name: (above, below)} of what is weighed, which a slice shows as the whole
    does. left_open(section): keys that a bench does not state, or not exactly, with
    what is believed of them: they vary along, and are averaged over; "rig.key" is that
    rig's alone; left_out(section): relative sd of its first reading by what the
    simulation of it leaves out; usual: what a bench that makes such a test will state.
    variant: of the rig, whose recordings are evidence of their own; plural: in words;
    per_run: how many of the bench's readings one simulated run is the mean of, and
    within: the column with their sd; answers: parameters that it tells by itself,
    whatever else the bench has; page: of `docs/`, which says how such a test is made;
    sample: a recording of one."""

    simulated: Callable[[dict, float | None, float], tuple[dict, tuple[str, ...]]]
    shown: Callable[[dict], dict]
    not_seen: tuple[str, ...] = ()
    minutes: float = 5.0
    ratios: Mapping[str, tuple[str, str]] = field(default_factory=dict, hash=False)
    left_open: Callable[[dict], Mapping[str, Believed]] = nothing_open
    left_out: Callable[[dict], float] = nothing_left_out
    usual: Mapping[str, float] = field(default_factory=dict, hash=False)
    variant: str = ""
    plural: str = ""
    per_run: int = 1
    within: str = ""
    answers: tuple[str, ...] = ()
    page: str = ""
    sample: str = ""

    @property
    def name(self) -> str:
        """Of the rig, or of its variant."""
        return self.variant or self.rig.name

    @property
    def in_plural(self) -> str:
        """ "heaps"."""
        of_variant = f"{self.variant}s" if self.variant else self.rig.in_plural
        return self.plural or of_variant

    @property
    def made(self) -> str:
        """How such a test is made, "" where every bench has it."""
        if not self.page:
            return ""
        return tr(
            "docs/{} says how they are made, {} holds some", self.page, self.sample
        )

    @property
    def keys(self) -> dict:
        """{section: keys} that every recording of it states."""
        return dict(self.rig.variants[self.variant]) if self.variant else {}

    def all_variants(self) -> Iterator["BySurface"]:
        """The rig as it is, then built otherwise; the one variant that it is of."""
        names = (self.variant,) if self.variant else ("", *self.rig.variants)
        return (replace(self, variant=name) for name in names)


def by_curve() -> dict[str, ByCurve]:
    """Rigs that tell one parameter each, by name, in their order."""
    return {told.name: told for told in _told() if isinstance(told, ByCurve)}


def by_surface() -> dict[str, BySurface]:
    """Rigs and their variants that tell of seed on seed, by name, in their order, those
    last that tell of it in a variant only: along the first one's reading the design is
    laid, the others are simulated over the same design."""
    told = [one for one in _told() if isinstance(one, BySurface)]
    told.sort(key=lambda one: bool(one.variant))
    return {one.name: one for rig in told for one in rig.all_variants()}


def _told() -> Iterator[Reading]:
    """What rigs tell: one thing each, or several."""
    for rig in RIGS.values():
        told = rig.part("tells") if rig.tells else ()
        yield from told if isinstance(told, tuple) else (told,)
