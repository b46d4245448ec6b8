"""What a publication prints of its own analysis beside what its tables give."""

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.calibration import FOLLOWS
from benchtwin.calibrate.procedure.pile import PileFit
from benchtwin.calibrate.procedure.rigs import PILE_RESPONSE, direct
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.calibrate.statistics.ascent import check_published, relative_error
from benchtwin.calibrate.statistics.assessment import natural_coefficients
from benchtwin.calibrate.statistics.optimum import stand
from benchtwin.calibrate.statistics.published_values import compare, flatten

ANOVA_COLUMNS = ("sum_of_squares", "df", "mean_square", "f", "p")
POWERS = ("1", "x", "x²", "x³")
DIRECT = {
    "drop": "Eq. 1, {} restitution at the bench",
    "slide": "Eq. 2, {} static friction at the bench",
    "roll": "Eq. 3, {} rolling friction at the bench",
}


def check_steel(fit: SteelFit, readings: RigReadings, printed: dict) -> pd.DataFrame:
    """Printed values of a rig beside the recomputed ones: columns of `printed.compare`,
    items named "drop: …"."""
    equation = fit.rig.equation
    recomputed = {
        "bench mean": fit.bench.value,
        "parameter": fit.inverse.value,
        f"{equation}, R²": fit.polynomial.r2,
    }
    powers = POWERS[: fit.polynomial.coefficients.size][::-1]
    recomputed |= {
        f"{equation}, {power}": value
        for power, value in zip(powers, fit.polynomial.coefficients)
    }
    ends = [
        direct(fit.rig.name, v, readings.description)
        for v in (readings.values.min(), readings.values.max())
    ]
    stated = sorted(e for e in ends if e is not None)
    recomputed |= {
        DIRECT[fit.rig.name].format(which): v
        for which, v in zip(("least", "greatest"), stated)
    }
    recomputed |= _verification(fit, printed)
    return _compared(printed.get("printed", {}), recomputed, fit.rig.name)


def check_pile(
    fit: PileFit, printed: dict, levels: pd.DataFrame
) -> tuple[pd.DataFrame, list[str]]:
    """Printed values of the pile beside the recomputed ones, and what the text
    contradicts, as sentences."""
    terms = dict(zip(fit.coefficients["term"], fit.coefficients["coefficient"]))
    recomputed = {
        f"Eq. 8, {'1' if t == 'intercept' else t}": v for t, v in terms.items()
    }
    recomputed |= {
        f"contribution of {r.factor} (Eqs. 9, 10)": r.by_formula
        for r in fit.contributions.itertuples()
    }
    p = fit.anova.set_index("source")["p"]
    recomputed |= {f"{source} p, in the text": value for source, value in p.items()}
    if "optimum" in printed:
        recomputed["angle at the optimum"] = stand(
            fit.surface, printed["optimum"], fit.bench.value
        ).predicted
        recomputed |= {f"optimum, {n}": fit.optimum.point[n] for n in fit.box.names}
    recomputed |= _verification(fit, printed)
    tables = [_compared(printed.get("printed", {}), recomputed, "pile")]
    if "anova" in printed:
        rows = {
            f"{s} {c}": text
            for s, texts in printed["anova"].items()
            for c, text in zip(ANOVA_COLUMNS, texts)
        }
        tables.append(_compared(rows, flatten(fit.anova, "source"), "pile: Table 10"))
    if "optimum" in printed:
        point = {f"optimum, {n}": f"{v:.2f}" for n, v in printed["optimum"].items()}
        tables.append(_compared(point, recomputed, "pile"))
    if fit.path is not None and "relative_error_percent" in fit.path.errors:
        errors = fit.path.errors
        rows = {
            f"group {g} r (%)": f"{v:.2f}"
            for g, v in zip(errors["group"], errors["relative_error_percent"])
        }
        again = {
            f"group {g} r (%)": 100 * v
            for g, v in zip(errors["group"], errors["relative_error"])
        }
        tables.append(_compared(rows, again, "pile: Table 7"))
    return pd.concat(tables, ignore_index=True), _contradictions(fit, printed, levels)


def _verification(fit: SteelFit | PileFit, printed: dict) -> dict[str, float]:
    """Relative error of the fit's own verification, else of the printed one."""
    item = "relative error of the verification (%)"
    if fit.verification is not None:
        return {item: 100 * fit.verification.relative_error}
    if "verification" not in printed:
        return {}
    return {
        item: (
            100
            * float(relative_error(printed["verification"]["mean"], fit.bench.value))
        )
    }


def _contradictions(fit: PileFit, printed: dict, levels: pd.DataFrame) -> list[str]:
    flags = []
    if fit.path is not None and "said_centre" in printed:
        columns = ["coded", *fit.box.names]
        flags += check_published(
            fit.path.errors,
            PILE_RESPONSE,
            fit.bench.value,
            levels[columns],
            said_centre=printed["said_centre"],
        )
    if "optimum" in printed:
        at = stand(fit.surface, printed["optimum"], fit.bench.value)
        if at.boundary:
            edges = ", ".join(
                f"{n} = {at.point[n]:g} is its {side} limit"
                for n, side in at.boundary.items()
            )
            flags.append(
                "the published optimum stands at the boundary of its own range:"
                f" {edges}"
            )
    k = fit.contributions
    if "printed" in printed and not np.allclose(
        k["by_formula"], k["as_paper"], atol=5e-4
    ):
        text = ", ".join(f"{r.factor} {r.as_paper:.3f}" for r in k.itertuples())
        flags.append(
            f"the printed contributions are δ_i + Σδ_ij ({text}), without the ½ and the"
            " square term of Eq. 10"
        )
    return flags


def _compared(
    printed: dict[str, str], recomputed: dict[str, float], where: str
) -> pd.DataFrame:
    """`compare` with items named by where they stand; ValueError for a printed item
    that nothing is recomputed for."""
    unknown = [item for item in printed if item not in recomputed]
    if unknown:
        raise ValueError(
            f"{where}: unknown item {unknown[0]!r}; known are {', '.join(recomputed)}"
        )
    table = compare(printed, recomputed) if printed else pd.DataFrame(columns=FOLLOWS)
    return table.assign(item=[f"{where}: {item}" for item in table["item"]])


def natural_equation(fit: PileFit) -> pd.Series:
    """The surface in natural units, indexed by term."""
    return natural_coefficients(fit.surface)
