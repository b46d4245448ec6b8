"""Heaps as a problem: the surface of each flank, its angle and the plate's line, all linear in what is asked.

surface   v(u) = max(1 − u, 0) + usual(u) + the material's own (global bumps) + the packing's own (local level, slope, crest,
          toe and bow of each flank) + effects
angle     θ = θ₀ + side · (turn of the heap in the picture) + effects
plate     inclination against the stated plumb = base tilt + camera roll
"""

from dataclasses import dataclass, replace

import numpy as np

from calibrate.diagnose.effects.pile import EFFECTS, LAWS, RIVALS
from calibrate.diagnose.effects.pile.shapes import crest, toe
from calibrate.diagnose.linear import Reduced
from calibrate.diagnose.noise import Noise, Stretch, estimate, frame_lag, whiten
from calibrate.diagnose.pile import usual
from calibrate.diagnose.pile.flanks import STEP, Flank, Photo
from calibrate.diagnose.problem import Problem
from calibrate.diagnose.series import Locals, Series
from calibrate.diagnose.series import problem_of as series_problem

SIGMA_FLOOR = 0.003  # of the height: drawn surfaces are smoother than the family of shapes is true
LEVEL_SD_DEG, LOPSIDED_SD_DEG, PLATE_FLOOR_DEG = 0.2, 0.4, 0.05
REPOSE_SD_DEG = 20.0
LEVEL_DOUBT = 0.15  # of ln of the noise's power: packings are not Gaussian, and repeats are few
WAVES = 6
# What differs by itself with a stated condition, per unit of its logarithm: crest, toe [height], angle [deg]
NATURAL = {
    "gate_speed_mm_s": (0.03, 0.03, 5.0),
    "seed_mm": (0.02, 0.03, 1.5),
    "width_mm": (0.01, 0.01, 1.0),
    "photo_s": (0.005, 0.005, 0.3),
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
    effects = {n: e for n, e in (EFFECTS | RIVALS).items() if _can_show(n, photos)}
    nuisances = _nuisances(photos)
    names = (*effects, *nuisances)
    noise, sigma = _noise(photos)
    packing = _packing(photos)
    model = _model(photos, names, nuisances)
    series = tuple(_series(p, s, noise, packing["angle_deg"]) for p, s in zip(photos, sigma, strict=True))
    held = np.array([0.5, 0.5, packing["crest"], packing["toe"], packing["middle"]] * 2)
    count = len(photos)
    own = Locals(np.zeros((count, len(held))), np.full(len(held), 1e-3), held)
    known = nuisances | {"base-tilt": LEVEL_SD_DEG, "camera-roll": max(p.plumb_sd_deg for p in photos)}
    made = series_problem("pile", series, own, model.predict, effects, nuisances, known, model, turns=2)
    return replace(made, level_sd=LEVEL_DOUBT, common_smooth=True, reduce=_once(made))


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


def _can_show(name: str, photos: tuple[Photo, ...]) -> bool:
    """Angles tell of an effect only where a stated condition of its law differs."""
    weight = LAWS[name].weight
    return not name.endswith(".angle") or bool(weight and np.ptp(weight(photos)) > 0.05)


def differing(photos: tuple[Photo, ...]) -> tuple[str, ...]:
    """Stated conditions that differ between photos."""
    values = {q: np.array([getattr(p, q) for p in photos]) for q in NATURAL}
    return tuple(q for q, v in values.items() if np.isfinite(v).all() and v.max() > 1.05 * v.min())


def _nuisances(photos: tuple[Photo, ...]) -> dict[str, float]:
    """Globals beside the candidates, with their sd."""
    known = {"repose": REPOSE_SD_DEG, "lopsided": LOPSIDED_SD_DEG} | {f"usual-{k}": 1.0 for k in range(usual.COLUMNS)}
    for quantity in differing(photos):
        known |= dict(zip((f"{quantity}:{part}" for part in ("crest", "toe", "angle")), NATURAL[quantity], strict=True))
    return known


def _model(photos: tuple[Photo, ...], names: tuple[str, ...], nuisances: dict[str, float]) -> Model:
    weights = {n: LAWS[n].weight(photos) if LAWS[n].weight else np.ones(len(photos)) for n in names if n in LAWS}
    logs = {q: np.log(np.array([getattr(p, q) for p in photos])) for q in differing(photos)}
    centre = _centre_deg(photos)
    base, columns, own = [], [], []
    for r, photo in enumerate(photos):
        made = []
        for name in names:
            if name in LAWS:
                made.append(weights[name][r] * _column(photo, LAWS[name]))
            else:
                made.append(_nuisance(photo, name, {q: v[r] - v.mean() for q, v in logs.items()}))
        columns.append(np.column_stack(made))
        seen = [straight(f.u) + usual.mean(f.u, seeds_high(photo, f)) for f in photo.flanks]
        base.append(np.concatenate([*seen, np.full(len(photo.flanks), centre), [0.0] * _has_plate(photo)]))
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


def _rows(photo: Photo, surface, angle, plate: float) -> np.ndarray:
    """Rows of a photo from what each flank's surface (u) and angle (side) do, and the plate's line."""
    parts = [np.zeros(len(f.u)) if surface is None else surface(f.u) for f in photo.flanks]
    return np.concatenate([*parts, [angle(f.side) for f in photo.flanks], [plate] * _has_plate(photo)])


def _column(photo: Photo, law) -> np.ndarray:
    turn = (law.turn_deg or {}).get(photo.reference, 0.0)
    return _rows(photo, law.surface, lambda side: law.angle_deg + side * turn, law.plate_deg)


def _nuisance(photo: Photo, name: str, logs: dict[str, float]) -> np.ndarray:
    """repose: all flanks steeper; lopsided: one steeper, one less so; usual-k: bumps; quantity:part: natural changes."""
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
    out = np.zeros((sum(len(f.u) for f in photo.flanks) + len(photo.flanks) + _has_plate(photo), 10))
    row = 0
    for k, f in enumerate(photo.flanks):
        columns = [np.ones(len(f.u)), f.u - 0.5, *(part(f.u) for part in usual.PARTS.values())]
        out[row : row + len(f.u), 5 * k : 5 * k + 5] = np.column_stack(columns)
        row += len(f.u)
    return out


def _series(photo: Photo, sigma: float, noise: Noise, angle_sd_deg: float) -> Series:
    alone = np.full(len(photo.flanks) + _has_plate(photo), np.inf)
    lag = np.concatenate([*(frame_lag(f.u / STEP) for f in photo.flanks), alone])
    angles, plate = [f.angle_deg for f in photo.flanks], [photo.plate_deg] * _has_plate(photo)
    sigmas = [np.full(len(f.u), sigma) for f in photo.flanks]
    plate_sd = [float(np.hypot(photo.plate_sd_deg, PLATE_FLOOR_DEG))] * _has_plate(photo)
    data = np.concatenate([*(f.v for f in photo.flanks), angles, plate])
    return Series(
        photo.recording, data, np.concatenate([*sigmas, [angle_sd_deg] * len(angles), plate_sd]), lag, noise, _smooth(photo)
    )


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


def _noise(photos: tuple[Photo, ...]) -> tuple[Noise, list[float]]:
    """Roughness of the surface about a flexible curve: its correlation, common to all, and each photo's sd."""
    designs = {id(f): _cosines(f.u, range(WAVES + 3)) for p in photos for f in p.flanks}
    stretches = [Stretch(designs[id(f)], f.v, frame_lag(f.u / STEP)) for p in photos for f in p.flanks]
    noise = estimate(stretches)
    sigma = []
    for p in photos:
        left, freedom = 0.0, 0
        for f in p.flanks:
            rows = np.column_stack([designs[id(f)], f.v])
            white = whiten(rows[:, None, :], frame_lag(f.u / STEP)[:, None], noise.rho, noise.white)[0][:, 0]
            rest = white[:, -1] - white[:, :-1] @ np.linalg.lstsq(white[:, :-1], white[:, -1], rcond=None)[0]
            left, freedom = left + float(rest @ rest), freedom + len(rest) - white.shape[1] + 1
        high = float(
            np.exp(noise.log_level_sd / 2)
        )  # one sd more than the roughness seems to have: angles have doubts of their own
        sigma.append(max(high * float(np.sqrt(left / max(freedom, 1))), SIGMA_FLOOR))
    return noise, sigma


def _packing(photos: tuple[Photo, ...]) -> dict[str, float]:
    """Scatter of one flank's angle and of its crest, toe and bow between repeats."""
    flanks = [(p, f) for p in photos for f in p.flanks]
    group = [(p.stated, f.side) for p, f in flanks]
    out = {"angle_deg": usual.pooled_sd(np.array([f.angle_deg for _, f in flanks]), group, usual.PACKING_SD["angle_deg"])}
    parts = []
    for _, f in flanks:
        design = np.column_stack([np.ones(len(f.u)), f.u - 0.5, *(part(f.u) for part in usual.PARTS.values())])
        parts.append(np.linalg.lstsq(design, f.v - straight(f.u), rcond=None)[0][2:])
    for name, values in zip(usual.PARTS, np.array(parts).T, strict=True):
        out[name] = usual.pooled_sd(values, group, usual.PACKING_SD[name])
    return out
