#!/usr/bin/env python3
"""Compares plumbline with PrusaSlicer on the same meshes and masks:

  compare_meshes.py PLUMBLINE MASK_DIFFERENCE MESH.ply|MESH.stl ... [--turns N] [--halve N] [--repeat N] [--every N]

Both make the masks of a 2K panel (1440 x 2560 pixels of 0.04725 mm) for layers of 0.05 mm, without supports, on one core. Each mesh is
also turned N times, about axes that have nothing to do with its own; --halve divides each triangle into 4, N times. A mesh is in mm,
binary (PLY with triangles, or STL).
Prints a table in Markdown: CPU seconds (the median of --repeat runs), seconds until plumbline could show its first layer, peak memory, and the pixels that differ, in all and of those more
than a pixel from an edge. PrusaSlicer counts a pixel that is covered by half, plumbline one whose centre is inside. Needs .ci/setup
bench, and mask_difference of a build with PLUMBLINE_BENCHMARKS.
Exit status: 0 done, 1 a program failed, 2 wrong use.
"""

import argparse
import json
import math
import multiprocessing
import shutil
import struct
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from measured_run import Cost, measure, stay_on_one_core

COLUMNS, ROWS, PITCH, LAYER = 1440, 2560, 0.04725, 0.05
WIDTH, HEIGHT = COLUMNS * PITCH, ROWS * PITCH
TRAVEL = 160.0  # mm

BOARD = f"""[printer]
name = "bench2k"
[panel]
columns = {COLUMNS}
rows = {ROWS}
pixel_pitch_x_mm = {PITCH}
pixel_pitch_y_mm = {PITCH}
[z_stage]
travel_mm = {TRAVEL}
[print]
layer_height_mm = {LAYER}
[memory]
arena_mib = 512
"""


def single(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def read_ply(data):
    start = data.index(b"end_header\n") + 11
    sizes = {"float": "f", "float32": "f", "double": "d", "uchar": "B", "uint8": "B", "int": "i", "int32": "i"}
    counts, row, element = {}, "<", ""
    for words in (line.split() for line in data[:start].decode().splitlines()):
        if words[:1] == ["element"]:
            element = words[1]
            counts[element] = int(words[2])
        elif words[:1] == ["property"] and element == "vertex":
            row += sizes[words[1]]
    stride = struct.calcsize(row)
    corners = [struct.unpack_from(row, data, start + i * stride)[:3] for i in range(counts["vertex"])]
    at, faces = start + counts["vertex"] * stride, []
    for _ in range(counts["face"]):
        faces.append(struct.unpack_from("<3i", data, at + 1))
        at += 13
    return corners, faces


def read_stl(data):
    numbers, corners, faces = {}, [], []
    for record in struct.iter_unpack("<12fH", data[84:]):
        face = []
        for corner in (record[3:6], record[6:9], record[9:12]):
            face.append(numbers.setdefault(corner, len(corners)))
            if face[-1] == len(corners):
                corners.append(corner)
        faces.append(tuple(face))
    return corners, faces


def halved(corners, faces):
    corners, middles, finer = list(corners), {}, []

    def middle(a, b):
        key = (min(a, b), max(a, b))
        if key not in middles:
            middles[key] = len(corners)
            corners.append(tuple(single((p + q) / 2) for p, q in zip(corners[key[0]], corners[key[1]])))
        return middles[key]

    for a, b, c in faces:
        x, y, z = middle(a, b), middle(b, c), middle(c, a)
        finer += [(a, x, z), (x, b, y), (z, y, c), (x, y, z)]
    return corners, finer


def turned(corners, turn):
    """About z, then about x, by angles that no mesh knows; shrunk if it would not fit."""
    a, b = 0.7 * turn, 1.1 * turn
    ca, sa, cb, sb = math.cos(a), math.sin(a), math.cos(b), math.sin(b)
    moved = [(ca * x - sa * y, cb * (sa * x + ca * y) - sb * z, sb * (sa * x + ca * y) + cb * z) for x, y, z in corners]
    low = [min(axis) for axis in zip(*moved)]
    high = [max(axis) for axis in zip(*moved)]
    scale = min(1.0, *(0.95 * room / (h - l) for room, l, h in zip((WIDTH, HEIGHT, TRAVEL), low, high)))
    return [tuple(single(scale * (x - l)) for x, l in zip(corner, low)) for corner in moved]


def write_stl(path, corners, faces):
    with open(path, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", len(faces)))
        for a, b, c in faces:
            file.write(struct.pack("<12fH", 0, 0, 0, *corners[a], *corners[b], *corners[c], 0))


def make_mesh(path, times, turn, made):
    data = path.read_bytes()
    corners, faces = read_ply(data) if data.startswith(b"ply") else read_stl(data)
    for _ in range(times):
        corners, faces = halved(corners, faces)
    write_stl(made, turned(corners, turn), faces)


def slice_with_plumbline(plumbline, mesh, work):
    board = work / "bench2k.toml"
    board.write_text(BOARD)
    cost = measure([plumbline, "slice", mesh, "-o", work / "ours", "--printer", board, "--supports", "none", "--no-preview", "--quiet",
                    "--threads", 1])  # fmt: skip
    stages = json.loads((work / "ours" / "manifest.json").read_text())["stages"]
    return cost, sum(stage["seconds"] for stage in stages if stage["name"] in ("read", "ray grid", "rays", "r-rep"))


def slice_with_prusa(mesh, work):
    archive = work / "mesh.sl1"
    cost = measure([
        "prusa-slicer", "--export-sla", mesh, "--output", archive, "--printer-technology", "SLA", "--layer-height", LAYER,
        "--initial-layer-height", LAYER, "--supports-enable=0", "--pad-enable=0", "--display-orientation", "landscape",
        "--display-width", WIDTH, "--display-height", HEIGHT, "--display-pixels-x", COLUMNS, "--display-pixels-y", ROWS,
        "--display-mirror-x=0", "--display-mirror-y=0", "--max-print-height", 1000, "--elefant-foot-compensation", 0,
        "--slice-closing-radius", 0, "--gamma-correction", 0, "--bed-shape", f"0x0,{WIDTH}x0,{WIDTH}x{HEIGHT},0x{HEIGHT}",
        "--center", f"{WIDTH / 2},{HEIGHT / 2}",
    ])  # fmt: skip
    folder = work / "theirs"
    shutil.rmtree(folder, ignore_errors=True)
    with zipfile.ZipFile(archive) as masks:
        masks.extractall(folder, [name for name in masks.namelist() if name.endswith(".png") and "/" not in name])
    return cost, folder


def differences(program, ours, theirs, every):
    done = subprocess.run([program, ours, theirs, str(every)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(done.stderr)
    words = done.stdout.split()
    return {name: int(words[words.index(name) + 1]) for name in ("pixels", "cured", "differ", "far")}


def median(costs):
    return Cost(*(sorted(values)[len(values) // 2] for values in zip(*costs)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plumbline", type=Path)
    parser.add_argument("mask_difference", type=Path)
    parser.add_argument("meshes", type=Path, nargs="+", metavar="MESH")
    parser.add_argument("--turns", type=int, default=1, help="turned copies of each, the first of which is as it is")
    parser.add_argument("--halve", type=int, default=0)
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--every", type=int, default=1, help="compare every Nth layer only")
    chosen = parser.parse_args()
    if shutil.which("prusa-slicer") is None:
        sys.exit("prusa-slicer: not found. Run .ci/setup bench")
    stay_on_one_core()
    print("| mesh | triangles | ours: CPU s | first layer after, s | MiB | PrusaSlicer: CPU s | MiB | CPU, ours / theirs | differ, % of pixels | % of cured | far |")
    print("|---|---|---|---|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory(prefix="plumbline-meshes-") as folder:
        work = Path(folder)
        for path in chosen.meshes:
            for turn in range(chosen.turns):
                mesh = work / "mesh.stl"
                # In a process of its own: a child of a large process would seem to be as large until it has become another program.
                maker = multiprocessing.Process(target=make_mesh, args=(path, chosen.halve, turn, mesh))
                maker.start()
                maker.join()
                if maker.exitcode != 0:
                    sys.exit(f"{path}: is no mesh that can be compared")
                triangles = (mesh.stat().st_size - 84) // 50
                ours, theirs, ready = [], [], []
                for _ in range(chosen.repeat):
                    cost, seconds = slice_with_plumbline(chosen.plumbline, mesh, work)
                    ours.append(cost)
                    ready.append(seconds)
                    cost, masks = slice_with_prusa(mesh, work)
                    theirs.append(cost)
                found = differences(chosen.mask_difference, work / "ours" / "layers", masks, chosen.every)
                a, b = median(ours), median(theirs)
                print(f"| {path.stem}{f', turn {turn}' if turn else ''} | {triangles:,} | {a.cpu_s:.2f} | {min(ready):.2f} | {a.peak_mib:.0f} | {b.cpu_s:.1f} | "
                      f"{b.peak_mib:.0f} | {a.cpu_s / b.cpu_s:.3f} | {100 * found['differ'] / found['pixels']:.4f} | "
                      f"{100 * found['differ'] / found['cured']:.3f} | {found['far']} |", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
