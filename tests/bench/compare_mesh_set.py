#!/usr/bin/env python3
"""Compares plumbline with PrusaSlicer on a folder of meshes, and on damaged copies of them:

  compare_mesh_set.py PLUMBLINE MASK_DIFFERENCE FOLDER [--longest MM] [--every N] [--most TRIANGLES] [--first N]

Reads the STL, OBJ, OFF and PLY files of a folder, scales each to --longest and slices it with both, as compare_meshes.py does. Of a
mesh that is closed a damaged copy is made, of three kinds in turn: a thirtieth of the triangles is missing, a thirtieth is turned
over, a fiftieth is there twice. What both make of the copy is compared with what they make of the undamaged mesh.
Where a hundredth of a percent of a closed mesh's pixels differ or more, mesh_sections.py tells which of the two is right.
Prints a line a mesh and sums up: pixels that differ, CPU seconds, peak memory. Needs .ci/setup bench, and mask_difference of a build
with PLUMBLINE_BENCHMARKS.
Exit status: 0 done, 2 wrong use.
"""

import argparse
import hashlib
import json
import multiprocessing
import shutil
import statistics
import tempfile
from pathlib import Path

from compare_meshes import LAYER, TRAVEL, WIDTH, differences, slice_with_plumbline, slice_with_prusa
from measured_run import stay_on_one_core

ASKED = 1e-4  # of the pixels may differ
DAMAGES = {"missing": 30, "turned over": 30, "doubled": 50}  # one triangle in so many


def prepare(*arguments):
    """mesh_arrays.prepare() in a process of its own: a child of a large process would seem to be as large until it has become
    another program.

    Returns why the mesh is left out, or None."""

    def run(pipe):
        import mesh_arrays

        try:
            pipe.send(mesh_arrays.prepare(*arguments))
        except mesh_arrays.UnfitMesh as error:
            pipe.send(str(error))

    mine, theirs = multiprocessing.Pipe()
    maker = multiprocessing.Process(target=run, args=(theirs,))
    maker.start()
    theirs.close()
    try:
        return mine.recv()
    except EOFError:
        return "could not be prepared"
    finally:
        maker.join()


def judge(pipe, *arguments):
    import mesh_sections

    pipe.send(mesh_sections.compare(*arguments))


def who_is_right(*arguments):
    """mesh_sections.compare() in a process of its own, as prepare()."""
    mine, theirs = multiprocessing.Pipe()
    judging = multiprocessing.Process(target=judge, args=(theirs, *arguments))
    judging.start()
    theirs.close()
    try:
        return mine.recv()
    finally:
        judging.join()


class Bench:
    def __init__(self, chosen, work):
        self.chosen, self.work = chosen, work
        self.mesh, self.copy = work / "mesh.stl", work / "copy.stl"

    def slice(self, mesh):
        ours, _ = slice_with_plumbline(self.chosen.plumbline, mesh, self.work)
        theirs, masks = slice_with_prusa(mesh, self.work)
        return ours, theirs, self.work / "ours" / "layers", masks

    def differ(self, a, b):
        found = differences(self.chosen.mask_difference, a, b, self.chosen.every)
        return found["differ"], found

    def compare(self, name, kind):
        ours, theirs, our_masks, their_masks = self.slice(self.mesh)
        mesh = json.loads((self.work / "ours" / "manifest.json").read_text())["mesh"]
        closed, triangles = mesh["closed"], mesh["triangles"]
        differ, found = self.differ(our_masks, their_masks)
        line = {"name": name, "closed": closed, "ours": ours, "theirs": theirs, "pixels": found["pixels"],
                "cured": found["cured"], "differ": differ, "far": found["far"]}  # fmt: skip
        print(f"{name}: {triangles} triangles, {'closed' if closed else 'open'}, {ours.cpu_s:.2f} s {ours.peak_mib:.0f} MiB, PrusaSlicer "
              f"{theirs.cpu_s:.2f} s {theirs.peak_mib:.0f} MiB; differ {100 * differ / found['pixels']:.4f} % of the pixels", flush=True)  # fmt: skip
        if not closed:
            return line
        if differ >= ASKED * found["pixels"]:
            ours_off, theirs_off, shifted, shift = who_is_right(self.mesh, self.work / "ours", their_masks, self.chosen.every)
            line["exact"] = ours_off, theirs_off
            print(f"  off the exact sections: ours {ours_off}, PrusaSlicer's {theirs_off} pixels; in three layers {shifted} of its pixels, if the "
                  f"mesh lay ({shift[0]:.2f}, {shift[1]:.2f}) pixels and {shift[2]:.2f} layers away", flush=True)  # fmt: skip
        whole = self.work / "whole"
        shutil.rmtree(whole, ignore_errors=True)
        shutil.move(our_masks, whole)
        ours, theirs, our_masks, their_masks = self.slice(self.copy)
        line["damaged"] = {"kind": kind, "ours": ours, "theirs": theirs, "our_off": self.differ(whole, our_masks)[0],
                           "their_off": self.differ(whole, their_masks)[0]}  # fmt: skip
        print(f"  {kind}: {ours.cpu_s:.2f} s, off {line['damaged']['our_off']}; PrusaSlicer {theirs.cpu_s:.2f} s, off "
              f"{line['damaged']['their_off']} pixels", flush=True)  # fmt: skip
        return line


def sum_up(lines):
    def costs(name, pairs):
        if pairs:
            cpu = statistics.median(a.cpu_s / b.cpu_s for a, b in pairs)
            peak = statistics.median(a.peak_mib / b.peak_mib for a, b in pairs)
            print(f"{name}: {len(pairs)}; median of ours / PrusaSlicer's: CPU {cpu:.3f}, memory {peak:.3f}; slowest {max(a.cpu_s for a, _ in pairs):.1f} s, "
                  f"theirs {max(b.cpu_s for _, b in pairs):.1f} s; in all {sum(a.cpu_s for a, _ in pairs):.0f} and {sum(b.cpu_s for _, b in pairs):.0f} s")  # fmt: skip

    closed = [line for line in lines if line["closed"]]
    costs("closed", [(line["ours"], line["theirs"]) for line in closed])
    shares = sorted(line["differ"] / line["pixels"] for line in closed)
    if shares:
        print(f"  below 0.01 % of the pixels differ: {sum(share < ASKED for share in shares)} of {len(shares)}; most {100 * shares[-1]:.4f} %")
        exact = [line["exact"] for line in closed if "exact" in line]
        print(f"  pixels off the exact sections in the others: ours {sum(a for a, _ in exact)}, theirs {sum(b for _, b in exact)}")
    costs("open as they are", [(line["ours"], line["theirs"]) for line in lines if not line["closed"]])
    for kind in DAMAGES:
        copies = [line["damaged"] for line in closed if line["damaged"]["kind"] == kind]
        costs(f"damaged copies, {kind}", [(copy["ours"], copy["theirs"]) for copy in copies])
        if copies:
            better = sum(copy["our_off"] <= copy["their_off"] for copy in copies)
            print(f"  ours at least as near to the undamaged mesh in {better} of {len(copies)}; pixels off in all: {sum(copy['our_off'] for copy in copies)}, "
                  f"theirs {sum(copy['their_off'] for copy in copies)}")  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plumbline", type=Path)
    parser.add_argument("mask_difference", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--longest", type=float, default=30.0, help="mm")
    parser.add_argument("--every", type=int, default=4, help="compare every Nth layer only")
    parser.add_argument("--most", type=int, default=500000, help="triangles of a mesh; larger ones are left out")
    parser.add_argument("--first", type=int, default=10**9, help="compare the first N meshes only")
    chosen = parser.parse_args()
    if not 0 < chosen.longest <= min(WIDTH, TRAVEL):
        parser.error(f"--longest must be above 0 and at most {min(WIDTH, TRAVEL)} mm")
    stay_on_one_core()
    print(f"layers of {LAYER} mm, longest side {chosen.longest} mm, every {chosen.every}. layer compared", flush=True)
    lines, seen = [], set()
    with tempfile.TemporaryDirectory(prefix="plumbline-meshes-") as folder:
        bench = Bench(chosen, Path(folder))
        for path in sorted(chosen.folder.iterdir()):
            if path.suffix.lower() not in (".stl", ".obj", ".off", ".ply") or len(lines) >= chosen.first:
                continue
            kind, one_in = list(DAMAGES.items())[len(lines) % len(DAMAGES)]
            reason = prepare(path, chosen.longest, LAYER, chosen.most, kind, one_in, bench.mesh, bench.copy)
            digest = hashlib.sha256(bench.mesh.read_bytes()).digest() if reason is None else None
            if reason or digest in seen:
                print(f"{path.name}: left out: {reason or 'as one before'}", flush=True)
                continue
            seen.add(digest)
            try:
                lines.append(bench.compare(path.name, kind))
            except SystemExit as failure:
                print(f"{path.name}: left out: {str(failure)[-300:]}", flush=True)
    sum_up(lines)


if __name__ == "__main__":
    main()
