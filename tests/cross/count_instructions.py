#!/usr/bin/env python3
"""Counts the instructions of each stage in a build for boards: count_instructions.py BUILD HOST_PROGRAM [--update] -- EMULATOR... PROGRAM

BUILD is aarch64 or armv7. HOST_PROGRAM is this machine's plumbline, which makes the scans. The words after -- run the other build
under QEMU's user emulation, where a plug-in counts (count_instructions.cpp, compiled here with c++). It slices and prints a sample scan
with one thread in several runs. Two runs differ in one thing, so the difference of their counts is what that thing costs. A mesh of a
million triangles is sliced, too.

The counts depend on the program, not on the machine or its load. More than 10 % above instructions.json is an error. --update writes
the counts there. board/README.md has the table and what it means in seconds.
Exit status: 0 no slower than before, 1 slower or not repeatable, 2 wrong use.
"""

import json
import math
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

from counted_run import SOURCE_DIR, Counter, is_repeatable

KEPT = Path(__file__).with_name("instructions.json")
MARGIN = 0.10

POINTS = 100_000
# At this size the sample has about 200 layers of 0.1 mm, and all but a few of its points lie too far apart to be averaged.
SCALE = 0.35
SLICE = ["slice", "--printer", SOURCE_DIR / "board/mono2k.toml", "--no-preview", "-o", "OUT"]
# A print makes the masks but no PNG files; this one ends before its first layer.
PRINT = ["print", "--printer", SOURCE_DIR / "board/sim2k.toml", "--fault", "power.cut@layer=0"]


# A torus of 60 x 60 x 24 mm: 1000 * 500 squares of two triangles.
AROUND, THROUGH, RING, TUBE = 1000, 500, 18.0, 12.0


def write_mesh(path):
    """Writes the torus as binary STL."""
    circles = [[(math.cos(2 * math.pi * i / n), math.sin(2 * math.pi * i / n)) for i in range(n)] for n in (AROUND, THROUGH)]

    def corner(i, j):
        (x, y), (out, up) = circles[0][i % AROUND], circles[1][j % THROUGH]
        return (RING + TUBE * out) * x, (RING + TUBE * out) * y, TUBE * up

    facet = struct.Struct("<12fH")
    with open(path, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", 2 * AROUND * THROUGH))
        for i in range(AROUND):
            for j in range(THROUGH):
                a, b, c, d = corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)
                file.write(facet.pack(0, 0, 0, *a, *b, *c, 0) + facet.pack(0, 0, 0, *a, *c, *d, 0))


def count(counter, scan, arguments, layer_height, status, scale=SCALE):
    """Counts of one run, with the layers and rays of its manifest."""
    out = counter.work / "out"
    command, *options = [out if word == "OUT" else word for word in arguments]
    counts = counter.run([command, scan, *options, "--scale", scale, "--layer-height", layer_height], status)
    manifest = out / "manifest.json"
    made = json.loads(manifest.read_text()) if manifest.exists() else None
    counts.layers = made["grid"]["layers"] if made else 0
    counts.rays = made["rays"]["interested"] if made else 0
    return counts


def measure(host, command, work):
    """Counts of a build by name, and whether two equal runs agree."""
    counter = Counter(command, work)
    scans = {}
    for points in (POINTS, 2 * POINTS):
        scans[points] = work / f"{points}.ply"
        subprocess.run([host, "sample", scans[points], "--points", str(points), "--quiet"], check=True)

    def of(points, arguments, layer_height=0.1, status=0):
        return count(counter, scans[points], arguments, layer_height, status)

    mesh = work / "mesh.stl"
    write_mesh(mesh)
    of_mesh = count(counter, mesh, SLICE, 0.05, 0, scale=1)
    printed = of(POINTS, PRINT, status=1)
    base, again = of(POINTS, SLICE), of(POINTS, SLICE)
    twice, fine = of(2 * POINTS, SLICE), of(POINTS, SLICE, layer_height=0.05)
    more_millions = POINTS / 1e6
    more_layers = fine.layers - base.layers
    built = ("trees", "clustering", "winding", "ray grid")

    def more(stages, run):
        return sum(run.stages[stage] - base.stages[stage] for stage in stages)

    figures = {
        "read, a million points": more(["read"], twice) / more_millions,
        "trees and clusters, a million points": more(built, twice) / more_millions,
        "rays, a thousand rays": base.stages["rays"] * 1000 / base.rays,
        # Not proportional either: the support radius depends on the scan.
        "rays, a thousand rays, twice the points": twice.stages["rays"] * 1000 / twice.rays,
        "R-Rep, a layer": more(["r-rep"], fine) / more_layers,
        "mask and checks, a layer": printed.stages["layers"] / base.layers,
        "mask and its PNG file, a layer": more(["layers"], fine) / more_layers,
        "slice of 100,000 points": base.total,
        "a mesh of a million triangles, before the first layer": of_mesh.total - of_mesh.stages["layers"],
        "its masks and their PNG files, a layer": of_mesh.stages["layers"] / of_mesh.layers,
    }
    return {name: round(value) for name, value in figures.items()}, is_repeatable(base, again)


def main(arguments):
    if len(arguments) < 4 or "--" not in arguments:
        print(__doc__, file=sys.stderr)
        return 2
    split = arguments.index("--")
    ours, command = arguments[:split], arguments[split + 1 :]
    build, host = ours[:2]
    with tempfile.TemporaryDirectory(prefix="plumbline-count-") as folder:
        figures, repeatable = measure(host, command, Path(folder))
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    before = kept.get(build, {})
    result = 0
    for name, value in figures.items():
        was = before.get(name)
        change = f"{value / was - 1:+8.2%}" if was else "     new"
        slower = was is not None and value > was * (1 + MARGIN)
        print(f"{'FAILED' if slower else 'ok':8}{name:56}{value:18,}{change}")
        result |= slower
    result |= not repeatable
    if "--update" in ours:
        KEPT.write_text(json.dumps({**kept, build: figures}, indent=2, sort_keys=True) + "\n")
        return 0
    if not before:
        print(f"FAILED  {KEPT.name} has no counts of {build}: run this with --update")
        return 1
    if result:
        print("if the increase is intended: run this with --update and correct the table in board/README.md")
    return int(result)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
