#!/usr/bin/env python3
"""Compares the resin traps and suction cups that `plumbline check` finds with those of floods of the whole volume:

  flood_checks.py PLUMBLINE FOLDER ... [--pitch MM] [--layer-height MM]

Each folder has a stack's layers as PNG files. Two floods know nothing of each other. The first one labels the air in three dimensions: what
reaches neither a side, the top nor the plate is a trap, whatever the size of its openings. The second one has the rule of openings of ten
pixels: for every layer it joins the air of all layers up to it anew, and looks at what the next layer lets in. Prints a line for each stack, and
findings of one that the other has not.
Needs NumPy, SciPy and Pillow. Exit status: 0 all agree, 1 they differ, 2 wrong use.
"""

import argparse
import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
from PIL import Image
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

# slicer/checks/check_limits.hpp
DRAIN_PIXELS = 10
TRAP_PIXELS = 17
SUCTION_PIXELS = 100
SUCTION_HEIGHT_MM = 0.5
PLATE_SUCTION_MM2 = 25

OUTSIDE = 0


def read_stack(folder):
    """@returns white voxels (layer, row, column), with a black border of one pixel round the sides"""
    layers = [np.asarray(Image.open(path).convert("L")) > 127 for path in sorted(folder.glob("*.png"))]
    used = np.logical_or.reduce(layers)
    rows, columns = np.flatnonzero(used.any(axis=1)), np.flatnonzero(used.any(axis=0))
    box = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
    return np.stack([np.pad(layer[box], 1) for layer in layers])


def enclosed_volumes(white):
    """Air that nothing but walls surrounds, each as (first layer, last layer, pixels of its largest layer, voxels)."""
    labels, count = ndimage.label(~white)
    reach_out = set(np.unique(labels[0])) | set(np.unique(labels[-1])) | set(np.unique(labels[:, 0])) | {0}
    found = []
    for i, box in enumerate(ndimage.find_objects(labels), 1):
        if i not in reach_out:
            area = (labels[box] == i).sum(axis=(1, 2))
            found.append((box[0].start, box[0].stop - 1, int(area.max()), int(area.sum())))
    return found


class AirRegions:
    """The air of each layer in regions joined at sides, numbered through the stack; and how they touch."""

    def __init__(self, white):
        self.layer, self.pixels = [0], [1 << 62]  # OUTSIDE
        self.contacts = [[] for _ in white]  # of a layer with the one below: (region above, region below, pixels)
        below = None
        for k, layer in enumerate(white):
            labels, count = ndimage.label(~layer)
            numbers = np.full(count + 1, -1)
            for i, pixels in enumerate(np.bincount(labels.ravel(), minlength=count + 1)[1:], 1):
                if i == labels[0, 0]:
                    numbers[i] = OUTSIDE
                    continue
                numbers[i] = len(self.layer)
                self.layer.append(k)
                self.pixels.append(int(pixels))
            now = numbers[labels]
            if below is not None:
                both = (now >= 0) & (below >= 0) & (now != below)
                pairs = Counter(zip(now[both].tolist(), below[both].tolist()))
                self.contacts[k] = sorted((above, under, pixels) for (above, under), pixels in pairs.items())
            below = now
        self.layer, self.pixels = np.array(self.layer), np.array(self.pixels)


def joined(regions, top):
    """Components of the air of layers up to `top`, by region."""
    count = int(np.searchsorted(regions.layer, top, side="right"))
    joints = [contact for contacts in regions.contacts[: top + 1] for contact in contacts]
    wide = [(above, below) for above, below, pixels in joints if pixels >= DRAIN_PIXELS]
    a, b = np.array(wide, dtype=int).reshape(-1, 2).T
    component = connected_components(coo_matrix((np.ones(len(a)), (a, b)), shape=(count, count)), directed=False)[1]
    # The narrow end of a hollow belongs to it: what has no region of ten pixels is joined by any opening.
    largest = np.zeros(component.max() + 1, dtype=np.int64)
    np.maximum.at(largest, component, regions.pixels[:count])
    for above, below, pixels in joints:
        one, other = component[above], component[below]
        if pixels < DRAIN_PIXELS and one != other and min(largest[one], largest[other]) < DRAIN_PIXELS:
            component[component == other] = one
            largest[one] = max(largest[one], largest[other])
    return component


def find_hollows(white, pitch_mm, layer_mm):
    """@returns traps and cups, each as (first layer, last layer, pixels of its largest region, voxels)"""
    regions = AirRegions(white)
    traps, cups = [], []

    def figures(members):
        layers, pixels = regions.layer[members], regions.pixels[members]
        return int(layers.min()), int(layers.max()), int(pixels.max()), int(pixels.sum())

    def end(members, opens):
        first, last, largest, voxels = figures(members)
        on_plate = first == 0
        if not opens and not on_plate:
            if largest >= TRAP_PIXELS:
                traps.append((first, last, largest, voxels))
            return
        broad = regions.layer[members][regions.pixels[members] >= SUCTION_PIXELS]
        if len(broad) == 0 or (on_plate and largest * pitch_mm**2 < PLATE_SUCTION_MM2):
            return
        if (broad.max() - broad.min() + 1) * layer_mm >= SUCTION_HEIGHT_MM * (1 - 1e-6):
            cups.append((first, last, largest, voxels))

    before = None
    for k in range(len(white)):
        component = joined(regions, k)
        if before is not None:
            for c in np.unique(before[regions.layer[: len(before)] == k - 1]):
                members = np.flatnonzero(before == c)
                if c == before[OUTSIDE]:
                    continue
                after = component[members[0]]
                if after == component[OUTSIDE]:
                    end(members, True)
                elif not (regions.layer[: len(component)][component == after] == k).any():
                    end(members, False)
        before = component
    for c in np.unique(before[regions.layer[: len(before)] == len(white) - 1]):
        if c != before[OUTSIDE]:
            end(np.flatnonzero(before == c), True)
    return traps, cups


def checked(plumbline, folder, pitch_mm, layer_mm):
    """@returns by kind: how many, and the largest as above"""
    words = (plumbline, "check", folder, "--pixel-pitch", pitch_mm, "--layer-height", layer_mm, "--json")
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(done.stderr)
    kinds = json.loads(done.stdout)["issues"]["kinds"]
    # As single precision has them.
    voxel_ml = float(np.float32(pitch_mm)) ** 2 * float(np.float32(layer_mm)) / 1000

    def tuples(kind):
        issues = kinds.get(kind, {"count": 0, "largest": []})
        largest = [(i["first_layer"], i["last_layer"], i["pixels"], round(i["volume_ml"] / voxel_ml)) for i in issues["largest"]]
        return issues["count"], largest

    return tuples("resin_trap"), tuples("suction_cup")


def compare(plumbline, folder, pitch_mm, layer_mm):
    """@returns whether all agree"""
    white = read_stack(folder)
    traps, cups = find_hollows(white, pitch_mm, layer_mm)
    (trap_count, largest_traps), (cup_count, largest_cups) = checked(plumbline, folder, pitch_mm, layer_mm)
    enclosed = [e for e in enclosed_volumes(white) if e[2] >= TRAP_PIXELS]
    agree = True
    for kind, count, largest, found in (("trap", trap_count, largest_traps, traps), ("cup", cup_count, largest_cups, cups)):
        extra = Counter(largest) - Counter(found)
        missing = Counter(found) - Counter(largest) if count <= len(largest) else Counter()
        if extra or missing or count != len(found):
            agree = False
            print(f"  {kind}: only plumbline {sorted(extra)}, only the flood {sorted(missing)}")
    # A trap that the plain flood does not find has openings, all of them below the rule's limit.
    narrow = sum((Counter(traps) - Counter(enclosed)).values())
    print(f"{folder}: {len(white)} layers, traps {trap_count} / {len(traps)}, cups {cup_count} / {len(cups)}; "
          f"the plain flood has {len(enclosed)} traps, {narrow} of the traps are not among them", flush=True)  # fmt: skip
    return agree


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plumbline", type=Path)
    parser.add_argument("folders", type=Path, nargs="+", metavar="FOLDER")
    parser.add_argument("--pitch", type=float, default=0.05)
    parser.add_argument("--layer-height", type=float, default=0.05)
    chosen = parser.parse_args()
    for folder in chosen.folders:
        if not any(folder.glob("*.png")):
            parser.error(f"no layers in {folder}")
    agreed = [compare(chosen.plumbline.resolve(), folder, chosen.pitch, chosen.layer_height) for folder in chosen.folders]
    sys.exit(0 if all(agreed) else 1)


if __name__ == "__main__":
    main()
