"""Release heights that are stated too low or too high, all by as much."""

from benchtwin.infer.effect import Effect, Key
from benchtwin.rigs.drop.effects.hooks import fallen_deeper, lower

RELEASE_HEIGHT = "release-height"
EFFECTS = (
    Effect(
        name=RELEASE_HEIGHT,
        sector="measurement",
        unit="mm",
        meaning="true - stated release height",
        prior_sd=20.0,
        low=-200.0,
        high=200.0,
        source=(
            "a ruler that stands on the table beside the plate, or heights of another"
            " point of the seed or of the hand; e as read from impact times is too high"
            " by half of the height's relative error, at the first impact only"
        ),
        wording=("the stated release height is off", "mm = true − stated"),
        key=Key("drop", "height_mm"),
        release=lower,
        restitution=fallen_deeper,
        needs=lambda seen: seen.of_stated_height,
        separating=(
            "drops from twice the height: an error of the height matters half as much"
        ),
        not_simulated="a stated height acts on no contact of the twin",
    ),
)
