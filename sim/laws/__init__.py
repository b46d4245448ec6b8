"""Force laws, one a file: what a law may be, and how the engine combines them.

A law is a **pure scalar function**: plain floats in, a float or a tuple of floats out.
It knows nothing of arrays, devices or the engine, uses `math`, arithmetic and `if` only
(no numpy, try, strings, default or keyword arguments), and calls no other function of
ours, so the same source compiles with `numba.njit` and as a CUDA device function. It is
not decorated: the engine compiles it. All in SI units. It is finite for every argument
in its range, zero speed and zero overlap included.

A law file holds the function (docstring: formula, unit of each argument in brackets,
range of validity, numbered source, doctest) and one record `LAW = Law(name=…, kind=…,
function=…, parameters=(Parameter(…), …), source=…)`. The function takes the kind's
fixed arguments first, in this order, and then its own parameters by position:

    restitution       (impact_speed [m/s], e, …)
                      → restitution of this contact, in (0, 1]
    friction          (slip_speed [m/s], mu, …)
                      → coefficient of friction at that slip
    normal            (overlap [m], closing_speed [m/s], radius [m], modulus [Pa], …)
                      → force to ADD along the normal [N], > 0 pushes apart
    spring            (overlap [m], closing_speed [m/s], radius [m], modulus [Pa], e, …)
                      → in the PLACE of Hertz's: force [N], what the solids carry [N]
                      (≥ 0), stiffness S [N/m], damping γ [-] of a dashpot γ √(S m*)
    rolling_spin      (normal_force [N], spin_speed [rad/s], arm [m], mu_r, …)
                      → torque magnitude against a body's own spin [N m]
    rolling_relative  (normal_force [N], rolling_speed [rad/s], radius [m], mu_r, …)
                      → torque magnitude against relative rolling [N m]
    rolling_spring    as in `rolling_type_c`
                      → new spring moment (3) and torque (3) [N m]
    body              (vx, vy, vz [m/s], wx, wy, wz [rad/s], diameter [m], …)
                      → (fx, fy, fz [N], tx, ty, tz [N m]) on the body
    motion            (t [s], …) → (displacement [m] or angle [rad], its rate)

- `e`, `mu`, `mu_r` are what the user entered for the pair of materials (`Contact`);
  `radius` is the effective radius R* (1/R* = 1/R_i + 1/R_j; a wall has 1/R_j = 0),
  `modulus` the effective Young's modulus E*; `arm` the distance from the body's centre
  to the contact; `diameter` that of the sphere of the seed's volume.
- `impact_speed` is the closing speed at the moment of first touch, kept with the
  contact until it ends. `closing_speed` > 0 while approaching.
- normal, spring: `overlap` is negative while the surfaces are apart. A law without
  `reach` is called while they overlap. One with `reach(radius, modulus, …)` → [m] is
  called, for a pair that has touched, until −overlap exceeds the reach (a film or neck
  that then breaks). `Law(memory=…)` names what a contact remembers: numbers that are 0
  when it begins, arguments after the fixed ones, and come back after the results. What
  a spring says that the solids carry is capped by Coulomb's μ and rolled on; a normal
  force is not in it (of Hertz's spring it is EDEM's F_n). The tangential spring is
  Mindlin's share of a spring's stiffness, 4 (G*/E*) S.
- rolling_relative: rolling is the part of ω_i − ω_j across the normal (twist excluded);
  equal and opposite on the two bodies. rolling_spin: along each body's own −ω, as
  EDEM's standard model has it (not equal and opposite), and holding at ω = 0.
- motion: one scalar along a wall's direction or about its axis; the engine turns it
  into pose and velocity.

Combining: normal, rolling_relative, rolling_spin and body laws add up; restitution and
friction laws follow one another, the second taking the first's result for e or mu;
between two materials there is at most one spring and one rolling_spring. A contact's
`rolling_convention` brings rolling_edem, rolling_type_a, rolling_type_c or rolling_sds
with it; a rolling law chosen besides adds to that (or replaces its namesake). A contact
law may be limited to a pair of materials: `LAW.use(between=("soybean", "steel"), …)`. A
law that is not chosen is not compiled: it costs nothing.

`LAWS` holds the LAW of every module here, by name. A law from elsewhere needs no
entry: make a `Law` and choose it with `.use(…)`."""

from importlib import import_module
from pkgutil import iter_modules

from benchtwin.sim.laws.law import KINDS, Chosen, Law, Parameter

__all__ = ["KINDS", "LAWS", "Chosen", "Law", "Parameter"]

_modules = (import_module(f"{__name__}.{m.name}") for m in iter_modules(__path__))
LAWS: dict[str, Law] = {m.LAW.name: m.LAW for m in _modules if hasattr(m, "LAW")}
