"""What published.toml may hold, and errors that name the file and the key."""

from pathlib import Path
from typing import Any

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    ValidationError,
    create_model,
    field_validator,
)

from benchtwin.calibrate.procedure.rigs import PILE, SEED_FACTORS, STEEL


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
                f"needs {', '.join(SEED_FACTORS)}; here are {', '.join(optimum)}"
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
