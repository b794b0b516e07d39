#!/usr/bin/env python3
"""Compares plumbline's supports with PrusaSlicer's on the same meshes:

  compare_supports.py PLUMBLINE MESH.ply ... [--size MM] [--pitch MM] [--orientations N] [--keep DIR]

Each mesh is scaled to --size (25 mm) and turned into up to six orientations. Both slice it with their default settings. Masks of both are
measured alike (support_figures.py). Voxels are cubes of --pitch (0.1 mm).
Prints a table in Markdown. Needs .ci/setup bench, python3-numpy, python3-scipy and python3-pil.
Exit status: 0 done, 1 a program failed, 2 wrong use.
"""

import argparse
import io
import json
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np
from PIL import Image
from support_figures import measure_supports

# About x, then about y, degrees.
ORIENTATIONS = ((0, 0), (180, 0), (90, 0), (0, 90), (35, 0), (0, 135))
PANEL_MM = 80  # at 25 mm


def read_ply(path):
    """Vertices and triangles of a binary or ASCII PLY file whose faces are triangles."""
    data = Path(path).read_bytes()
    end = data.index(b"end_header") + len(b"end_header\n")
    lines = data[:end].decode().split("\n")
    counts, properties, element = {}, {}, None
    for words in map(str.split, lines):
        if words[:1] == ["element"]:
            element = words[1]
            counts[element], properties[element] = int(words[2]), []
        elif words[:1] == ["property"]:
            properties[element].append(words)
    if "format ascii 1.0" in lines:
        rows = data[end:].decode().split("\n")
        points = np.array([row.split()[:3] for row in rows[: counts["vertex"]]], dtype=float)
        faces = np.array([row.split()[1:4] for row in rows[counts["vertex"] : counts["vertex"] + counts["face"]]], dtype=int)
        return points, faces
    types = {"float": "<f4", "float32": "<f4", "double": "<f8", "uchar": "u1", "uint8": "u1", "int": "<i4", "int32": "<i4"}
    vertex = np.dtype([(words[2], types[words[1]]) for words in properties["vertex"]])
    table = np.frombuffer(data, vertex, counts["vertex"], end)
    words = properties["face"][0]
    face = np.dtype([("n", types[words[2]]), ("v", "<i4", 3)])
    faces = np.frombuffer(data, face, counts["face"], end + counts["vertex"] * vertex.itemsize)["v"]
    return np.stack([table[axis] for axis in "xyz"], axis=1).astype(float), faces.astype(int)


def turned(points, degrees_x, degrees_y):
    a, b = np.radians((degrees_x, degrees_y))
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    return points @ (about_y @ about_x).T


def write_stl(path, points, faces):
    record = np.zeros(len(faces), np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")]))
    record["v"] = points[faces]
    path.write_bytes(bytes(80) + np.uint32(len(faces)).tobytes() + record.tobytes())


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}:\n{done.stdout}{done.stderr}")


def stack(images):
    return np.stack([np.asarray(Image.open(image).convert("L")) > 127 for image in images])


def plumbline_masks(plumbline, mesh, work, pitch, *options):
    out = work / "out"
    run(plumbline, "slice", mesh, "-o", out, "--pixel-pitch", pitch, "--layer-height", pitch, "--no-preview", "--threads", 1, "--quiet",
        *options)  # fmt: skip
    manifest = json.loads((out / "manifest.json").read_text())
    masks = stack(sorted((out / "layers").glob("*.png"))[: manifest["grid"]["layers"]])
    return masks, manifest


def plumbline_supports(plumbline, mesh, work, pitch):
    """Object without and with supports, aligned."""
    thing, _ = plumbline_masks(plumbline, mesh, work, pitch, "--supports", "none")
    masks, manifest = plumbline_masks(plumbline, mesh, work, pitch, "--supports", "auto")
    found = manifest["supports"]
    thing = thing[found["sunk_layers"] :]
    room = (masks.shape[1] - thing.shape[1]) // 2
    aligned = np.zeros_like(masks)
    aligned[found["lifted_layers"] :, room : room + thing.shape[1], room : room + thing.shape[2]] = thing
    return aligned, masks


def prusa_archive(mesh, work, pitch, panel, *options):
    """The layers as PrusaSlicer exports them, as a ZIP file of PNG files."""
    archive = work / "mesh.sl1"
    pixels = round(panel / pitch)
    run("prusa-slicer", "--export-sla", mesh, "--output", archive, "--printer-technology", "SLA", "--layer-height", pitch,
        "--initial-layer-height", pitch, "--display-orientation", "landscape", "--display-width", panel, "--display-height", panel,
        "--display-pixels-x", pixels, "--display-pixels-y", pixels, "--max-print-height", 1000,
        "--absolute-correction", 0, "--elefant-foot-compensation", 0, "--display-mirror-x=0",
        "--bed-shape", f"0x0,{panel}x0,{panel}x{panel},0x{panel}", "--center", f"{panel / 2},{panel / 2}", *options)  # fmt: skip
    return archive


def prusa_masks(mesh, work, pitch, panel, *options):
    with zipfile.ZipFile(prusa_archive(mesh, work, pitch, panel, "--gamma-correction", 0, *options)) as masks:
        names = sorted(name for name in masks.namelist() if name.endswith(".png") and "/" not in name)
        return stack(io.BytesIO(masks.read(name)) for name in names)


def prusa_supports(mesh, work, pitch, panel):
    thing = prusa_masks(mesh, work, pitch, panel, "--supports-enable=0", "--pad-enable=0")
    # Its lift is the elevation (5 mm) and the pad (2 mm). In whole layers, both stacks have the object's same sections.
    elevation = round(7 / pitch) * pitch - 2
    masks = prusa_masks(mesh, work, pitch, panel, "--supports-enable=1", "--pad-enable=1", "--support-object-elevation", elevation)
    aligned = np.zeros_like(masks)
    aligned[len(masks) - len(thing) :] = thing
    return aligned, masks


def row(shape, turn, program, f):
    return (f"| {shape} | {turn[0]}, {turn[1]} | {program} | {f.islands} | {f.tips} | {f.mean_mm2:.2f} | {f.most_mm2:.1f} | {f.far_mm2:.1f} | "
            f"{f.free_mm:.1f} | {f.volume_mm3:,.0f} |")  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plumbline", type=Path)
    parser.add_argument("meshes", type=Path, nargs="+", metavar="MESH.ply")
    parser.add_argument("--size", type=float, default=25)
    parser.add_argument("--pitch", type=float, default=0.1)
    parser.add_argument("--orientations", type=int, default=len(ORIENTATIONS))
    parser.add_argument("--keep", type=Path, help="save masks of both here, as NumPy arrays")
    chosen = parser.parse_args()
    print("| shape | turned about x, y | program | islands | tips | mm2 a tip | most | far mm2 | free mm | supports mm3 |")
    print("|---|---|---|---|---|---|---|---|---|---|", flush=True)
    panel = PANEL_MM * max(1.0, chosen.size / 25)
    for mesh in chosen.meshes:
        points, faces = read_ply(mesh)
        points = (points - points.mean(axis=0)) * (chosen.size / np.ptp(points, axis=0).max())
        for turn in ORIENTATIONS[: chosen.orientations]:
            with tempfile.TemporaryDirectory(prefix="plumbline-supports-") as folder:
                work = Path(folder)
                stl = work / "mesh.stl"
                write_stl(stl, turned(points, *turn), faces)
                ours = plumbline_supports(chosen.plumbline, stl, work, chosen.pitch)
                print(row(mesh.stem, turn, "plumbline", measure_supports(*ours, chosen.pitch)), flush=True)
                theirs = prusa_supports(stl, work, chosen.pitch, panel)
                print(row(mesh.stem, turn, "PrusaSlicer", measure_supports(*theirs, chosen.pitch)), flush=True)
                if chosen.keep:
                    chosen.keep.mkdir(parents=True, exist_ok=True)
                    name = f"{mesh.stem}_{turn[0]}_{turn[1]}.npz"
                    np.savez_compressed(chosen.keep / name, ours_object=ours[0], ours=ours[1], theirs_object=theirs[0],
                                        theirs=theirs[1])  # fmt: skip


if __name__ == "__main__":
    main()
