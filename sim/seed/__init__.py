"""Seeds as rigid clumps of overlapping balls, with mass and moments of inertia."""

from dataclasses import dataclass, replace

import numpy as np

from benchtwin.sim.material import within
from benchtwin.sim.seed import arrange, clump, solid, surface
from benchtwin.sim.seed.shape import Shape

Array = np.ndarray

MOST_SPHERES = 20
# [kg/m3] at 12.5 % moisture, the soybean calibration paper, "Test materials"
SOYBEAN_DENSITY = 1250.0


@dataclass(frozen=True, eq=False)
class Seed:
    """One rigid clump in its principal frame: origin at the centre of mass, axes along
    the principal moments of inertia.

    centres_m (n, 3), radii_m (n,): its balls. mass_kg; inertia_kg_m2 (3,): principal
    moments. density_kg_m3. dimensions_m (3,): intended length, width, thickness along
    x, y, z, or None for a clump given ball by ball. axes (3, 3), origin_m (3,): a point
    p of the frame in which the balls were given is at (p - origin_m) @ axes. shape:
    what the balls stand for, in the principal frame, if it is not an ellipsoid; mass
    and inertia are then the shape's."""

    centres_m: Array
    radii_m: Array
    mass_kg: float
    inertia_kg_m2: Array
    density_kg_m3: float
    dimensions_m: Array | None
    axes: Array
    origin_m: Array
    shape: Shape | None = None

    @classmethod
    def from_dimensions(
        cls,
        length_m: float,
        width_m: float,
        thickness_m: float,
        spheres: int = 5,
        *,
        density_kg_m3: float = SOYBEAN_DENSITY,
        arrangement: str = "axial",
        mass_of: str = "union",
    ) -> "Seed":
        """An ellipsoidal seed, length ≥ width ≥ thickness [m], each within 0.05 mm to 3
        m, of 1 to 20 balls.

        arrangement: "axial", the paper's row of balls along the long axis
        (`arrange.axial`; width and thickness become their geometric mean), or "planar"
        (`arrange.planar`; keeps the two apart, 6, 7 or 8 balls). mass_of: "union", what
        the balls enclose, or "ellipsoid", the closed form π ρ L W T/6, m (b² + c²)/5.
        `clump_error.clump_error` gives what the choice costs. Raises ValueError naming
        the parameter and its range.

        >>> seed = Seed.from_dimensions(8.72e-3, 6.84e-3, 5.98e-3)
        >>> len(seed.radii_m), round(1e3 * 2 * seed.bounding_radius_m, 3)
        (5, 8.72)
        >>> round(1e6 * seed.mass_kg)
        227
        """
        sizes = np.array([length_m, width_m, thickness_m], dtype=float)
        for name, value in zip(("length_m", "width_m", "thickness_m"), sizes):
            within(name, value, 5e-5, 3.0, "m")
        if not length_m >= width_m >= thickness_m:
            raise ValueError(
                f"length_m ≥ width_m ≥ thickness_m is needed, not {length_m:g},"
                f" {width_m:g}, {thickness_m:g}"
            )
        if not 1 <= spheres <= MOST_SPHERES:
            raise ValueError(f"spheres = {spheres}: must be 1 to {MOST_SPHERES}")
        if mass_of not in ("union", "ellipsoid"):
            raise ValueError(f"mass_of = {mass_of!r}: must be 'union' or 'ellipsoid'")
        if arrangement not in ARRANGEMENTS:
            raise ValueError(
                f"arrangement = {arrangement!r}: must be one of"
                f" {', '.join(ARRANGEMENTS)}"
            )
        centres, radii = ARRANGEMENTS[arrangement](
            length_m, width_m, thickness_m, spheres
        )
        seed = replace(
            cls.from_spheres(centres, radii, density_kg_m3), dimensions_m=sizes
        )
        if mass_of == "union":
            return seed
        whole = solid.ellipsoid(*sizes)
        moments = np.diag(whole.inertia(density_kg_m3)).copy()
        return replace(
            seed, mass_kg=density_kg_m3 * whole.volume_m3, inertia_kg_m2=moments
        )

    @classmethod
    def from_spheres(
        cls, centres_m: Array, radii_m: Array, density_kg_m3: float = SOYBEAN_DENSITY
    ) -> "Seed":
        """A clump of any 1 to 20 connected balls, centres (n, 3) and radii (n,) [m];
        mass and inertia of their union.

        Axes: those of the list where they are principal already, else the principal
        axes nearest to them. Raises ValueError for shapes that do not fit, values that
        are not finite, radii outside 1 µm to 10 m, a ball wholly inside another (it
        would never be touched alone but stiffen every contact there), and balls that
        are not connected."""
        centres = np.array(centres_m, dtype=float).reshape(-1, 3)
        radii = np.atleast_1d(np.array(radii_m, dtype=float))
        _check_balls(centres, radii)
        within("density_kg_m3", density_kg_m3, 0.01, 30_000.0, "kg/m3")
        whole = solid.union_of_balls(centres, radii)
        moments, axes = solid.principal(whole.inertia(density_kg_m3))
        local = (centres - whole.centre_m) @ axes
        local[np.abs(local) < 1e-12 * radii.max()] = 0.0
        mass = density_kg_m3 * whole.volume_m3
        return cls(
            local, radii, mass, moments, density_kg_m3, None, axes, whole.centre_m
        )

    @classmethod
    def from_shape(cls, shape: Shape, spheres: int, density_kg_m3: float) -> "Seed":
        """Any closed shape as a clump of 1 to 20 balls fitted to its surface
        (`clump.fit_clump`), which are what touches.

        Mass, centre of mass and inertia are the shape's own, not the clump's; so are
        the dimensions: its extents along the principal axes, longest first. Fewer balls
        where there is no place for more. Raises ValueError as `from_spheres` does."""
        if not 1 <= spheres <= MOST_SPHERES:
            raise ValueError(f"spheres = {spheres}: must be 1 to {MOST_SPHERES}")
        within("density_kg_m3", density_kg_m3, 0.01, 30_000.0, "kg/m3")
        centres, radii, _ = clump.fit_clump(shape, spheres)
        own, axes, origin = shape.principal()
        centres = (centres - origin) @ axes
        _check_balls(centres, radii)
        sizes = np.ptp(own.vertices_m, axis=0)
        moments = np.diag(own.solid.inertia(density_kg_m3)).copy()
        mass = density_kg_m3 * own.volume_m3
        return cls(
            centres, radii, mass, moments, density_kg_m3, sizes, axes, origin, own
        )

    @property
    def bounding_radius_m(self) -> float:
        """Radius of the sphere about the centre of mass that holds every ball [m]."""
        return float(np.max(np.linalg.norm(self.centres_m, axis=1) + self.radii_m))

    @property
    def volume_m3(self) -> float:
        """Mass over density [m3]."""
        return self.mass_kg / self.density_kg_m3

    def mesh(self, level: int = 2, of: str = "ellipsoid") -> surface.Mesh:
        """Triangle mesh in the principal frame, 20·4^level faces: of the intended
        "ellipsoid", or of the "union" of the balls.

        A seed from a shape has that instead of the ellipsoid, in at most so many faces;
        a clump given ball by ball has neither: its union is drawn. Raises ValueError
        for another `of` or level."""
        if of not in ("ellipsoid", "union"):
            raise ValueError(f"of = {of!r}: must be 'ellipsoid' or 'union'")
        if of == "ellipsoid" and self.shape is not None:
            return self.shape.mesh(surface.face_count(level))
        if of == "union" or self.dimensions_m is None:
            return surface.union_mesh(self.centres_m, self.radii_m, level)
        return surface.ellipsoid_mesh(self.dimensions_m / 2.0, level)


def _check_balls(centres: Array, radii: Array) -> None:
    n = len(radii)
    if len(centres) != n or radii.ndim != 1:
        raise ValueError(
            f"centres_m has {len(centres)} rows, radii_m {radii.shape}: one centre and"
            " one radius a ball"
        )
    if not 1 <= n <= MOST_SPHERES:
        raise ValueError(f"{n} balls: a seed has 1 to {MOST_SPHERES}")
    if not np.isfinite(centres).all():
        raise ValueError("centres_m: every value must be finite")
    for i, radius in enumerate(radii):
        within(f"radii_m[{i}]", radius, 1e-6, 10.0, "m")
    distance = np.linalg.norm(centres[:, None] - centres, axis=2)
    hidden = (distance + radii[:, None] <= radii) & ~np.eye(n, dtype=bool)
    if hidden.any():
        i, j = np.argwhere(hidden)[0]
        raise ValueError(f"ball {i} lies wholly inside ball {j}: leave it out")
    if (apart := np.flatnonzero(clump.pieces(centres, radii))).size:
        raise ValueError(
            f"ball {apart[0]} touches none of those connected to ball 0: a seed is one"
            " piece"
        )


ARRANGEMENTS = {"axial": arrange.axial, "planar": arrange.planar}
