"""States in the open format of the ON-DEM network, HDF5 in VTK's layout (.vtkhdf),
which ParaView opens: github.com/ON-DEM/ON-DEM-WG3-FileFormat, version 0.1-draft.

    /VTKHDF            PolyData: a point a ball, a line a contact between balls
    /VTKHDF/PointData  body_id, clump_id, material_id, radius, mass, volume, inertia,
                       position, velocity, orientation (x, y, z, w), angular_velocity
    /VTKHDF/CellData   normal_force, shear_force, overlap of each line
    /ONDEM/Scene       time, timestep, gravity, units
    /ONDEM/Materials/K density, young_modulus, poisson_ratio, label
    /ONDEM/Contacts    what each pair of materials was given: not in ON-DEM's schema
    /ONDEM/Bodies/Clumps   a row a seed of several balls
    /ONDEM/Bodies/Facets   a row a triangle of a wall; /Walls: endless planes
    /ONDEM/Interactions    id1, id2, normal, normal_force, shear_force, contact_point

Body ids count balls, then clumps, then walls. normal points from id1 to id2, and id1
feels normal_force · normal + shear_force: as the schema says, positive in traction."""

FORMAT, VERSION = "ON-DEM VTKHDF", "0.1-draft"
UNITS = ("second", "meter", "kilogram")
STATE = "state.vtkhdf"  # in the folder of a simulated recording


class Unfit(ValueError):
    """What is wrong with a file."""
