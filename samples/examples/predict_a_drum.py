"""Predict another system: the flowing angle in a drum, with parameters from a pile.

The calibration's posterior is drawn from, and each draw turns a small drum. What the
parameters leave open and what packings scatter are told apart. The drums are turned by
processes of their own, which import this script: hence the guard."""

import tempfile
from pathlib import Path

import numpy as np

from benchtwin import calibrate, predict

DRUM = {
    "drum.drum_mm": [60.0, 12.0],
    "drum.fill_share": 0.4,
    "drum.speed_rpm": 30.0,
    "drum.wait_s": 0.5,
    "drum.film_s": 0.5,
    "shear_modulus_pa": 5e5,
}

if __name__ == "__main__":
    place = Path(tempfile.mkdtemp())
    answer = calibrate("samples/soybean-paper", tables=True, out=place / "calibrated")
    drum = {"settings": DRUM, "draws": 8, "packings": 4, "workers": 1}
    expected = predict(answer, "drum", out=place / "drum", **drum)
    row = expected.quantities.iloc[0]
    print(f"flowing angle {row['mean']:.1f}° ({row['low']:.1f} to {row['high']:.1f}°)")

    runs = expected.runs
    drawn = runs[runs["kind"] == "posterior draw"]["flowing_angle_deg"]
    normal_half = 1.96 * np.std(drawn, ddof=1) * np.sqrt(1 + 1 / len(drawn))

    picture = expected.plot()
