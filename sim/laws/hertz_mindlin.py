"""Hertz–Mindlin contact without slip, EDEM convention: the force law of every contact
for which no other spring is chosen.

Not a plug-in: the other laws act on what these functions return. Pure scalar functions
as described in `sim.laws`.

Sources:
1. DEM Solutions, EDEM user guide, "Hertz–Mindlin (no slip)".
2. Tsuji, Tanaka, Ishida (1992), Powder Technol. 71, 239–250: the damping that keeps e
   independent of speed.
3. Mindlin (1949), J. Appl. Mech. 16, 259–268: the tangential stiffness 8 G* √(R* δ).
"""

import math


def damping_factor(e):
    """γ = −2 √(5/6) ln e / √(ln² e + π²) [-], so that a damping force γ √(S m*) v lets
    a pair rebound with restitution e.

    e [-] in [0, 1]. The rebound comes out as entered if the damped force may pull at
    the end of contact; clipped at zero it is larger (e = .2 .4 .5 .6 .8 .9 → .3249
    .4720 .5503 .6323 .8081 .9020, at any speed and material).

    >>> damping_factor(1.0)
    0.0
    >>> round(damping_factor(0.5), 6), round(damping_factor(0.0), 6)
    (0.393363, 1.825742)
    """
    if e <= 0.0:
        return 1.8257418583505538  # 2 √(5/6), the limit
    if e >= 1.0:
        return 0.0
    log = math.log(e)
    return -1.8257418583505538 * log / math.sqrt(log * log + 9.869604401089358)


def normal_stiffness(overlap, radius, modulus):
    """S_n = 2 E* √(R* δ) [N/m]; overlap δ ≥ 0 [m], radius R* [m], modulus E* [Pa]
    (source 1).

    >>> round(normal_stiffness(1e-6, 0.004, 1e9), 3)
    126491.106
    """
    return 2.0 * modulus * math.sqrt(radius * overlap)


def elastic_force(stiffness, overlap):
    """(4/3) E* √R* δ^1.5 = (2/3) S_n δ [N]; stiffness S_n [N/m], overlap δ ≥ 0 [m]
    (source 1).

    >>> round(elastic_force(3e5, 1e-6), 9)
    0.2
    """
    return (2.0 / 3.0) * stiffness * overlap


def damping_force(stiffness, closing_speed, mass, damping):
    """γ √(S_n m*) v [N] (source 2), with the elastic force > 0 apart.

    stiffness S_n [N/m], closing_speed v [m/s] > 0 while approaching, mass m* [kg],
    damping γ [-]. Negative while the bodies part; the sum with the elastic force may
    then be attractive.

    >>> round(damping_force(1e5, 0.2, 1e-3, 0.4), 9)
    0.8
    """
    return damping * math.sqrt(stiffness * mass) * closing_speed


def tangential_force(
    sx, sy, sz, nx, ny, nz, vx, vy, vz, dt, stiffness, mass, damping, limit
):
    """Spring, dashpot and Coulomb's cap across the normal (sources 1, 3).

    sx sy sz [m] the tangential displacement so far; n the unit normal; v [m/s] the slip
    velocity, across n; dt [s]; stiffness S_t = 8 G* √(R* δ) [N/m]; mass m* [kg];
    damping γ [-]; limit μ F_n [N] ≥ 0, F_n the Hertz force. The displacement is first
    turned with the contact (laid across the new normal, its length kept), then grows by
    v dt; F = −S_t s − γ √(S_t m*) v, and where |F| > limit, F is cut to it and the
    spring is left holding just that (were it left holding F less the dashpot's part, as
    some codes do, fast sliding under growing load would brake too little: by 4 % of the
    impulse in Chung & Ooi's test 6). Returns F (3) on the first body and the new s (3).

    >>> held = tangential_force(
    ...     0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1e-6, 1e5, 1e-3, 0.0, 1.0
    ... )
    >>> [round(v, 9) for v in held]
    [-0.1, -0.0, -0.0, 1e-06, 0.0, 0.0]
    >>> sliding = tangential_force(
    ...     1e-3, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1e-6, 1e5, 1e-3, 0.0, 1.0
    ... )
    >>> round(sliding[0], 9)
    -1.0
    """
    before = sx * sx + sy * sy + sz * sz
    along = sx * nx + sy * ny + sz * nz
    sx = sx - along * nx
    sy = sy - along * ny
    sz = sz - along * nz
    after = sx * sx + sy * sy + sz * sz
    turn = math.sqrt(before / max(after, 1e-300))
    sx = sx * turn + vx * dt
    sy = sy * turn + vy * dt
    sz = sz * turn + vz * dt
    c = damping * math.sqrt(stiffness * mass)
    fx = -stiffness * sx - c * vx
    fy = -stiffness * sy - c * vy
    fz = -stiffness * sz - c * vz
    size = math.sqrt(fx * fx + fy * fy + fz * fz)
    if size > limit:
        cut = limit / size
        fx = fx * cut
        fy = fy * cut
        fz = fz * cut
        softness = 1.0 / max(stiffness, 1e-300)
        sx = -fx * softness
        sy = -fy * softness
        sz = -fz * softness
    return fx, fy, fz, sx, sy, sz
