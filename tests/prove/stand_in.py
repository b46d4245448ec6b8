"""Stand-in solvers: `python stand_in.py MODE BENCH OUT` writes the same diagnosis
whatever the bench, or breaks down."""

import json
import sys
from pathlib import Path

MODES = {
    "none": ("none", []),  # never says anything
    "loud": ("name", ["drag"]),  # always names
    "sure": ("none", []),  # never says anything, with probability 0.995
}


def main(mode: str, bench: str, out: str) -> int:
    if mode == "clumsy":
        print("I broke down")
        return 3
    rig = next(Path(bench).glob("*/recording.toml")).parent.name.split("-")[0]
    verdict, names = MODES[mode]
    rig_diagnosis = {
        "alarm": verdict != "none",
        "verdict": verdict,
        "names": names,
        "sectors": [],
        "parameters": {},
        "held_out": {},
    }
    if mode == "sure":
        rig_diagnosis |= {
            "p_verdict": 0.995,
            "explanations": [{"effects": [], "probability": 0.995}],
            "matters": False,
        }
    (Path(out) / "diagnosis.json").write_text(
        json.dumps({"schema": 1, "rigs": {rig: rig_diagnosis}})
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
