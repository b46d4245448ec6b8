"""The soybean paper's simulated tables, run by us: Tables 2, 4, 6 (one seed), 7 and 9
(piles), beside the printed values, and what each choice that the paper leaves open
does.

python benchmarks/paper.py [PACKINGS [table02 table04 table06 choices_one_seed table07
table09 choices_pile full_size]] Writes CSV into samples/soybean-paper/twin, which
paper_picture.py draws. Runs are kept in benchmark-runs/: a study that is stopped goes
on. Nothing is fitted to the paper: the parameters are its own, and every other choice
is a row of its own."""

import argparse
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from rig_jobs import SLAB, pile, truths

from benchtwin.twin import Parameters
from benchtwin.twin.job import Job

OUT = Path(__file__).parent.parent / "samples" / "soybean-paper" / "twin"
REPEATS = 10
FLAT = {"orientation": "flat"}
VACUUM = {"air": {"density_kg_m3": 0.0}}  # EDEM has no air; in piles it does nothing

# Printed: Table 2 (e, mm, sd), 4 (μ, °), 6 (μ_r, mm, sd), 7 (X1, X2, X3, °), 9 (coded
# A, B, C, °).
TABLE_2 = [
    (0.45, 70, 3),
    (0.49, 82, 5),
    (0.53, 91, 6),
    (0.57, 104, 5),
    (0.61, 117, 6),
    (0.65, 129, 4),
]
TABLE_4 = [(0.25, 15), (0.29, 17), (0.33, 19), (0.37, 21), (0.41, 23), (0.45, 25)]
TABLE_6 = [
    (0.01, 216, 4),
    (0.02, 125, 3),
    (0.03, 93, 5),
    (0.04, 48, 6),
    (0.05, 36, 7),
    (0.06, 27, 6),
]
TABLE_7 = [
    (0.45, 0.2, 0.01, 24),
    (0.5, 0.3, 0.02, 26.2),
    (0.55, 0.4, 0.03, 28.1),
    (0.6, 0.5, 0.04, 30),
    (0.65, 0.6, 0.05, 31.9),
    (0.7, 0.7, 0.06, 33.8),
]
TABLE_9 = [
    (0, 0, 0, 30.3),
    (0, 0, 0, 29.8),
    (-1, 1, 0, 29.8),
    (-1, 0, 1, 29.9),
    (1, 0, -1, 29.4),
    (0, 0, 0, 30.3),
    (0, 1, 1, 31.5),
    (0, -1, -1, 28.2),
    (1, 1, 0, 31.1),
    (1, -1, 0, 29.5),
    (-1, 0, -1, 28.4),
    (-1, -1, 0, 28.5),
    (0, -1, 1, 28.9),
    (0, 1, -1, 29.4),
    (1, 0, 1, 31.3),
    (0, 0, 0, 29.7),
    (0, 0, 0, 30.1),
]
CENTRE, STEP = np.array([0.60, 0.50, 0.04]), np.array([0.05, 0.10, 0.01])
OPTIMUM = (0.65, 0.55, 0.04)


def stats(jobs: list[Job], quantity: str) -> tuple[float, float, int]:
    """Mean, sd and number of runs that ended."""
    values = np.array(
        [
            t.get(quantity) if t.get(quantity) is not None else np.nan
            for t in truths(jobs)
        ],
        float,
    )
    values = values[np.isfinite(values)]
    if not len(values):
        return np.nan, np.nan, 0
    return (
        float(values.mean()),
        float(values.std(ddof=1)) if len(values) > 1 else np.nan,
        len(values),
    )


def drops(e: float, rig: dict, **settings) -> list[Job]:
    """Friction and rolling friction 0, as the paper has them for this rig."""
    smooth = {
        "restitution": e,
        "static_friction": 0.0,
        "rolling_friction": 0.0,
        **settings,
    }
    description = {"drop": {"bounces": 1, **rig}, **VACUUM}
    return [
        Job("drop", Parameters(**smooth), description, (2, k), rendered=False)
        for k in range(REPEATS)
    ]


def slides(mu: float, rig: dict | None = None) -> list[Job]:
    start = {"start_deg": 10.0, **(rig or {})}
    description, friction = (
        {"slide": start, **VACUUM},
        Parameters(static_friction=mu, rolling_friction=0.0),
    )
    return [
        Job("slide", friction, description, (4, k), rendered=False) for k in range(3)
    ]


def rolls(mu_r: float, rig: dict | None = None, **settings) -> list[Job]:
    description, friction = (
        {"roll": rig or {}, **VACUUM},
        Parameters(rolling_friction=mu_r, **settings),
    )
    return [
        Job("roll", friction, description, (6, k), rendered=False)
        for k in range(REPEATS)
    ]


def piles(
    x: tuple, packings: int, description: dict | None = None, **settings
) -> list[Job]:
    names = ("seed_restitution", "seed_static_friction", "seed_rolling_friction")
    contact = dict(zip(names, (float(f"{v:.6g}") for v in x)))
    return [pile({**contact, **settings}, k, description) for k in range(packings)]


def table_2() -> pd.DataFrame:
    """twin: rise of the centre of mass; top: the seed's upper side above the plate at
    its highest."""
    rows = [
        (
            e,
            mm,
            sd,
            310 * e * e,
            *stats(drops(e, FLAT), "rebound_height_mm"),
            *stats(drops(e, FLAT), "top_mm")[:2],
        )
        for e, mm, sd in TABLE_2
    ]
    names = [
        "restitution",
        "paper_mm",
        "paper_sd_mm",
        "e2_h1_mm",
        "twin_mm",
        "twin_sd_mm",
        "runs",
        "top_mm",
        "top_sd_mm",
    ]
    return pd.DataFrame(rows, columns=names)


def table_4() -> pd.DataFrame:
    """twin: onset of sliding; seen: the plate's angle when the block has slid 5 mm."""
    rows = [
        (
            mu,
            deg,
            np.degrees(np.arctan(mu)),
            *stats(slides(mu), "slide_angle_deg"),
            stats(slides(mu), "angle_at_5_mm_deg")[0],
        )
        for mu, deg in TABLE_4
    ]
    return pd.DataFrame(
        rows,
        columns=[
            "static_friction",
            "paper_deg",
            "atan_deg",
            "twin_deg",
            "twin_sd_deg",
            "runs",
            "seen_deg",
        ],
    )


def table_6() -> pd.DataFrame:
    beta, way = np.radians(15), 10.0
    energy = [way * (np.sin(beta) / mu - np.cos(beta)) for mu, *_ in TABLE_6]
    rows = [
        (mu, mm, sd, e, *stats(rolls(mu), "run_out_mm"))
        for (mu, mm, sd), e in zip(TABLE_6, energy)
    ]
    return pd.DataFrame(
        rows,
        columns=[
            "rolling_friction",
            "paper_mm",
            "paper_sd_mm",
            "energy_mm",
            "twin_mm",
            "twin_sd_mm",
            "runs",
        ],
    )


def table_7(packings: int) -> pd.DataFrame:
    rows = [
        (*row, *stats(piles(row[:3], packings), "repose_angle_deg")) for row in TABLE_7
    ]
    names = [
        "restitution",
        "static_friction",
        "rolling_friction",
        "paper_deg",
        "twin_deg",
        "twin_sd_deg",
        "runs",
    ]
    return pd.DataFrame(rows, columns=names)


def table_9(packings: int) -> pd.DataFrame:
    """Centre points differ in their packings; every other point has `packings` of the
    same ones (common packings)."""
    rows, centre = [], 0
    for *coded, deg in TABLE_9:
        x = CENTRE + STEP * coded
        jobs = piles(tuple(x), packings)
        if not any(coded):
            jobs = [
                pile(
                    dict(
                        zip(
                            (
                                "seed_restitution",
                                "seed_static_friction",
                                "seed_rolling_friction",
                            ),
                            map(float, x),
                        )
                    ),
                    k,
                )
                for k in range(centre * packings, (centre + 1) * packings)
            ]
            centre += 1
        rows.append((*coded, deg, *stats(jobs, "repose_angle_deg")))
    return pd.DataFrame(
        rows, columns=["A", "B", "C", "paper_deg", "twin_deg", "twin_sd_deg", "runs"]
    )


def effects(table: pd.DataFrame, column: str) -> dict[str, float]:
    """Main effects as coefficients of the coded quadratic surface: half the difference
    from −1 to +1."""
    coded = table[["A", "B", "C"]].to_numpy(float)
    a, b, c = coded.T
    model = np.column_stack(
        [np.ones(len(coded)), a, b, c, a * b, a * c, b * c, a * a, b * b, c * c]
    )
    return dict(
        zip(
            "ABC",
            np.linalg.lstsq(model, table[column].to_numpy(float), rcond=None)[0][1:4],
        )
    )


def single_seed_choices() -> pd.DataFrame:
    """What the open choices do to Tables 2, 4 and 6: mean of (twin − paper)/paper over
    the rows, at the ends too."""
    made = []

    def add(table: int, choice: str, ours, paper) -> None:
        off = [100 * (o / p - 1) for o, p in zip(ours, paper)]
        made.append(
            (
                table,
                choice,
                *[round(v, 1) for v in ours],
                round(float(np.mean(np.abs(off))), 1),
            )
        )

    paper = [mm for _, mm, _ in TABLE_2]

    def rebound(rig, quantity="rebound_height_mm", **settings):
        return [stats(drops(e, rig, **settings), quantity)[0] for e, *_ in TABLE_2]

    add(2, "as printed", paper, paper)
    add(2, "flat, tipped by 6° (sd)", rebound(FLAT), paper)
    add(
        2,
        "flat, not tipped",
        rebound({"orientation": "flat", "tip_sd_deg": 0.0}),
        paper,
    )
    add(
        2,
        "flat, tipped by 15° (sd)",
        rebound({"orientation": "flat", "tip_sd_deg": 15.0}),
        paper,
    )
    add(2, "any orientation", rebound({"orientation": "any"}), paper)
    add(
        2,
        "flat 6°; read at the seed's top, above the plate",
        rebound(FLAT, "top_mm"),
        paper,
    )
    add(
        2,
        "not tipped; read at the seed's top",
        rebound({"orientation": "flat", "tip_sd_deg": 0.0}, "top_mm"),
        paper,
    )
    add(
        2,
        "flat 6°; contact force clipped at zero",
        rebound(FLAT, pull_at_end=False),
        paper,
    )
    add(
        2,
        "flat 15°; contact force clipped at zero",
        rebound({"orientation": "flat", "tip_sd_deg": 15.0}, pull_at_end=False),
        paper,
    )
    add(
        2,
        "flat 6°; damping of each ball (EDEM)",
        rebound(FLAT, share_damping=False),
        paper,
    )
    add(
        2,
        "any orientation; clipped",
        rebound({"orientation": "any"}, pull_at_end=False),
        paper,
    )
    paper = [deg for _, deg in TABLE_4]
    add(4, "as printed", paper, paper)
    for rate in (2.0, 5.0):
        for quantity, said in (
            ("slide_angle_deg", "onset of sliding"),
            ("angle_at_5_mm_deg", "when it has slid 5 mm"),
        ):
            angles = [
                stats(slides(mu, {"tilt_rate_deg_s": rate}), quantity)[0]
                for mu, _ in TABLE_4
            ]
            add(4, f"{said}, {rate:g}°/s", angles, paper)
    paper = [mm for _, mm, _ in TABLE_6]
    add(6, "as printed", paper, paper)
    add(
        6,
        "energy balance, Eq. (3)",
        [
            10 * (np.sin(np.radians(15)) / mu - np.cos(np.radians(15)))
            for mu, *_ in TABLE_6
        ],
        paper,
    )
    for name, rig, settings in (
        ("axis across ± 3°", {}, {}),
        ("axis across, exactly", {"axis_sd_deg": 0.0}, {}),
        ("any orientation", {"orientation": "any"}, {}),
        ("axis ± 3°, single sphere", {}, {"spheres": 1}),
        ("axis ± 3°, type C rolling", {}, {"rolling_convention": "type_c"}),
    ):
        add(
            6,
            name,
            [stats(rolls(mu, rig, **settings), "run_out_mm")[0] for mu, *_ in TABLE_6],
            paper,
        )
    return pd.DataFrame(
        made,
        columns=[
            "table",
            "choice",
            *[f"row_{k}" for k in range(1, 7)],
            "mean_abs_off_percent",
        ],
    )


TWICE = {
    "seed_rolling_friction": 0.08
}  # as torque between equal balls: their R* is half their radius
PILE_CHOICES: list[
    tuple[str, dict, dict]
] = [  # the likelier to matter first: a study that is stopped has these
    ("reduced pile as in Tables 7 and 9", {}, {}),
    (
        "sides of steel, 30 mm apart",
        {"slab": False, "gate_mm": [30, 200], "plate_mm": [200, 200]},
        {},
    ),
    (
        "rolling friction: type A, same torque between equal balls (2 μ_r)",
        {},
        {"rolling_convention": "type_a", **TWICE},
    ),
    (
        "rolling friction: type C, same torque between equal balls (2 μ_r)",
        {},
        {"rolling_convention": "type_c", **TWICE},
    ),
    (
        "floor and back like seeds",
        {},
        {"restitution": 0.65, "static_friction": 0.55, "rolling_friction": 0.04},
    ),
    ("layout: one sphere", {}, {"spheres": 1}),
    (
        "layout: eight balls, width and thickness apart",
        {},
        {"spheres": 8, "arrangement": "planar"},
    ),
    ("gate 200 mm/s", {"gate_speed_mm_s": 200}, {}),
    ("read 0.1 s after the gate is out", {"photo_s": 1.5}, {}),
    ("read 5 s after the gate began", {"photo_s": 5.0}, {}),
    ("rolling friction: type A, same number", {}, {"rolling_convention": "type_a"}),
    ("filled to 40 mm", {"fill_height_mm": 40}, {}),
    ("plate 400 mm long: no edge", {"plate_mm": [400, 30]}, {}),
    ("gate 20 mm/s", {"gate_speed_mm_s": 20}, {}),
    ("damping of each ball (EDEM)", {}, {"share_damping": False}),
    ("filled to 100 mm", {"fill_height_mm": 100}, {}),
]


def pile_choices(packings: int) -> pd.DataFrame:
    """What each open choice does to the angle at the paper's optimum, one at a time."""
    rows, base = [], None
    for name, rig, settings in PILE_CHOICES:
        x = (
            dict(
                zip(
                    (
                        "seed_restitution",
                        "seed_static_friction",
                        "seed_rolling_friction",
                    ),
                    OPTIMUM,
                )
            )
            | settings
        )
        count = (
            min(packings, 2) if rig.get("fill_height_mm", 0) >= 100 else packings
        )  # such a run takes six times as long
        mean, sd, n = stats([pile(x, k, rig) for k in range(count)], "repose_angle_deg")
        base = (mean, sd, n) if base is None else base
        error = (
            np.hypot(sd / np.sqrt(n), base[1] / np.sqrt(base[2])) if n > 1 else np.nan
        )
        rows.append((name, mean, sd, n, mean - base[0], error))
        table = pd.DataFrame(
            rows,
            columns=[
                "choice",
                "angle_deg",
                "sd_deg",
                "packings",
                "change_deg",
                "change_se_deg",
            ],
        )
        table.to_csv(
            OUT / "choices_pile.csv", index=False, float_format="%.5g"
        )  # as far as it has come
    return table


def full_size(packings: int) -> pd.DataFrame:
    """The paper's own box at the optimum: ten minutes of processor time a run."""
    full = {
        "box_mm": [105, 105, 200],
        "gate_mm": [100, 200],
        "plate_mm": [200, 200],
        "fill_height_mm": 100,
        "slab": False,
    }
    rows = [(*OPTIMUM, *stats(piles(OPTIMUM, packings, full), "repose_angle_deg"))]
    return pd.DataFrame(
        rows,
        columns=[
            "restitution",
            "static_friction",
            "rolling_friction",
            "twin_deg",
            "twin_sd_deg",
            "runs",
        ],
    )


def main(packings: int, wanted: list[str]) -> None:
    OUT.mkdir(exist_ok=True)
    makers = {
        "table02": table_2,
        "table04": table_4,
        "table06": table_6,
        "choices_one_seed": single_seed_choices,
        "table07": lambda: table_7(packings),
        "table09": lambda: table_9(packings),
        "choices_pile": lambda: pile_choices(packings),
        "full_size": lambda: full_size(min(packings, 2)),
    }
    if unknown := set(wanted) - set(makers):
        sys.exit(
            f"no such table: {', '.join(sorted(unknown))}; there are"
            f" {', '.join(makers)}"
        )
    for name, make in makers.items():
        if not wanted or name in wanted:
            table = make()
            table.to_csv(OUT / f"{name}.csv", index=False, float_format="%.5g")
            print(f"\n== {name}\n{table.round(2).to_string(index=False)}", flush=True)
            if name == "table09":
                print(
                    {
                        k: {n: round(v, 3) for n, v in effects(table, k).items()}
                        for k in ("paper_deg", "twin_deg")
                    }
                )
    print(f"\nreduced pile: {SLAB}; tables in {OUT}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("packings", type=int, nargs="?", default=3)
    parser.add_argument("tables", nargs="*")
    arguments = parser.parse_args()
    main(arguments.packings, arguments.tables)
