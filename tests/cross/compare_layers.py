#!/usr/bin/env python3
"""Compares the masks of two builds of plumbline: compare_layers.py HOST_PROGRAM [--scans FOLDER] [--coarse] -- TARGET_PROGRAM...

The words after -- run the other build, emulator included. Both builds slice each scan; the hash of every layer and of the whole job
must agree, and the bytes of the sample scans that both write. --scans names a folder of real scans;
those in REAL are sliced too. Without them only the samples count; in CI (environment variable CI) with ../shared beside the
repository that is an error.
--coarse takes a part of the time: it slices with pixels and layers of twice the size, and compares the bytes of one sample.
Exit status: 0 all agree, 1 some differ, 2 nothing could be compared.
"""

import json
import math
import os
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

VIEWS = "two views that are registered"
BOARD = "BOARD"  # stands for the path of a file with this content
BOARD_TOML = """[printer]
name = "coarse"
[panel]
columns = {columns}
rows = {rows}
pixel_pitch_x_mm = {pitch_x}
pixel_pitch_y_mm = {pitch_y}
[z_stage]
travel_mm = 80.0
[print]
layer_height_mm = {layer}
[memory]
arena_mib = 48
"""

# Name, arguments of `plumbline sample`, arguments of `plumbline slice`. Each covers something that the others don't: the printer's
# grid, sines and cosines with supports, estimated normals, thinning in a small arena, views and their registration.
SAMPLES = [
    ("on a printer", ["--points", "8000", "--seed", "1"], ["--printer", BOARD]),
    ("turned, scaled, supported", ["--points", "8000", "--seed", "2"],
     ["--pixel-pitch", "0.15", "--layer-height", "0.15", "--rotate-x", "37", "--rotate-y", "-11.5", "--rotate-z", "201",
      "--scale", "0.7", "--supports", "auto"]),
    ("without normals", ["--points", "8000", "--seed", "3"], ["--pixel-pitch", "0.15", "--layer-height", "0.15"]),
    ("thinned", ["--points", "60000", "--seed", "4"],
     ["--pixel-pitch", "0.2", "--layer-height", "0.2", "--arena-mib", "6"]),
    (VIEWS, ["--points", "34000", "--seed", "4"], ["--pixel-pitch", "0.2", "--layer-height", "0.2"]),
]
# Name, share of the faces that are missing, mm beyond which all are, arguments of `plumbline slice`. The second and third ask winding
# numbers: of all triangles, and of the rims of large holes.
MESHES = [
    ("a mesh", 0, 99, ["--pixel-pitch", "0.1", "--layer-height", "0.1", "--rotate-x", "33", "--rotate-z", "12"]),
    ("a mesh with holes", 0.05, 99, ["--pixel-pitch", "0.3", "--layer-height", "0.3"]),
    ("a mesh without a side", 0, 9, ["--pixel-pitch", "0.1", "--layer-height", "0.1", "--rotate-x", "33"]),
]
# Name: how many times larger the board's pixels are, and arguments of `plumbline slice`.
REAL = {
    "ucicouple_front.ply": (2, ["--fit", "--printer", BOARD]),
    "gargoyle.ply": (1, ["--units", "auto", "--pixel-pitch", "0.5", "--layer-height", "0.5", "--arena-mib", "64"]),
}
SOURCE_DIR = Path(__file__).resolve().parents[2]


def run(command):
    done = subprocess.run(command, cwd=SOURCE_DIR, capture_output=True, text=True)
    if done.returncode != 0:
        print(f"{' '.join(map(str, command))}\nended with {done.returncode}:\n{done.stdout}{done.stderr}")
        sys.exit(1)


def without_normals(ply, xyz):
    """The positions of a binary PLY of six floats a vertex, as text with all their digits."""
    data = ply.read_bytes()
    body = data.index(b"end_header\n") + len(b"end_header\n")
    with open(xyz, "w", encoding="ascii") as file:
        for vertex in struct.iter_unpack("<6f", data[body:]):
            file.write(f"{vertex[0]:.9g} {vertex[1]:.9g} {vertex[2]:.9g}\n")


def move_half(ply, moved):
    """Moves every second vertex of a binary PLY of six floats a vertex, by .15 mm, to a file of its own."""
    data = ply.read_bytes()
    body = data.index(b"end_header\n") + len(b"end_header\n")
    points = [data[at : at + 24] for at in range(body, len(data), 24)]
    for path, half in (ply, points[::2]), (moved, [struct.pack("<6f", p[0] + 0.15, *p[1:]) for p in map(struct.Struct("<6f").unpack, points[1::2])]):
        path.write_bytes(data[:body].replace(b"vertex %d" % len(points), b"vertex %d" % len(half)) + b"".join(half))


def write_mesh(stl, missing, cut, around=64, across=24):
    """A ring of 20 mm whose tube swells five times, as a binary STL."""

    def corner(i, j):
        a, b = 2 * math.pi * (i % around) / around, 2 * math.pi * (j % across) / across
        tube = 3 + math.sin(5 * a)
        return (10 + tube * math.cos(b)) * math.cos(a), (10 + tube * math.cos(b)) * math.sin(a), tube * math.sin(b)

    triangles = []
    for i in range(around):
        for j in range(across):
            a, b, c, d = corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)
            triangles += [(a, b, c), (a, c, d)]
    triangles = [triangle for k, triangle in enumerate(triangles) if (k * 0.618034) % 1 >= missing and min(corner[0] for corner in triangle) < cut]
    with open(stl, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", len(triangles)))
        for a, b, c in triangles:
            file.write(struct.pack("<12fH", 0, 0, 0, *a, *b, *c, 0))


def board_toml(size):
    return BOARD_TOML.format(columns=419 // size, rows=683 // size, pitch_x=0.16 * size, pitch_y=0.14 * size, layer=0.15 * size)


def sized(options, size):
    """The options with `size` times their pixel pitch and layer height."""
    lengths = ("--pixel-pitch", "--layer-height")
    return [f"{float(option) * size:g}" if i > 0 and options[i - 1] in lengths else option for i, option in enumerate(options)]


def hashes_of(program, scan, options, size, out):
    board = out.parent / "coarse.toml"
    board.write_text(board_toml(size))
    options = [board if option == BOARD else option for option in sized(options, size)]
    started = time.monotonic()
    run([*program, "slice", scan, "-o", out, "--no-preview", "--quiet", *options])
    manifest = json.loads((out / "manifest.json").read_text())
    return manifest["hashes"] | {"views": manifest["views"]}, time.monotonic() - started


def compare(name, scan, options, size, programs, work):
    """Slices with both; True if all hashes agree."""
    (host, host_s), (target, target_s) = (
        hashes_of(program, scan, options, size, work / f"out{i}") for i, program in enumerate(programs)
    )
    layers = len(host["layers"])
    if layers < 20 or len(set(host["layers"])) < 10:
        print(f"FAILED  {name}: {layers} layers are too few to compare")
        return False
    if name == VIEWS and not host["views"]["moved_mm"] > 0:
        print(f"FAILED  {name}: none was moved")
        return False
    if host == target:
        print(f"ok      {name}: {layers} layers, host {host_s:.1f} s, target {target_s:.1f} s")
        return True
    if host["views"] != target["views"]:
        print(f"        views: host {host['views']}, target {target['views']}")
    differ = [k for k, (a, b) in enumerate(zip(host["layers"], target["layers"])) if a != b]
    print(f"FAILED  {name}: host has {layers} layers, target {len(target['layers'])}; {len(differ)} differ, first {differ[:5]}")
    return False


def main(arguments):
    if "--" not in arguments:
        print(__doc__, file=sys.stderr)
        return 2
    split = arguments.index("--")
    ours, target = arguments[:split], arguments[split + 1 :]
    coarse = "--coarse" in ours
    size = 2 if coarse else 1
    scans = Path(ours[ours.index("--scans") + 1]) if "--scans" in ours else None
    programs = [[ours[0]], target]
    agree = True
    with tempfile.TemporaryDirectory(prefix="plumbline-cross-") as folder:
        work = Path(folder)
        for name, made, sliced in SAMPLES:
            files = []
            for i, program in enumerate(programs[: 1 if coarse and name != SAMPLES[0][0] else 2]):
                files.append(work / f"sample{i}.ply")
                run([*program, "sample", files[-1], "--quiet", *made])
            if files[0].read_bytes() != files[-1].read_bytes():
                print(f"FAILED  {name}: the two builds write different samples")
                agree = False
            scan = files[0]
            if name == "without normals":
                scan = work / "sample.xyz"
                without_normals(files[0], scan)
            more = []
            if name == VIEWS:
                more = [work / "moved.ply"]
                move_half(scan, more[0])
            agree &= compare(name, scan, [*more, *sliced], size, programs, work)
        for name, missing, cut, sliced in MESHES:
            mesh = work / "mesh.stl"
            write_mesh(mesh, missing, cut)
            agree &= compare(name, mesh, sliced, size, programs, work)
        real = [(scans / name, *how) for name, how in REAL.items() if scans and (scans / name).is_file()]
        for scan, larger, options in real:
            agree &= compare(scan.name, scan, options, size * larger, programs, work)
        if not real and "CI" in os.environ and (SOURCE_DIR.parent / "shared").is_dir():
            print(f"FAILED  no real scans in {scans}")
            agree = False
        elif not real:
            print("        no real scans beside the repository: only samples were compared")
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
