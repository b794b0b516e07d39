#!/usr/bin/env python3
"""Compares plumbline with the usual way over a mesh, on the same scans and in one run:

  compare_peers.py PLUMBLINE [SCAN.ply ...] [--points N] [--depth D] [--repeat N]

The usual way is Poisson reconstruction (pcl_poisson_reconstruction of the Point Cloud Library, depth 9), then PrusaSlicer's export for
resin printers. Both make a mask of 0.05 mm pixels for every 0.05 mm, without supports, on one core. Without a scan, both slice what
`plumbline sample` writes, --points of them (300,000). A scan must be a PLY file with normals, in mm.
Prints a table in Markdown: the median of --repeat runs (1). CPU seconds are those of the programs; converting files from one to the
other is not counted, nor is removing the loose pieces of the mesh. The volumes show that both made the same object. Needs
.ci/setup bench.
Exit status: 0 done, 1 a program failed, 2 wrong use.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from measured_run import Cost, measure, stay_on_one_core

PITCH = 0.05  # mm, pixels and layers
PEERS = ("pcl_ply2pcd", "pcl_poisson_reconstruction", "prusa-slicer")


def slice_with_plumbline(plumbline, scan, work):
    out = work / "out"
    cost = measure([plumbline, "slice", scan, "-o", out, "--pixel-pitch", PITCH, "--layer-height", PITCH, "--no-preview", "--threads", 1])
    manifest = json.loads((out / "manifest.json").read_text())
    return cost, manifest


def reconstruct(scan, work, depth):
    """Poisson's cost, and the volume of its mesh, which becomes mesh.stl."""
    cloud, mesh = work / "scan.pcd", work / "mesh.vtk"
    measure(["pcl_ply2pcd", scan, cloud])
    cost = measure(["pcl_poisson_reconstruction", cloud, mesh, "-depth", depth])
    # In a process of its own: a child of a large process would seem to be as large until it has become another program.
    done = subprocess.run(
        [sys.executable, "-B", Path(__file__).with_name("vtk_to_stl.py"), mesh, work / "mesh.stl"],
        capture_output=True, text=True, check=False,
    )
    if done.returncode != 0:
        sys.exit(f"the mesh of {scan} can't be converted:\n{done.stderr}")
    return cost, float(done.stdout)


def slice_mesh(work, grid):
    """PrusaSlicer's cost and layers, for a panel with the pixels of plumbline's grid and a margin for what Poisson adds."""
    archive = work / "mesh.sl1"
    columns, rows = ((grid[axis] + 399) // 200 * 200 for axis in ("columns", "rows"))
    width, height = columns * PITCH, rows * PITCH
    cost = measure([
        "prusa-slicer", "--export-sla", work / "mesh.stl", "--output", archive, "--printer-technology", "SLA",
        "--layer-height", PITCH, "--initial-layer-height", PITCH, "--supports-enable=0", "--pad-enable=0",
        "--display-orientation", "landscape", "--display-width", width, "--display-height", height,
        "--display-pixels-x", columns, "--display-pixels-y", rows, "--max-print-height", 1000,
        "--bed-shape", f"0x0,{width}x0,{width}x{height},0x{height}", "--center", f"{width / 2},{height / 2}",
    ])  # fmt: skip
    with zipfile.ZipFile(archive) as masks:
        return cost, sum(name.endswith(".png") and "/" not in name for name in masks.namelist())


def median(costs):
    return Cost(*(sorted(values)[len(values) // 2] for values in zip(*costs)))


def row(scan, points, program, cost, layers, volume):
    count = f"{layers}" if layers else ""
    size = f"{volume:,.0f}" if volume else ""
    return f"| {scan} | {points:,} | {program} | {cost.cpu_s:.1f} | {cost.peak_mib:.0f} | {count} | {size} |"


def compare(plumbline, scan, depth, repeat, work):
    ours, poisson, slicing = [], [], []
    for _ in range(repeat):
        cost, manifest = slice_with_plumbline(plumbline, scan, work)
        ours.append(cost)
        if not manifest["scan"]["has_normals"]:
            sys.exit(f"{scan} has no normals, which Poisson reconstruction needs: give a scan with nx, ny, nz")
        cost, volume = reconstruct(scan, work, depth)
        poisson.append(cost)
        cost, layers = slice_mesh(work, manifest["grid"])
        slicing.append(cost)
    name, points = scan.stem, manifest["scan"]["points"]
    ours, poisson, slicing = map(median, (ours, poisson, slicing))
    peers = poisson + slicing
    print(row(name, points, "plumbline", ours, manifest["grid"]["layers"], manifest["volume_mm3"]))
    print(row(name, points, f"Poisson, depth {depth}", poisson, None, volume))
    print(row(name, points, "PrusaSlicer", slicing, layers, None))
    print(row(name, points, "both", peers, layers, volume))
    print(f"| {name} | {points:,} | **plumbline / both** | **{ours.cpu_s / peers.cpu_s:.2f}** | "
          f"**{ours.peak_mib / peers.peak_mib:.2f}** | | |", flush=True)  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plumbline", type=Path)
    parser.add_argument("scans", type=Path, nargs="*", metavar="SCAN.ply")
    parser.add_argument("--points", type=int, default=300_000)
    parser.add_argument("--depth", type=int, default=9)
    parser.add_argument("--repeat", type=int, default=1)
    chosen = parser.parse_args()
    missing = [program for program in PEERS if shutil.which(program) is None]
    if missing:
        sys.exit(f"{', '.join(missing)}: not found. Run .ci/setup bench")
    stay_on_one_core()
    print("| scan | points | program | CPU s | peak MiB | layers | volume mm3 |\n|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory(prefix="plumbline-peers-") as folder:
        work = Path(folder)
        scans = chosen.scans
        if not scans:
            scans = [work / "sample.ply"]
            measure([chosen.plumbline, "sample", scans[0], "--points", chosen.points, "--quiet"])
        for scan in scans:
            compare(chosen.plumbline, scan, chosen.depth, chosen.repeat, work)


if __name__ == "__main__":
    main()
