#!/usr/bin/env python3
"""Compares what `plumbline check` finds in stacks that PrusaSlicer exported with what UVtools' rules find in them:

  compare_checks.py PLUMBLINE MESH.ply ... [--size MM] [--pitch MM] [--turn X,Y]

PrusaSlicer slices each mesh, scaled to --size (25 mm) and turned, without and with supports, with grey edges as it does by default.
UVtools' rules are those of uvtools_rules.py. Both look at the same PNG files. Prints a table in Markdown, and findings of one that the
other has not.
Needs .ci/setup bench. Exit status: 0 done, 1 a program failed, 2 wrong use.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import cv2
import numpy as np
from compare_supports import PANEL_MM, prusa_archive, read_ply, run, turned, write_stl
from uvtools_rules import find_issues

KINDS = ("island", "overhang", "resin_trap", "suction_cup")


def checked(plumbline, folder, pitch):
    done = subprocess.run([str(w) for w in (plumbline, "check", folder, "--pixel-pitch", pitch, "--layer-height", pitch, "--json")],
                          capture_output=True, text=True, check=False)  # fmt: skip
    if done.returncode != 0:
        sys.exit(done.stderr)
    kinds = json.loads(done.stdout)["issues"]["kinds"]
    return {kind: kinds.get(kind, {"count": 0, "largest": []}) for kind in KINDS}


def spans(kind, ours, theirs):
    """Layers of the largest findings: ours as kept, as many of theirs."""
    if kind in ("island", "overhang"):
        return sorted((i["layer"],) for i in ours), sorted((t[0],) for t in theirs)
    return sorted((i["first_layer"], i["last_layer"]) for i in ours), sorted(t[:2] for t in theirs)


def compare(plumbline, name, folder, pitch):
    ours = checked(plumbline, folder, pitch)
    layers = [cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in sorted(folder.glob("*.png"))]
    found = find_issues(layers, pitch)
    theirs = dict(zip(KINDS, (found.islands, found.overhangs, found.traps, found.cups)))
    cells = " | ".join(f"{ours[kind]['count']} / {len(theirs[kind])}" for kind in KINDS)
    print(f"| {name} | {len(layers)} | {cells} |", flush=True)
    for kind in KINDS:
        kept = ours[kind].get("largest", [])
        mine, other = spans(kind, kept, theirs[kind])
        extra = [s for s in mine if s not in other]
        missing = [s for s in other if s not in mine] if ours[kind]["count"] <= len(kept) else []
        if extra or missing:
            print(f"  {kind}: only plumbline {extra}, only UVtools' rules {missing}", file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plumbline", type=Path)
    parser.add_argument("meshes", type=Path, nargs="+", metavar="MESH.ply")
    parser.add_argument("--size", type=float, default=25)
    parser.add_argument("--pitch", type=float, default=0.05)
    parser.add_argument("--turn", default="0,0", help="degrees about x, then y")
    parser.add_argument("--keep", type=Path, help="keep the stacks here")
    chosen = parser.parse_args()
    turn = tuple(float(word) for word in chosen.turn.split(","))
    panel = PANEL_MM * max(1.0, chosen.size / 25)
    print("| stack | layers | islands | overhangs | resin traps | suction cups |")
    print("|---|---|---|---|---|---|", flush=True)
    for mesh in chosen.meshes:
        points, faces = read_ply(mesh)
        points = (points - points.mean(axis=0)) * (chosen.size / np.ptp(points, axis=0).max())
        with tempfile.TemporaryDirectory(prefix="plumbline-checks-") as temporary:
            work = Path(temporary)
            write_stl(work / "mesh.stl", turned(points, *turn), faces)
            for supports in (0, 1):
                name = f"{mesh.stem} {'with' if supports else 'without'} supports"
                folder = (chosen.keep or work) / name.replace(" ", "_")
                archive = prusa_archive(work / "mesh.stl", work, chosen.pitch, panel, f"--supports-enable={supports}",
                                        f"--pad-enable={supports}")  # fmt: skip
                with zipfile.ZipFile(archive) as stack:
                    stack.extractall(folder, [n for n in stack.namelist() if n.endswith(".png") and "/" not in n])
                compare(chosen.plumbline, name, folder, chosen.pitch)


if __name__ == "__main__":
    main()
