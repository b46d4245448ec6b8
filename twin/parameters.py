"""The contact parameters of one bench, as the twin takes them."""

from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

from benchtwin.bench.keys import Air, Seed
from benchtwin.bench.seed_kinds import (
    published_contact_parameters,
    with_published_values,
)
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Q235, SOYBEAN, Contact, Material
from benchtwin.sim.rigs.bench import Bench
from benchtwin.sim.seed.arrange import ROUNDEST_AXIAL
from benchtwin.sim.seed.lot import Lot
from benchtwin.sim.seed.sizes import RANGE_OVER_SD_OF_100, Size, Sizes
from benchtwin.sim.seed.sizes import SOYBEAN as SOYBEAN_SIZES
from benchtwin.twin.lot import file_digest, measured_lot, seed_of_mesh
from benchtwin.twin.setup import setup_for

WHOLE, RANGE = ("length", "width", "thickness"), "_range_mm"


@dataclass(frozen=True)
class Parameters:
    """What a calibration asks for, and how it is computed. Dimensionless unless the
    name says otherwise.

    restitution, static_friction, rolling_friction: seed on steel; seed_…: seed on seed.
    rolling_convention: which torque the rolling frictions mean
    (`sim.material.ROLLING_CONVENTIONS`). shear_modulus_pa: what the seeds' modulus is
    softened to; None: as the rig's setup has it. spheres, arrangement, mass_of: the
    seed's balls (`sim.seed.Seed.from_dimensions`). rayleigh_fraction: the time step;
    None: that of the setup. pull_at_end, share_damping: how restitution is had
    (`sim.engine.world.World`). laws: further force laws by name, with their numbers:
    {"magnus": {…}}. Defaults: what the soybean paper calibrated."""

    restitution: float = 0.54
    static_friction: float = 0.34
    rolling_friction: float = 0.01
    seed_restitution: float = 0.65
    seed_static_friction: float = 0.55
    seed_rolling_friction: float = 0.04
    rolling_convention: str = "edem"
    shear_modulus_pa: float | None = None
    spheres: int = 5
    arrangement: str = "axial"
    mass_of: str = "union"
    rayleigh_fraction: float | None = None
    pull_at_end: bool = True
    share_damping: bool = True
    laws: dict[str, dict] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in self.laws:
            if name not in LAWS:
                raise ValueError(f"laws: no law {name!r}; there are {', '.join(LAWS)}")
        self.contacts()  # so that a number out of its range is named here

    def contacts(self) -> tuple[Contact, Contact]:
        """Seed on steel and seed on seed."""
        own, names = self.rolling_convention, (SOYBEAN.name, Q235.name)
        return (
            Contact(
                names,
                self.restitution,
                self.static_friction,
                self.rolling_friction,
                own,
            ),
            Contact(
                (SOYBEAN.name,) * 2,
                self.seed_restitution,
                self.seed_static_friction,
                self.seed_rolling_friction,
                own,
            ),
        )

    def for_rig(self, rig: str) -> "Parameters":
        """The same with nothing left to the rig."""
        setup = setup_for(rig)
        modulus = self.shear_modulus_pa or setup.soft_pa
        step = self.rayleigh_fraction or setup.step
        return replace(self, shear_modulus_pa=modulus, rayleigh_fraction=step)

    def to_dict(self) -> dict:
        return asdict(self)


def bench(parameters: Parameters, rig: str, seed: Seed, air: Air) -> Bench:
    """The bench of a recording: parameters, and what [seed] and [air] state.

    What [seed] leaves open is as published for its kind (`said_of` says so), without a
    kind the paper's soybean."""
    seed = seed.model_copy(
        update=with_published_values(seed.model_dump(exclude_none=True))[0]
    )
    setup = setup_for(rig)
    on_steel, on_seed = parameters.contacts()
    of, drawn = material(seed), shapes(seed, parameters.spheres) or sizes(seed)
    if isinstance(drawn, Lot):
        of = replace(of, density_kg_m3=drawn.seeds[0].density_kg_m3)
    return Bench(
        seed_wall=on_steel,
        seed_seed=on_seed,
        seed=of,
        sizes=drawn,
        spheres=1 if round_as_stated(seed) else parameters.spheres,
        arrangement=parameters.arrangement,
        mass_of=parameters.mass_of,
        inertia_factor=seed.inertia_factor,
        shear_modulus_pa=parameters.shear_modulus_pa or setup.soft_pa,
        air_density_kg_m3=air.density_kg_m3,
        air_viscosity_pa_s=air.viscosity_pa_s,
        laws=tuple(
            LAWS[name].use(**numbers) for name, numbers in parameters.laws.items()
        ),
        rayleigh_fraction=parameters.rayleigh_fraction or setup.step,
        pull_at_end=parameters.pull_at_end,
        share_damping=parameters.share_damping,
    )


def said_of(seed: dict) -> list[str]:
    """Sentences on what a [seed] table's kind gave to the simulation, and what is
    published of its contacts."""
    return [
        *with_published_values(seed)[1],
        *(published_contact_parameters(seed["kind"]) if "kind" in seed else []),
    ]


def round_as_stated(seed: Seed) -> bool:
    """Whether all seeds are balls, which no row of balls can stand for."""
    whole = [getattr(seed, f"{name}_mm") for name in WHOLE]
    scatter = [getattr(seed, name + RANGE) for name in WHOLE]
    return (
        None not in whole
        and None in scatter
        and max(whole) < ROUNDEST_AXIAL * min(whole)
    )


def shapes(seed: Seed, spheres: int) -> Lot | None:
    """The seeds of [seed] lot, or the one of [seed] shape; None where neither is
    stated.

    Raises MeasurementError for a seed, a thickness or a closed mesh that is not there.
    """
    mass_g = None if seed.mass_g is None else seed.mass_g / (seed.count or 1)
    if seed.shape is not None:
        unit, digest = seed.shape_unit, file_digest(Path(seed.shape))
        return seed_of_mesh(
            seed.shape,
            digest,
            unit,
            mass_g=mass_g,
            density_kg_m3=seed.density_kg_m3,
            spheres=spheres,
        )
    if seed.lot is None:
        return None
    low, high = seed.thickness_range_mm or (0.0, 0.0)
    return measured_lot(
        seed.lot,
        only=seed.lot_seed,
        thickness_mm=seed.thickness_mm,
        thickness_sd_mm=(high - low) / RANGE_OVER_SD_OF_100,
        mass_g=mass_g,
        density_kg_m3=seed.density_kg_m3,
        spheres=spheres,
    )


def material(seed: Seed) -> Material:
    """Soybean, of the density that [seed] states, or that follows from its mass and
    dimensions taken as an ellipsoid."""
    whole = [getattr(seed, f"{name}_mm") for name in WHOLE]
    density = seed.density_kg_m3
    if density is None and seed.mass_g is not None and None not in whole:
        density = (
            1e6
            * seed.mass_g
            / (0.5235987755982988 * whole[0] * whole[1] * whole[2])
            / (seed.count or 1)
        )
    return SOYBEAN if density is None else replace(SOYBEAN, density_kg_m3=density)


def sizes(seed: Seed) -> Sizes | tuple[float, float, float]:
    """The lot: means with ranges scatter; means alone are every seed's size; nothing
    stated: the paper's soybeans."""
    whole = [getattr(seed, f"{name}_mm") for name in WHOLE]
    ranges = [getattr(seed, name + RANGE) for name in WHOLE]
    if None in whole:
        if any(v is not None for v in (*whole, *ranges)):
            raise ValueError(
                "[seed] needs length_mm, width_mm and thickness_mm together"
            )
        return SOYBEAN_SIZES
    if None in ranges:
        length, width, thickness = (1e-3 * v for v in whole)
        return length, width, thickness
    scatter = [
        Size.from_range_of_100(1e-3 * low, 1e-3 * mean, 1e-3 * high)
        for (low, high), mean in zip(ranges, whole)
    ]
    return Sizes(
        scatter[0], scatter[1], scatter[2], correlation=SOYBEAN_SIZES.correlation
    )
