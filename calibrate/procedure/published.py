"""What a publication prints of its own analysis beside what its tables give."""

import re
from pathlib import Path
from typing import Any

import pandas as pd
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    ValidationError,
    create_model,
    field_validator,
)

from benchtwin.bench.language import tr
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.calibration import FOLLOWS
from benchtwin.calibrate.procedure.rigs import PILE, SEED_FACTORS, STEEL
from benchtwin.calibrate.procedure.steel import SteelFit
from benchtwin.calibrate.procedure.surface import SurfaceFit
from benchtwin.calibrate.statistics.ascent import relative_error

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
            tr(
                "{}: unknown item {!r}; known are {}",
                where,
                unknown[0],
                ", ".join(recomputed),
            )
        )
    table = compare(printed, recomputed) if printed else pd.DataFrame(columns=FOLLOWS)
    return table.assign(item=[f"{where}: {item}" for item in table["item"]])


# of the last printed digit: 0.125 printed as 0.12 or as 0.13 is the same rounding
SLACK = 0.02


def follows(printed: str, recomputed: float) -> bool:
    """Whether `recomputed` rounds to what is printed.

    printed: as in print, so that its digits show: "14.40", "4.45E-003", "-10.23",
    "<0.01", ">0.05". Raises ValueError where the text is no number.

    >>> follows("0.07", 0.0656), follows("1", 7), follows("<0.01", 0.0294)
    (True, False, False)
    """
    text = printed.strip().replace("−", "-").replace(" ", "")
    bound = text[:1] if text[:1] in "<>" else ""
    match = re.fullmatch(r"([-+]?\d*\.?(\d*))(?:[eE]([-+]?\d+))?", text[len(bound) :])
    if not match or not re.search(r"\d", match[1]):
        raise ValueError(tr("printed value {!r} is not a number", printed))
    value = float(text[len(bound) :])
    unit = 10.0 ** (int(match[3] or 0) - len(match[2]))
    if bound:
        return recomputed < value if bound == "<" else recomputed > value
    return abs(recomputed - value) <= (0.5 + SLACK) * unit


def compare(printed: dict[str, str], recomputed: dict[str, float]) -> pd.DataFrame:
    """One row a printed value: item, printed, recomputed, follows. Raises ValueError
    for an item that was not recomputed."""
    unknown = [item for item in printed if item not in recomputed]
    if unknown:
        raise ValueError(
            tr("printed values that nothing was recomputed for: {}", ", ".join(unknown))
        )
    rows = [
        (item, text, float(recomputed[item]), follows(text, recomputed[item]))
        for item, text in printed.items()
    ]
    return pd.DataFrame(rows, columns=["item", "printed", "recomputed", "follows"])


def flatten(table: pd.DataFrame, key: str) -> dict[str, float]:
    """A recomputed table as {"<row> <column>": value}, the row named by column `key`:
    what `compare` takes."""
    return {
        f"{row[key]} {c}": row[c]
        for _, row in table.iterrows()
        for c in table.columns
        if c != key
    }


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid")


class _Verification(_Section):
    mean: FiniteFloat = Field(gt=0)


class _Rig(_Section):
    """bench_trimmed: highest and lowest readings left out before; printed: item →
    number."""

    bench_trimmed: int = Field(default=0, ge=0, le=1000)
    printed: dict[str, str] = Field(default_factory=dict)
    verification: _Verification | None = None


class _Pile(_Rig):
    """optimum: factor → value; anova: row → its printed columns."""

    optimum: dict[str, FiniteFloat] | None = None
    anova: dict[str, list[str]] = Field(default_factory=dict)

    @field_validator("optimum")
    @classmethod
    def _of_all(cls, optimum: dict[str, float] | None) -> dict[str, float] | None:
        if optimum is not None and set(optimum) != set(SEED_FACTORS):
            raise ValueError(
                tr("needs {}; here are {}", ", ".join(SEED_FACTORS), ", ".join(optimum))
            )
        return optimum


_RIGS: dict[str, Any] = {name: (_Rig, _Rig()) for name in STEEL}
_RIGS |= {PILE.name: (_Pile, _Pile()), "title": (str, "")}
_Published = create_model("_Published", __base__=_Section, **_RIGS)


def checked(content: dict, file: Path) -> dict:
    """The content as it is; ValueError, naming file and key, for a key that is unknown
    or holds something else."""
    try:
        _Published.model_validate(content)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise ValueError(
            f"{file}: {place}: {first['msg'][0].lower()}{first['msg'][1:]}"
        ) from error
    return content
