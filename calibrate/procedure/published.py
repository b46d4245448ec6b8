"""What a publication prints of its own analysis beside what its tables give."""

import pandas as pd

from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.calibration import FOLLOWS
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.calibrate.procedure.surface import SurfaceFit
from benchtwin.calibrate.statistics.ascent import relative_error
from benchtwin.calibrate.statistics.published_values import compare, flatten

ANOVA_COLUMNS = ("sum_of_squares", "df", "mean_square", "f", "p")
POWERS = ("1", "x", "x²", "x³")
VERIFICATION = "relative error of the verification (%)"


def check_steel(fit: SteelFit, readings: RigReadings, printed: dict) -> pd.DataFrame:
    """Printed values of a rig beside the recomputed ones: columns of `printed.compare`,
    items named "drop: …"."""
    rig, curve = fit.rig, fit.equation
    powers = POWERS[: curve.coefficients.size][::-1]
    ends = (readings.values.min(), readings.values.max())
    direct = [rig.direct(v, readings.description) for v in ends]
    stated = sorted(e for e in direct if e is not None)
    what = f"{rig.parameter.replace('_', ' ')} at the bench"
    recomputed = {
        "bench mean": fit.bench.value,
        "parameter": curve.at(fit.bench.value),
        f"{rig.equation}, R²": curve.r2,
        **{f"{rig.equation}, {x}": v for x, v in zip(powers, curve.coefficients)},
        **{
            f"{rig.formula_name}, {which} {what}": v
            for which, v in zip(("least", "greatest"), stated)
        },
        **_verification(fit, printed),
    }
    return _compared(printed.get("printed", {}), recomputed, rig.name)


def check_pile(fit: SurfaceFit, printed: dict) -> pd.DataFrame:
    """Printed values of the pile beside the recomputed ones."""
    optimum, where = printed.get("optimum"), PILE.name
    terms = zip(fit.coefficients["term"], fit.coefficients["coefficient"])
    recomputed = {f"Eq. 8, {'1' if t == 'intercept' else t}": v for t, v in terms}
    for r in fit.contributions.itertuples():
        recomputed[f"contribution of {r.factor} (Eqs. 9, 10)"] = r.by_formula
    for source, p in fit.anova.set_index("source")["p"].items():
        recomputed[f"{source} p, in the text"] = p
    if optimum is not None:
        at = fit.box.coded([optimum[name] for name in fit.box.names])
        recomputed["angle at the optimum"] = float(fit.surface.mean(at)[0])
        recomputed |= {f"optimum, {n}": fit.optimum.point[n] for n in fit.box.names}
    recomputed |= _verification(fit, printed)
    tables = [_compared(printed.get("printed", {}), recomputed, where)]
    if "anova" in printed:
        rows = {
            f"{s} {c}": text
            for s, texts in printed["anova"].items()
            for c, text in zip(ANOVA_COLUMNS, texts)
        }
        again = flatten(fit.anova, "source")
        tables.append(_compared(rows, again, f"{where}: Table 10"))
    if optimum is not None:
        point = {f"optimum, {n}": f"{v:.2f}" for n, v in optimum.items()}
        tables.append(_compared(point, recomputed, where))
    if fit.path is not None and "relative_error_percent" in fit.path.errors:
        errors = fit.path.errors
        items = [f"group {g} r (%)" for g in errors["group"]]
        rows = dict(zip(items, (f"{v:.2f}" for v in errors["relative_error_percent"])))
        again = dict(zip(items, 100 * errors["relative_error"]))
        tables.append(_compared(rows, again, f"{where}: Table 7"))
    return pd.concat(tables, ignore_index=True)


def _verification(fit: SteelFit | SurfaceFit, printed: dict) -> dict[str, float]:
    """Relative error of the printed verification."""
    if "verification" not in printed:
        return {}
    error = relative_error(printed["verification"]["mean"], fit.bench.value)
    return {VERIFICATION: 100 * float(error)}


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
