"""A seed's balls as the twin weighs them: mass and inertia of what they enclose."""

import numpy as np

from sim.seed import Seed


def weighed(spheres_m: list[list[float]], density_kg_m3: float) -> tuple[list[list[float]], float, list[float]]:
    """Balls [x, y, z, r] [m] about their centre of mass along the principal axes, mass [kg], principal moments [kg m2].

    Mass and moments are those of the balls' union (`sim.seed.Seed.from_spheres`); ValueError says what is wrong with the balls.
    """
    balls_m = np.array(spheres_m, dtype=float)
    seed = Seed.from_spheres(balls_m[:, :3], balls_m[:, 3], density_kg_m3)
    balls = [[*map(float, centre), float(radius)] for centre, radius in zip(seed.centres_m, seed.radii_m)]
    return balls, float(seed.mass_kg), [float(moment) for moment in seed.inertia_kg_m2]
