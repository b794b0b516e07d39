#!/usr/bin/env python3
"""Compares what the checks foretell with what the simulated printer loses, without supports:

  compare_foretold.py PLUMBLINE SCAN [OPTION ...] [-- SCAN [OPTION ...]] ...     options of 'plumbline print', such as --height 60mm

Each scan or mesh is printed on sim2k in layers of 0.1 mm, with a resin that holds 20 times as much as any, so that nothing tears: the checks
foretell what falls, not what the peel tears off. Prints a table in Markdown.
Exit status: 0 all as foretold, 1 something else fell, or a program failed, 2 wrong use.
"""

import itertools
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

BOARD = Path(__file__).resolve().parents[2] / "board"
TOLERANCE = 0.02


def strong_profile(folder):
    text = (BOARD / "profiles/standard.toml").read_text()
    text = re.sub(r"(?m)^(green_strength|plate_adhesion) = [0-9.]+", r"\1 = 100.0", text)
    path = folder / "strong.toml"
    path.write_text(re.sub(r'(?m)^name = "\w+"', 'name = "strong"', text, count=1))
    return path


def printed(plumbline, job, folder):
    report = folder / "report.json"
    done = subprocess.run(
        [plumbline, "print", *job, "--printer", BOARD / "sim2k.toml", "--profile", strong_profile(folder), "--supports", "none",
         "--layer-height", "0.1", "--accept", "--quiet", "--report", report], capture_output=True, text=True, check=False)  # fmt: skip
    if done.returncode != 0:
        sys.exit(f"{' '.join(job)}:\n{done.stderr}")
    return json.loads(report.read_text())


def alike(a, b):
    return abs(a - b) <= TOLERANCE * max(a, b) + 1e-9


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    plumbline, *words = sys.argv[1:]
    jobs = [list(job) for end, job in itertools.groupby(words, lambda word: word == "--") if not end]
    print("| scan | pieces foretold, dropped | ml foretold, dropped | in their shadow, ml | torn off | largest pieces that match |")
    print("|---|---|---|---|---|---|", flush=True)
    good = True
    for job in jobs:
        with tempfile.TemporaryDirectory(prefix="plumbline-foretold-") as folder:
            report = printed(plumbline, job, Path(folder))
        found = report["issues"]
        pieces = found["kinds"].get("free_piece", {"count": 0, "largest": []})
        lost = {kind: [loss for loss in report["part"]["lost"] if loss["kind"].startswith(kind)] for kind in ("region", "light", "piece")}
        ml = {kind: sum(loss["ml"] for loss in losses) for kind, losses in lost.items()}
        matches = sum(
            any(piece["first_layer"] == loss["layer"] and piece["last_layer"] == loss["last_layer"] and alike(piece["volume_ml"], loss["ml"])
                for loss in lost["region"]) for piece in pieces["largest"])  # fmt: skip
        good = good and pieces["count"] == len(lost["region"]) and matches == len(pieces["largest"]) and not lost["piece"]
        good = good and alike(found["falls_ml"], ml["region"]) and alike(found["shadowed_ml"], ml["light"])
        print(f"| {Path(job[0]).stem} {' '.join(job[1:])} | {pieces['count']}, {len(lost['region'])} | {found['falls_ml']:.5f}, {ml['region']:.5f} | "
              f"{found['shadowed_ml']:.4f}, {ml['light']:.4f} | {len(lost['piece'])} | {matches} of {len(pieces['largest'])} |", flush=True)  # fmt: skip
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
