"""What a publication prints of its own analysis beside what its tables give."""

import numpy as np
import pandas as pd

from calibrate.procedure.bench import RigReadings
from calibrate.procedure.calibration import FOLLOWS
from calibrate.procedure.pile import PileFit
from calibrate.procedure.rigs import PILE_RESPONSE, direct
from calibrate.procedure.steel import SteelFit
from calibrate.statistics.ascent import check_published, relative_error
from calibrate.statistics.assessment import natural_coefficients
from calibrate.statistics.optimum import stand
from calibrate.statistics.published_values import compare, flatten

ANOVA_COLUMNS = ("sum_of_squares", "df", "mean_square", "f", "p")
POWERS = ("1", "x", "x²", "x³")
DIRECT = {"drop": "Eq. 1, {} restitution at the bench", "slide": "Eq. 2, {} static friction at the bench",
          "roll": "Eq. 3, {} rolling friction at the bench"}  # fmt: skip


def check_steel(fit: SteelFit, readings: RigReadings, told: dict) -> pd.DataFrame:
    """Printed values of a rig beside the recomputed ones: columns of `printed.compare`, items named "drop: …"."""
    equation = fit.rig.equation
    known = {"bench mean": fit.bench.value, "parameter": fit.inverse.value, f"{equation}, R²": fit.polynomial.r2}
    powers = POWERS[: fit.polynomial.coefficients.size][::-1]
    known |= {f"{equation}, {power}": value for power, value in zip(powers, fit.polynomial.coefficients)}
    ends = [direct(fit.rig.name, v, readings.description) for v in (readings.values.min(), readings.values.max())]
    stated = sorted(e for e in ends if e is not None)
    known |= {DIRECT[fit.rig.name].format(which): v for which, v in zip(("least", "greatest"), stated)}
    known |= _verification(fit, told)
    return _compared(told.get("printed", {}), known, fit.rig.name)


def check_pile(fit: PileFit, told: dict, levels: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """Printed values of the pile beside the recomputed ones, and what the text contradicts, as sentences."""
    terms = dict(zip(fit.coefficients["term"], fit.coefficients["coefficient"]))
    known = {f"Eq. 8, {'1' if t == 'intercept' else t}": v for t, v in terms.items()}
    known |= {f"contribution of {r.factor} (Eqs. 9, 10)": r.by_formula for r in fit.contributions.itertuples()}
    p = fit.anova.set_index("source")["p"]
    known |= {f"{source} p, in the text": value for source, value in p.items()}
    if "optimum" in told:
        known["angle at the optimum"] = stand(fit.surface, told["optimum"], fit.bench.value).predicted
        known |= {f"optimum, {n}": fit.optimum.point[n] for n in fit.box.names}
    known |= _verification(fit, told)
    tables = [_compared(told.get("printed", {}), known, "pile")]
    if "anova" in told:
        rows = {f"{s} {c}": text for s, texts in told["anova"].items() for c, text in zip(ANOVA_COLUMNS, texts)}
        tables.append(_compared(rows, flatten(fit.anova, "source"), "pile: Table 10"))
    if "optimum" in told:
        point = {f"optimum, {n}": f"{v:.2f}" for n, v in told["optimum"].items()}
        tables.append(_compared(point, known, "pile"))
    if fit.path is not None and "relative_error_percent" in fit.path.errors:
        errors = fit.path.errors
        rows = {f"group {g} r (%)": f"{v:.2f}" for g, v in zip(errors["group"], errors["relative_error_percent"])}
        again = {f"group {g} r (%)": 100 * v for g, v in zip(errors["group"], errors["relative_error"])}
        tables.append(_compared(rows, again, "pile: Table 7"))
    return pd.concat(tables, ignore_index=True), _contradictions(fit, told, levels)


def _verification(fit: SteelFit | PileFit, told: dict) -> dict[str, float]:
    """Relative error of the fit's own verification, else of the printed one."""
    item = "relative error of the verification (%)"
    if fit.verification is not None:
        return {item: 100 * fit.verification.relative_error}
    if "verification" not in told:
        return {}
    return {item: 100 * float(relative_error(told["verification"]["mean"], fit.bench.value))}


def _contradictions(fit: PileFit, told: dict, levels: pd.DataFrame) -> list[str]:
    flags = []
    if fit.path is not None and "said_centre" in told:
        columns = ["coded", *fit.box.names]
        flags += check_published(
            fit.path.errors, PILE_RESPONSE, fit.bench.value, levels[columns], said_centre=told["said_centre"]
        )
    if "optimum" in told:
        at = stand(fit.surface, told["optimum"], fit.bench.value)
        if at.boundary:
            edges = ", ".join(f"{n} = {at.point[n]:g} is its {side} limit" for n, side in at.boundary.items())
            flags.append(f"the published optimum stands at the boundary of its own range: {edges}")
    k = fit.contributions
    if "printed" in told and not np.allclose(k["by_formula"], k["as_paper"], atol=5e-4):
        said = ", ".join(f"{r.factor} {r.as_paper:.3f}" for r in k.itertuples())
        flags.append(f"the printed contributions are δ_i + Σδ_ij ({said}), without the ½ and the square term of Eq. 10")
    return flags


def _compared(printed: dict[str, str], known: dict[str, float], where: str) -> pd.DataFrame:
    """`compare` with items named by where they stand; ValueError for a printed item that nothing is recomputed for."""
    unknown = [item for item in printed if item not in known]
    if unknown:
        raise ValueError(f"{where}: unknown item {unknown[0]!r}; known are {', '.join(known)}")
    table = compare(printed, known) if printed else pd.DataFrame(columns=FOLLOWS)
    return table.assign(item=[f"{where}: {item}" for item in table["item"]])


def natural_equation(fit: PileFit) -> pd.Series:
    """The surface in natural units, indexed by term."""
    return natural_coefficients(fit.surface)
