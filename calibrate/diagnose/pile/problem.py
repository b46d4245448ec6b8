"""Heaps as a problem: the surface of each flank, its angle and the plate's line, all linear in what is asked.

surface   v(u) = max(1 − u, 0) + usual(u) + the material's own (global bumps) + the packing's own (local level, slope, crest,
          toe and bow of each flank) + effects
angle     θ = θ₀ + side · (turn of the heap in the picture) + effects
plate     inclination against the stated plumb = base tilt + camera roll
creep     how much flatter from the first to the last photo of one heap = settling + base vibration
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from calibrate.diagnose.effects.pile import candidates
from calibrate.diagnose.effects.pile.shapes import Law, crest, toe
from calibrate.diagnose.linear import Reduced
from calibrate.diagnose.noise import Noise, Stretch, estimate, frame_lag, whiten
from calibrate.diagnose.pile import usual
from calibrate.diagnose.pile.flanks import STEP, Flank, Photo
from calibrate.diagnose.problem import Problem
from calibrate.diagnose.series import Locals, Series
from calibrate.diagnose.series import problem_of as series_problem

SIGMA_FLOOR = 0.003  # of the height: drawn surfaces are smoother than the family of shapes is true
LEVEL_SD_DEG, LOPSIDED_SD_DEG, PLATE_FLOOR_DEG = 0.2, 0.4, 0.05
SETTLING_SD_DEG, CREEP_SD_DEG = 0.1, 0.1  # by which all heaps settle between photos; of one heap's, before repeats say more
REPOSE_SD_DEG = 20.0
LEVEL_DOUBT = 0.15  # of ln of the noise's power: packings are not Gaussian, and repeats are few
WAVES, SHORT = 6, 5  # orders of what nobody asked about; of shorter waves, whose power is roughness alone
SKIN = 0.5  # seeds: beyond, the roughness of grains is not correlated
ALIKE_P = 0.01  # below: repeats differ by more in long waves than roughness in short ones, and they alone are believed
# What differs by itself with a stated condition, per unit of its logarithm: crest, toe [height], angle [deg]. That a heap is the
# flatter the faster its gate (18.4°, 12.3°, 10.4° at 10, 25, 50 mm/s) is what `gate-speed` says, and no usual state.
NATURAL = {
    "gate_speed_mm_s": (0.01, 0.01, 0.5),
    "seed_mm": (0.02, 0.03, 1.5),
    "width_mm": (0.01, 0.01, 1.0),
    "photo_s": (0.005, 0.005, 0.3),
    "rig_mm": (0.02, 0.03, 1.5),  # as the seeds': how many seeds a heap is high
}


@dataclass(frozen=True, eq=False)
class Model:
    """photos; base (R tuples): what the usual heap shows; columns (R): (n_r, G) of the globals by `names`; own (R): (n_r, L)."""

    photos: tuple[Photo, ...]
    names: tuple[str, ...]
    base: tuple[np.ndarray, ...]
    columns: tuple[np.ndarray, ...]
    own: tuple[np.ndarray, ...]

    def predict(self, r: int, own: np.ndarray, values: dict[str, float]) -> np.ndarray:
        """What photo r shows."""
        return self.base[r] + self.own[r] @ own + self.columns[r] @ np.array([values[n] for n in self.names])


def problem_of(photos: tuple[Photo, ...]) -> Problem:
    """What these photos leave open, their noise and packing scatter estimated from themselves."""
    effects, laws = candidates(photos)
    nuisances = _nuisances(photos)
    names = (*effects, *nuisances)
    lags, one = _lags(photos)
    noise, sigma = _noise(photos, lags, one)
    packing = _packing(photos, lags, noise, sigma)
    model = _model(photos, names, laws)
    creep_sd = _creep_sd(photos)
    series = tuple(_series(p, s, noise, packing["angle_deg"], creep_sd, lags) for p, s in zip(photos, sigma, strict=True))
    held = np.array([0.5, 0.5, packing["crest"], packing["toe"], packing["middle"]] * 2)
    count = len(photos)
    own = Locals(np.zeros((count, len(held))), np.full(len(held), 1e-3), held)
    known = nuisances | {"base-tilt": LEVEL_SD_DEG, "camera-roll": max(p.plumb_sd_deg for p in photos)}
    made = series_problem("pile", series, own, model.predict, effects, nuisances, known, model, turns=2)
    return replace(made, level_sd=max(LEVEL_DOUBT, noise.log_level_sd), common_smooth=True, reduce=_once(made))


def _once(problem: Problem):
    """`problem.reduce` computed once: heaps are linear, so that it is the same wherever it is taken."""
    zero = np.zeros(len(problem.names))
    there, change_from_zero = problem.reduce(problem.starts, zero)
    reduced = tuple(Reduced(r.a, r.smooth, r.b) for r in there)  # without what holds at that point only

    def reduce(starts: np.ndarray, values: np.ndarray, extra=None):
        if extra is not None:
            return problem.reduce(starts, values, extra)
        return reduced, lambda moved: problem.starts + change_from_zero(values + moved) - starts

    return reduce


def differing(photos: tuple[Photo, ...]) -> tuple[str, ...]:
    """Stated conditions that differ between photos."""
    values = {q: np.array([getattr(p, q) for p in photos]) for q in NATURAL}
    return tuple(q for q, v in values.items() if np.isfinite(v).all() and v.max() > 1.05 * v.min())


def _nuisances(photos: tuple[Photo, ...]) -> dict[str, float]:
    """Globals beside the candidates, with their sd."""
    known = {"repose": REPOSE_SD_DEG, "lopsided": LOPSIDED_SD_DEG} | {f"usual-{k}": 1.0 for k in range(usual.COLUMNS)}
    if any(_has_creep(p) for p in photos):
        known["settling"] = SETTLING_SD_DEG
    for quantity in differing(photos):
        known |= dict(zip((f"{quantity}:{part}" for part in ("crest", "toe", "angle")), NATURAL[quantity], strict=True))
    return known


def _model(photos: tuple[Photo, ...], names: tuple[str, ...], laws: dict[str, Law]) -> Model:
    weights = {n: laws[n].weight(photos) for n in names if n in laws}
    logs = {q: np.log(np.array([getattr(p, q) for p in photos])) for q in differing(photos)}
    centre = _centre_deg(photos)
    base, columns, own = [], [], []
    for r, photo in enumerate(photos):
        made = []
        for name in names:
            if name in laws:
                made.append(weights[name][r] * _column(photo, laws[name]))
            else:
                made.append(_nuisance(photo, name, {q: v[r] - v.mean() for q, v in logs.items()}))
        columns.append(np.column_stack(made))
        seen = [straight(f.u) + usual.mean(f.u, seeds_high(photo, f)) for f in photo.flanks]
        base.append(np.concatenate([*seen, np.full(len(photo.flanks), centre), [0.0] * (_has_plate(photo) + _has_creep(photo))]))
        own.append(_locals(photo))
    return Model(photos, names, tuple(base), tuple(columns), tuple(own))


def straight(u: np.ndarray) -> np.ndarray:
    """The flank's line down to the plate, and the plate."""
    return np.maximum(1 - u, 0.0)


def seeds_high(photo: Photo, flank: Flank) -> float:
    """The heap's height over a seed's length, NaN where scale or seed is not stated."""
    return flank.height / photo.seed_mm if photo.unit == "mm" else float("nan")


def _centre_deg(photos: tuple[Photo, ...]) -> float:
    return float(np.mean([f.angle_deg for p in photos for f in p.flanks]))


def _has_plate(photo: Photo) -> int:
    return int(np.isfinite(photo.plate_deg))


def _has_creep(photo: Photo) -> int:
    return int(np.isfinite(photo.creep_deg))


def _rows(photo: Photo, surface, angle, plate: float, creep: float = 0.0) -> np.ndarray:
    """Rows of a photo from what each flank's surface (u) and angle (side) do, the plate's line, and what goes on."""
    parts = [np.zeros(len(f.u)) if surface is None else surface(f.u) for f in photo.flanks]
    last = [[plate] * _has_plate(photo), [creep] * _has_creep(photo)]
    return np.concatenate([*parts, [angle(f.side) for f in photo.flanks], *last])

def _column(photo: Photo, law: Law) -> np.ndarray:
    turn = (law.turn_deg or {}).get(photo.reference, 0.0)
    return _rows(photo, law.surface, lambda side: law.angle_deg + side * turn, law.plate_deg, law.creep_deg)


def _nuisance(photo: Photo, name: str, logs: dict[str, float]) -> np.ndarray:
    """repose: all flanks steeper; lopsided: one steeper, one less so; usual-k: bumps; quantity:part: natural changes; settling:
    all a little flatter with time."""
    if name == "settling":
        return _rows(photo, None, lambda side: 0.0, 0.0, 1.0)
    if name == "repose":
        return _rows(photo, None, lambda side: 1.0, 0.0)
    if name == "lopsided":
        return _rows(photo, None, lambda side: float(side), 0.0)
    if name.startswith("usual-"):
        high = float(np.mean([seeds_high(photo, f) for f in photo.flanks]))
        return _rows(photo, lambda u: usual.bumps(u, high)[:, int(name.removeprefix("usual-"))], lambda side: 0.0, 0.0)
    quantity, part = name.split(":")
    surface = {"crest": crest, "toe": toe, "angle": None}[part]
    return logs[quantity] * _rows(photo, surface, lambda side: float(part == "angle"), 0.0)


def _locals(photo: Photo) -> np.ndarray:
    """(n_r, 10): level, slope and the packing's crest, toe and bow of the first flank, then of the second."""
    out = np.zeros((sum(len(f.u) for f in photo.flanks) + len(photo.flanks) + _has_plate(photo) + _has_creep(photo), 10))
    row = 0
    for k, f in enumerate(photo.flanks):
        out[row : row + len(f.u), 5 * k : 5 * k + 5] = _packed(f.u)
        row += len(f.u)
    return out


def _series(
    photo: Photo, sigma: float, noise: Noise, angle_sd_deg: float, creep_sd_deg: float, lags: dict[int, np.ndarray]
) -> Series:
    alone = np.full(len(photo.flanks) + _has_plate(photo) + _has_creep(photo), np.inf)
    lag = np.concatenate([*(lags[id(f)] for f in photo.flanks), alone])
    angles, plate = [f.angle_deg for f in photo.flanks], [photo.plate_deg] * _has_plate(photo)
    sigmas = [np.full(len(f.u), sigma) for f in photo.flanks]
    plate_sd = [float(np.hypot(photo.plate_sd_deg, PLATE_FLOOR_DEG))] * _has_plate(photo)
    creep, creep_sd = [photo.creep_deg] * _has_creep(photo), [creep_sd_deg] * _has_creep(photo)
    data = np.concatenate([*(f.v for f in photo.flanks), angles, plate, creep])
    sd = np.concatenate([*sigmas, [angle_sd_deg] * len(angles), plate_sd, creep_sd])
    return Series(photo.recording, data, sd, lag, noise, _smooth(photo))


def _smooth(photo: Photo) -> np.ndarray:
    """Cosines along all flanks alike: what heaps could show that nobody asked about."""
    out = np.zeros((len(_locals(photo)), WAVES))
    row = 0
    for f in photo.flanks:
        out[row : row + len(f.u)] = np.cos(np.pi * f.u[:, None] * np.arange(2, WAVES + 2))
        row += len(f.u)
    return out


def _cosines(u: np.ndarray, orders) -> np.ndarray:
    at = (u - u[0]) / (u[-1] - u[0])
    return np.cos(np.pi * at[:, None] * np.array(list(orders)))


def _grain(photo: Photo) -> float:
    """Seed's length over the photo's unit, NaN where either is not stated."""
    return photo.seed_mm if photo.unit == "mm" else float("nan")


def _lags(photos: tuple[Photo, ...]) -> tuple[dict[int, np.ndarray], float]:
    """Rows' distances of each flank, by its id, such that roughness is correlated alike in all: in seeds where they are known;
    and the distance of 1 in seeds, NaN where they are not."""
    flanks = [(f, f.length / _grain(p)) for p in photos for f in p.flanks]
    one = STEP * float(np.mean([seeds for _, seeds in flanks]))
    return {id(f): frame_lag(f.u / STEP if np.isnan(one) else f.u * seeds / one) for f, seeds in flanks}, one


def _noise(photos: tuple[Photo, ...], lags: dict[int, np.ndarray], one: float) -> tuple[Noise, list[float]]:
    """Roughness of the surface: its correlation, common to all and no longer than SKIN seeds, and each photo's sd, in proportion
    to seed over height where these are known.

    Its power is asked for where missing physics lives: of waves just shorter than a flexible curve takes up, and, of longer ones,
    what differs between repeats beside that which packings vary.
    """
    flanks = [(p, f) for p in photos for f in p.flanks]
    noise = estimate([Stretch(_cosines(f.u, range(WAVES + 3)), f.v, lags[id(f)]) for _, f in flanks])
    if np.isfinite(one):
        noise = replace(noise, rho=min(noise.rho, float(np.exp(-one / SKIN))))
    size = np.array([_grain(p) / f.height if np.isfinite(one) else 1.0 for p, f in flanks])
    high = range(WAVES + 3, WAVES + 3 + SHORT)
    short = [_waves(f, lags[id(f)], noise, _cosines(f.u, range(WAVES + 3)), high) for _, f in flanks]
    long = [_waves(f, lags[id(f)], noise, _packed(f.u), range(3, WAVES + 3)) for _, f in flanks]
    groups: dict[tuple, list[np.ndarray]] = {}
    for (p, f), k, z in zip(flanks, size, long, strict=True):
        groups.setdefault((p.stated, f.side), []).append(z / k)
    apart = [np.array(g) - np.mean(g, axis=0) for g in groups.values()]
    repeated, freedom = sum(float((x**2).sum()) for x in apart), sum((len(x) - 1) * x.shape[1] for x in apart)
    here = np.concatenate([z / k for k, z in zip(size, short, strict=True)])
    power, count = (float(here @ here) + repeated) / (len(here) + freedom), len(here) + freedom
    if freedom and stats.f.sf(repeated / freedom * len(here) / float(here @ here), freedom, len(here)) < ALIKE_P:
        power, count = repeated / freedom, freedom
    noise = replace(noise, log_level_sd=float(np.sqrt(2 / count)))
    more = float(np.exp(noise.log_level_sd / 2))  # one sd more than it seems to have: angles have doubts of their own
    each: dict[int, list[float]] = {id(p): [] for p in photos}
    for (p, _), k in zip(flanks, size, strict=True):
        each[id(p)].append(k)
    return noise, [max(more * float(np.sqrt(power)) * float(np.mean(each[id(p)])), SIGMA_FLOOR) for p in photos]


def _waves(flank: Flank, lag: np.ndarray, noise: Noise, beside: np.ndarray, orders) -> np.ndarray:
    """Whitened amplitudes (k,) of cosines of these orders beside the columns `beside`, of variance 1 where σ is 1."""
    rows = np.column_stack([beside, _cosines(flank.u, orders), flank.v - straight(flank.u)])
    white = whiten(rows[:, None, :], lag[:, None], noise.rho, noise.white)[0][:, 0]
    return np.linalg.qr(white[:, :-1])[0][:, beside.shape[1] :].T @ white[:, -1]


def _creep_sd(photos: tuple[Photo, ...]) -> float:
    """Scatter between heaps of what goes on [deg]."""
    seen = np.array([p.creep_deg for p in photos if _has_creep(p)])
    return usual.pooled_sd(seen, np.zeros(len(seen)), [0] * len(seen), CREEP_SD_DEG)


def _packed(u: np.ndarray) -> np.ndarray:
    """What packings vary: level, slope, crest, toe and bow."""
    return np.column_stack([np.ones(len(u)), u - 0.5, *(part(u) for part in usual.PARTS.values())])


def _packing(photos: tuple[Photo, ...], lags: dict[int, np.ndarray], noise: Noise, sigma: list[float]) -> dict[str, float]:
    """Scatter of one flank's angle and of its crest, toe and bow between repeats, the roughness' share of these taken off."""
    flanks = [(p, f, sd) for p, sd in zip(photos, sigma, strict=True) for f in p.flanks]
    group = [(p.stated, f.side) for p, f, _ in flanks]
    angles = np.array([f.angle_deg for _, f, _ in flanks])
    out = {"angle_deg": usual.pooled_sd(angles, np.zeros(len(angles)), group, usual.PACKING_SD["angle_deg"])}
    parts, doubts = [], []
    for _, f, sd in flanks:
        rows = np.column_stack([_packed(f.u), f.v - straight(f.u)])
        white = whiten(rows[:, None, :] / sd, lags[id(f)][:, None], noise.rho, noise.white)[0][:, 0]
        inverse = np.linalg.inv(white[:, :-1].T @ white[:, :-1])
        parts.append((inverse @ (white[:, :-1].T @ white[:, -1]))[2:])
        doubts.append(np.sqrt(np.diag(inverse))[2:])
    for name, values, errors in zip(usual.PARTS, np.array(parts).T, np.array(doubts).T, strict=True):
        out[name] = usual.pooled_sd(values, errors, group, usual.PACKING_SD[name])
    return out
