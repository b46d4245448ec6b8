"""Films of ten collapses in a channel, samples/damp-heaps: five of dry beads, five of
damp ones, made by the twin with liquid between the damp beads that none states.

    .venv/bin/python samples/damp_heaps.py FOLDER      # make it anew (some minutes)

Of the dry ones it is stated that their seeds are as usual ([pile] plain), of the rig
its sizes; not the gate's speed, nor the camera's. The key stands beside the recordings;
`samples/concealed.py reveal samples/damp-heaps` reads it."""

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import av
import numpy as np
import tomli_w
from concealed import begin, conceal

from benchtwin.twin import Parameters
from benchtwin.twin.job import Job
from benchtwin.twin.run import simulate
from benchtwin.vision.evidence.frames import open_frames
from benchtwin.vision.recording import Recording

BEADS = {"length_mm": 8.0, "width_mm": 8.0, "thickness_mm": 8.0}
DENSITY_KG_M3 = 1050.0
RIG = {
    "box_mm": [97.0, 50.0, 140.0],
    "channel_mm": [400.0, 50.0],
    "fill_height_mm": 105.0,
}
GATE_MM_S = 600.0
OWN = {
    "seed_static_friction": 0.3,
    "seed_rolling_friction": 0.02,
    "static_friction": 0.3,
    "seed_restitution": 0.5,
}
# of water, which a bead that it wets holds in each neck
BRIDGE = {"surface_tension": 0.072, "angle_deg": 0.0, "volume": 1e-9}
CAMERA = {"fps": 30.0, "mm_per_px": 0.35, "width_px": 1240, "height_px": 480}
QUALITY = "26"  # of H.264, as a phone's
HEAPS, SEED = 5, 2051


def make(folder: Path) -> None:
    """All films, bench.toml and the key."""
    told = {"provenance": "simulated", "seed": BEADS, "pile": RIG}
    begin(folder, tomli_w.dumps(told))
    for k in range(2 * HEAPS):
        number, damp = divmod(k, 2)
        with tempfile.TemporaryDirectory() as scratch:
            seen = filmed(job(k, bool(damp)), Path(scratch) / "heap")
            write(folder, f"{('dry', 'damp')[damp]}-{number + 1}", seen, not damp)
        print(f"heap {k + 1} of {2 * HEAPS}", flush=True)
    conceal(
        folder,
        {"rig": "pile", "effect": "cohesion", "parameter": pull()} | {"unit": "1"},
    )


def job(number: int, damp: bool) -> Job:
    """One heap: everything that decides it."""
    parameters = Parameters(**OWN, laws={"liquid_bridge": BRIDGE} if damp else {})
    description = {
        "seed": BEADS | {"density_kg_m3": DENSITY_KG_M3},
        "pile": RIG | {"gate_speed_mm_s": GATE_MM_S},
        "camera": CAMERA | {"target_mm": [200.0, 0.0, 60.0]},
    }
    return Job("pile", parameters, description, (SEED, number))


def pull() -> float:
    """A neck's pull on touching beads, 2 π r γ, over a bead's weight."""
    radius_m = 5e-4 * BEADS["length_mm"]
    weight = 4 / 3 * np.pi * radius_m**3 * DENSITY_KG_M3 * 9.80665
    return round(2 * np.pi * radius_m * BRIDGE["surface_tension"] / weight, 3)


def filmed(asked: Job, out: Path) -> Recording:
    """The frames of a collapse, in the folder `out`."""
    rig = replace(asked.recording(Path("heap")), evidence="video")
    rng = np.random.default_rng(list(asked.rng))
    return simulate("pile", asked.parameters, rng=rng, out=out, like=rig)


def write(folder: Path, name: str, seen: Recording, plain: bool) -> None:
    """One recording, its frames as a phone would keep them."""
    out = folder / name
    out.mkdir()
    keys = {"rig": "pile"} | ({"pile": {"plain": True}} if plain else {})
    (out / "recording.toml").write_text(tomli_w.dumps(keys), encoding="utf8")
    with av.open(str(out / "video.mp4"), "w") as film:
        rate, size = int(CAMERA["fps"]), (CAMERA["width_px"], CAMERA["height_px"])
        stream = film.add_stream("libx264", rate=rate, options={"crf": QUALITY})
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        for frame in open_frames(seen).iterate():
            shown = av.VideoFrame.from_ndarray(frame.pixels, format="rgb24")
            film.mux(stream.encode(shown.reformat(format="yuv420p")))
        film.mux(stream.encode())


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    make(Path(sys.argv[1]))
