"""What keys of recording.toml are made of: a section, and kinds of numbers with their
ranges."""

import math
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

from benchtwin.bench.language import tr

# Ranges catch the wrong unit (a 310 m drop), not the unusual bench.
SIZE_LIMITS_MM = 0.05, 2000.0  # a grain of sand: 0.5, a basketball: 240
PLAUSIBLE_MM = 0.2, 60.0  # of a seed: poppy to coconut
SeedSize = Annotated[
    float,
    Field(gt=SIZE_LIMITS_MM[0], le=SIZE_LIMITS_MM[1], allow_inf_nan=False),
]
Length = Annotated[float, Field(gt=0, lt=100_000, allow_inf_nan=False)]
Angle = Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Pixels = Annotated[int, Field(ge=8, le=16384)]
SIMULATED = Field(json_schema_extra={"simulated": True})  # measuring needs no such key
FROM_LIST = Field(strict=False)  # TOML has lists only: one is taken for a tuple
SizeRange = Annotated[tuple[SeedSize, SeedSize], FROM_LIST]
TwoLengths = Annotated[tuple[Length, Length], FROM_LIST]
ThreeLengths = Annotated[tuple[Length, Length, Length], FROM_LIST]
Vector = Annotated[tuple[Finite, Finite, Finite], FROM_LIST]
Pixel = Annotated[int, Field(ge=0, le=65_536)]
Frame = Annotated[int, Field(ge=0)]
Extent = Annotated[int, Field(ge=8, le=65_536)]
COVERAGE_LIMITS = 0.3, 0.9  # of a plate by one layer: equal circles cover 0.907 at most
Coverage = Annotated[float, Field(ge=COVERAGE_LIMITS[0], le=COVERAGE_LIMITS[1])]


def _of_its_own_lot(plate: object) -> object:
    """ "seeds"; an error that says why for what else a plate may be of."""
    if plate == "seeds":
        return plate
    raise PydanticCustomError(
        "plate",
        tr(
            'must be "seeds", glued down and of the lot that falls or slides on'
            " them: seeds of another kind do not tell seed on seed; a smooth plate has"
            " no such key"
        ),
    )


SeedPlate = Annotated[Literal["seeds"], BeforeValidator(_of_its_own_lot)]
Share = Annotated[float, Field(ge=0, le=100)]
PlaceOfFrame = Annotated[tuple[Frame, Finite, Finite], FROM_LIST]
FourNumbers = Annotated[tuple[Finite, Finite, Finite, Finite], FROM_LIST]


class Section(BaseModel):
    """A table of keys; the text under each says what it means and what it is for."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, use_attribute_docstrings=True
    )

    @property
    def used_sds(self) -> dict[str, float]:
        """Standard deviations as they are used, by key; others are used as stated."""
        return {}

    def sds_beyond_belief(self) -> list[str]:
        """Standard deviations that nobody can know or mean, and what is used."""
        out = []
        for key, used in self.used_sds.items():
            stated = getattr(self, key)
            if stated is None or math.isclose(stated, used, rel_tol=1e-6):
                continue
            how = tr("well") if stated < used else tr("badly")
            out.append(
                tr(
                    "{} = {:g}: nobody knows it as {} as that; {:.2g} is used",
                    key,
                    stated,
                    how,
                    used,
                )
            )
        return out
