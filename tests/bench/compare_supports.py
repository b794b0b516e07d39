#!/usr/bin/env python3
"""Compares plumbline's supports with PrusaSlicer's on the same meshes and scans:

  compare_supports.py PLUMBLINE MESH.ply|SCAN.ply ... [--size MM] [--pitch MM] [--orientations N] [--runs N] [--kept FILE]

Each is scaled to --size (25 mm) and turned into up to six orientations. Both slice it with their default settings. Masks of both are
measured alike (support_figures.py). Voxels are cubes of --pitch (0.1 mm). A PLY file without faces is a scan with normals: PrusaSlicer
gets its Poisson reconstruction (pcl_poisson_reconstruction, depth 9), plumbline the points. PrusaSlicer places its points at random: its
figures are the medians of --runs (3). --kept FILE keeps them, and takes those that it has: they take most of the time, and do not change
with plumbline.
Prints a table in Markdown, plumbline / PrusaSlicer, and in how many rows plumbline is no worse. Needs .ci/setup bench, python3-numpy,
python3-scipy and python3-pil.
Exit status: 0 done, 1 a program failed, 2 wrong use.
"""

import argparse
import io
import json
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import astuple, fields
from pathlib import Path

import numpy as np
from mesh_arrays import read_stl
from PIL import Image
from support_figures import Figures, measure_supports

# About x, then about y, degrees.
ORIENTATIONS = ((0, 0), (180, 0), (90, 0), (0, 90), (35, 0), (0, 135))
PANEL_MM = 80  # at 25 mm


def read_ply(path):
    """Vertices and triangles of a binary or ASCII PLY file whose faces are triangles; without faces, points with normals and None."""
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
    if "face" not in counts:
        return np.stack([table[axis] for axis in ("x", "y", "z", "nx", "ny", "nz")], axis=1).astype(float), None
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


def write_points(path, points):
    """Points with normals."""
    axes = "".join(f"property float {axis}\n" for axis in ("x", "y", "z", "nx", "ny", "nz"))
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n{axes}end_header\n"
    path.write_bytes(head.encode() + points.astype("<f4").tobytes())


def reconstruct(scan, work):
    """Corners of the largest piece that Poisson reconstruction makes of a scan, and its triangles."""
    cloud, mesh, stl = work / "scan.pcd", work / "mesh.vtk", work / "poisson.stl"
    run("pcl_ply2pcd", scan, cloud)
    run("pcl_poisson_reconstruction", cloud, mesh, "-depth", 9)
    run(sys.executable, "-B", Path(__file__).with_name("vtk_to_stl.py"), mesh, stl)
    corners = read_stl(stl.read_bytes()).reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(-1, 3)


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
    # Layers above the object that held only a speck, which supports leave out, are not printed.
    thing = thing[: masks.shape[0] - found["lifted_layers"]]
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


COMPARED = {"islands": "islands", "mean_mm2": "mean", "most_mm2": "most", "volume_mm3": "volume", "scars_mm2": "scars",
            "front_scars_mm2": "scars in front", "gaps_mm3": "gaps"}


class Kept:
    """PrusaSlicer's figures by shape, orientation and settings, in a JSON file if there is one."""

    def __init__(self, path):
        self.path = path
        self.figures = json.loads(path.read_text()) if path and path.exists() else {}

    def get(self, key, measure):
        if key not in self.figures:
            self.figures[key] = astuple(measure())
            if self.path:
                self.path.write_text(json.dumps(self.figures, indent=0))
        return Figures(*self.figures[key])


def median(figures):
    return Figures(*np.median([astuple(f) for f in figures], axis=0))


def row(shape, turn, ours, theirs):
    def pair(name, digits):
        return f"{getattr(ours, name):,.{digits}f} / {getattr(theirs, name):,.{digits}f}"

    cells = [pair(name, digits) for name, digits in
             (("islands", 0), ("tips", 0), ("mean_mm2", 1), ("most_mm2", 1), ("far_mm2", 1), ("free_mm", 1), ("volume_mm3", 0),
              ("scars_mm2", 1), ("front_scars_mm2", 1), ("clear_mm", 2), ("gaps_mm3", 0))]  # fmt: skip
    return f"| {shape} | {turn[0]}, {turn[1]} | {' | '.join(cells)} |"


def shapes(path, size):
    """What each of both slices, in mm: points or corners, and triangles if there are any."""
    points, faces = read_ply(path)
    corners = points[:, :3].copy(), faces
    if faces is None:
        with tempfile.TemporaryDirectory(prefix="plumbline-supports-") as folder:
            corners = reconstruct(path, Path(folder))
    middle, scale = corners[0].mean(axis=0), size / np.ptp(corners[0], axis=0).max()
    points[:, :3] = (points[:, :3] - middle) * scale
    return (points, faces), ((corners[0] - middle) * scale, corners[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plumbline", type=Path)
    parser.add_argument("meshes", type=Path, nargs="+", metavar="MESH.ply")
    parser.add_argument("--size", type=float, default=25)
    parser.add_argument("--pitch", type=float, default=0.1)
    parser.add_argument("--orientations", type=int, default=len(ORIENTATIONS))
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--kept", type=Path)
    chosen = parser.parse_args()
    kept = Kept(chosen.kept)
    print("| shape | turned about x, y | islands | tips | mean, mm2 | most, mm2 | far, mm2 | free, mm | supports, mm3 "
          "| scars, mm2 | in front, mm2 | clear, mm | gaps, mm3 |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|---|", flush=True)
    panel = PANEL_MM * max(1.0, chosen.size / 25)
    pairs = []
    for path in chosen.meshes:
        (points, faces), corners = shapes(path, chosen.size)
        for turn in ORIENTATIONS[: chosen.orientations]:
            with tempfile.TemporaryDirectory(prefix="plumbline-supports-") as folder:
                work = Path(folder)
                stl, scan = work / "mesh.stl", work / "scan.ply"
                write_stl(stl, turned(corners[0], *turn), corners[1])
                if faces is None:
                    write_points(scan, np.hstack([turned(points[:, :3], *turn), turned(points[:, 3:], *turn)]))
                masks = plumbline_supports(chosen.plumbline, scan if faces is None else stl, work, chosen.pitch)
                ours = measure_supports(*masks, chosen.pitch)
                key = f"{path.stem} {turn[0]},{turn[1]}, {chosen.size} mm by {chosen.pitch} mm, {chosen.runs} runs"
                theirs = kept.get(key, lambda stl=stl, work=work: median(
                    [measure_supports(*prusa_supports(stl, work, chosen.pitch, panel), chosen.pitch) for _ in range(chosen.runs)]))  # fmt: skip
                print(row(path.stem, turn, ours, theirs), flush=True)
                pairs.append((ours, theirs))
    print_tally(pairs)


def print_tally(pairs):
    rows = len(pairs)
    for name, words in COMPARED.items():
        good = sum(getattr(ours, name) <= getattr(theirs, name) + 1e-9 for ours, theirs in pairs)
        print(f"{words}: no worse in {good} of {rows}")
    for field in fields(Figures):
        print(f"sum of {field.name}: {sum(getattr(o, field.name) for o, _ in pairs):.4g} / {sum(getattr(t, field.name) for _, t in pairs):.4g}")


if __name__ == "__main__":
    main()
