#!/usr/bin/env python3
"""Compares what the checks foretell with what the simulated printer loses, without supports, and says what it objects to with them:

  compare_foretold.py PLUMBLINE SCAN [OPTION ...] [-- SCAN [OPTION ...]] ...     options of 'plumbline print', such as --height 60mm

Each scan or mesh is printed on sim2k in layers of 0.1 mm. Prints a table in Markdown; each pair is foretold, simulated.
Exit status: 0 all as foretold and no objection with supports, 1 otherwise, or a program failed, 2 wrong use.
"""

import itertools
import json
import subprocess
import sys
import tempfile
from pathlib import Path

BOARD = Path(__file__).resolve().parents[2] / "board"
TOLERANCE = 0.02
# Kind of issue, and how the simulated printer names it.
KINDS = {"free_piece": "region", "tear": "piece"}


def printed(plumbline, job, folder, supports):
    report = folder / "report.json"
    done = subprocess.run(
        [plumbline, "print", *job, "--printer", BOARD / "sim2k.toml", "--supports", supports, "--layer-height", "0.1", "--accept", "--quiet",
         "--report", report], capture_output=True, text=True, check=False)  # fmt: skip
    if done.returncode != 0:
        sys.exit(f"{' '.join(job)}:\n{done.stderr}")
    return json.loads(report.read_text())


def alike(a, b):
    return abs(a - b) <= TOLERANCE * max(a, b) + 1e-9


def is_foretold(piece, loss):
    return piece["first_layer"] == loss["layer"] and piece["last_layer"] == loss["last_layer"] and alike(piece["volume_ml"], loss["ml"])


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    plumbline, *words = sys.argv[1:]
    jobs = [list(job) for end, job in itertools.groupby(words, lambda word: word == "--") if not end]
    print("| scan | fall | ml | tear off | ml | in their shadow, ml | largest pieces that match | with supports: objections | foretold | supports |")
    print("|---|---|---|---|---|---|---|---|---|---|", flush=True)
    good = True
    for job in jobs:
        with tempfile.TemporaryDirectory(prefix="plumbline-foretold-") as folder:
            report = printed(plumbline, job, Path(folder), "none")
            held = printed(plumbline, job, Path(folder), "auto")
        found = report["issues"]
        losses = report["part"]["lost"]
        cells, matches, largest = [], 0, 0
        for kind, name in KINDS.items():
            pieces = found["kinds"].get(kind, {"count": 0, "largest": []})
            lost = [loss for loss in losses if loss["kind"].startswith(name)]
            ml = found["falls_ml" if kind == "free_piece" else "torn_ml"], sum(loss["ml"] for loss in lost)
            cells += [f"{pieces['count']}, {len(lost)}", f"{ml[0]:.5f}, {ml[1]:.5f}"]
            matches += sum(any(is_foretold(piece, loss) for loss in lost) for piece in pieces["largest"])
            largest += len(pieces["largest"])
            good = good and pieces["count"] == len(lost) and alike(*ml)
        shadow = found["shadowed_ml"], sum(loss["ml"] for loss in losses if loss["kind"].startswith("light"))
        good = good and matches == largest and alike(*shadow)
        kinds = ", ".join(f"{kind['count']} {name}" for name, kind in held["issues"]["kinds"].items()) or "nothing"
        good = good and not held["objections"]
        print(f"| {Path(job[0]).stem} {' '.join(job[1:])} | {' | '.join(cells)} | {shadow[0]:.4f}, {shadow[1]:.4f} | {matches} of {largest} | "
              f"{len(held['objections'])} | {kinds} | {held['supports']} |", flush=True)  # fmt: skip
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
