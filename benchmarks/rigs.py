"""Where the time of a simulated recording goes, rig by rig: filling, lifting, settling, rendering, measuring.

python benchmarks/rigs.py [full]     `full` adds the full-size pile (minutes)
"""

import argparse
import shutil
import tempfile
import time
from pathlib import Path

from twin import Parameters, observe
from twin.job import Job

REDUCED = {"box_mm": [105, 30, 200], "gate_mm": [30, 200], "plate_mm": [200, 30], "fill_height_mm": 60, "slab": True}
CASES = {
    "drop, 3 bounces, 1000 fps": (Job("drop", Parameters()), 15.0),
    "drop, track alone": (Job("drop", Parameters(), rendered=False), 1.0),
    "roll, 200 fps": (Job("roll", Parameters()), None),
    "slide from 14°, 50 fps": (Job("slide", Parameters(), {"slide": {"start_deg": 14.0}}), None),
    "pile, reduced": (Job("pile", Parameters(), {"pile": REDUCED}), 45.0),
    "pile, full size": (Job("pile", Parameters()), 480.0),
}


class Stages:
    """A watch that adds up the time between its calls, stage by stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.last, self.stage = time.perf_counter(), "starting"

    def __call__(self, stage: str, share: float = 0.0) -> None:
        now = time.perf_counter()
        self.seconds[self.stage] = self.seconds.get(self.stage, 0.0) + now - self.last
        self.last, self.stage = now, stage


def main(full: bool) -> None:
    Job("drop", Parameters(), rendered=False).run(Path(tempfile.mkdtemp()) / "warm")  # compile, load
    Job("pile", Parameters(), {"pile": {**REDUCED, "fill_height_mm": 20, "photo_s": 0.01}}, rendered=False).run(
        Path(tempfile.mkdtemp()) / "warm"
    )
    print(f"{'recording':26} {'s':>7} {'target':>7}   stages [s]")
    for name, (job, target) in CASES.items():
        if "full" in name and not full:
            continue
        folder, stages, begin = Path(tempfile.mkdtemp()), Stages(), time.perf_counter()
        recording = job.run(folder / "run", watch=stages)
        stages("measuring")
        main_quantity = observe(recording).quantities[0]
        stages("end")
        told = ", ".join(f"{stage} {seconds:.1f}" for stage, seconds in stages.seconds.items())
        found = f"{main_quantity.name} {main_quantity.value:.4g} {main_quantity.unit}"
        print(f"{name:26} {time.perf_counter() - begin:7.1f} {target or '–':>7}   {told}; {found}", flush=True)
        shutil.rmtree(folder)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("full", nargs="?", choices=["full"])
    main(parser.parse_args().full is not None)
