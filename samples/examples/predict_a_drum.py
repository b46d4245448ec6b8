"""Predict another system: the flowing angle in a drum, with parameters from a pile.

The calibration's posterior is drawn from, and each draw turns a small drum. What the
parameters leave open and what packings scatter are told apart."""

import tempfile
from pathlib import Path

from benchtwin import calibrate, predict

place = Path(tempfile.mkdtemp())
answer = calibrate("samples/soybean-paper", tables=True, out=place / "calibrated")
drum = {
    "drum.drum_mm": [60.0, 12.0],
    "drum.fill_share": 0.4,
    "drum.speed_rpm": 30.0,
    "drum.wait_s": 0.3,
    "drum.film_s": 0.3,
    "shear_modulus_pa": 5e5,
}
expected = predict(
    answer, "drum", out=place / "drum", settings=drum, draws=4, packings=3, workers=1
)
row = expected.quantities.iloc[0]
print(f"flowing angle {row['mean']:.1f}° ({row['low']:.1f} to {row['high']:.1f}°)")

picture = expected.plot()
