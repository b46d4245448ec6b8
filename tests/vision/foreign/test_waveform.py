"""Sound as numbers in a text: the impacts are those of the drawn clicks, whatever
states the rate."""

import numpy as np
import pytest
from measure_all import measure

from benchtwin.vision.foreign import read_foreign, tool_of
from benchtwin.vision.measurement import MeasurementError

G, RATE, E = 9.80665, 8000, 0.8


def clicks() -> np.ndarray:
    """Six impacts from 150 mm, e 0.8, rung at 3 kHz, in a noise of 0.2 %."""
    speed, at, rng = np.sqrt(2 * G * 0.15), 0.3, np.random.default_rng(1)
    time = np.arange(round(1.6 * RATE)) / RATE
    heard = rng.normal(0, 0.002, len(time))
    for k in range(6):
        since = time - at
        ring = np.exp(-since / 0.004) * np.sin(2 * np.pi * 3000 * since)
        heard += np.where(since >= 0, 0.7 * E**k * ring, 0.0)
        at += 2 * E ** (k + 1) * speed / G
    return heard


HEARD = clicks()
BARE = "\n".join(f"{v:.5f}" for v in HEARD)
TIMED = "\n".join(f"{k / RATE:.6E},{v:.5E}" for k, v in enumerate(HEARD))
FORMS = {
    "two columns": f"Second,Volt\n{TIMED}",
    "lines above": f"Model,XY 12\nVertical Units,V\n\nTIME,CH1\n{TIMED}",
    "rate above": f"Sample Rate: {RATE} Hz. Sample values on linear scale.\n{BARE}",
    "in kilohertz": f"# sampled at {RATE / 1000} kHz\n{BARE}",
    "interval above": f"Sample interval 125 µs\n{BARE}",
    "decimal commas": "Zeit (ms);Signal\n"
    + "\n".join(
        f"{1000 * k / RATE:.4f};{v:.5f}".replace(".", ",") for k, v in enumerate(HEARD)
    ),
}


@pytest.mark.parametrize("form", FORMS)
def test_a_waveform_is_heard(tmp_path, form):
    (tmp_path / "clap.txt").write_text(FORMS[form], encoding="utf8")
    (observation,) = measure(tmp_path / "clap.txt")
    known = {q.name: q for q in observation.quantities}
    assert observation.rig == "drop"
    assert abs(known["restitution_normal"].value - E) < 2 * 0.003
    found = read_foreign(tmp_path / "clap.txt").waveform
    assert len(found.samples) == len(HEARD)
    assert found.rate_hz == pytest.approx(RATE, rel=1e-4)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (BARE, r"12,800 samples of a sound without their rate; at 44,100 .* 0\.29 s"),
        (f"rate 1000 Hz\n{BARE}", "1000 samples a second; sound should have 8,000"),
    ],
)
def test_a_rate_that_is_missing_or_too_low_is_one_sentence(tmp_path, content, said):
    (tmp_path / "clap.txt").write_text(content)
    with pytest.raises(MeasurementError, match=rf"clap\.txt: {said}"):
        read_foreign(tmp_path / "clap.txt")


@pytest.mark.parametrize(
    "content",
    [
        "\n".join(str(k) for k in range(2000)),
        "t_s,y_mm\n" + "\n".join(f"{k / 8000},{k % 7}" for k in range(2000)),
        "speed,force\n" + "\n".join(f"{k / 100},{k % 7}" for k in range(2000)),
    ],
)
def test_other_numbers_are_no_waveform(tmp_path, content):
    """A counter, heights at 8000 frames a second, a force over something slow."""
    (tmp_path / "table.txt").write_text(content)
    assert tool_of(tmp_path / "table.txt") != "waveform"
