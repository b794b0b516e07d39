#!/usr/bin/env python3
"""Says which of two stacks of masks is right, by the exact sections of a closed mesh:

  mesh_sections.py MESH.stl OURS THEIRS [--every N]

OURS is a folder of plumbline's, with its manifest, THEIRS one of PNG masks. In each compared layer every triangle is cut at the layer's
middle height, in double precision; a pixel is solid if the segments on its row left of its centre don't cancel (non-zero rule).
Prints how many pixels of each stack differ from that; and where the mesh would have to lie, in pixels and layers, for THEIRS to fit best,
with the pixels that differ then in three of the layers.
Exit status: 0 done, 2 wrong use.
"""

import argparse
import functools
import json
from pathlib import Path

import numpy as np
from mesh_arrays import read_stl
from PIL import Image

FINEST_SHIFT = 0.01  # of a pixel or layer


def segments(triangles, z):
    """Where the plane at z cuts the triangles, with the solid to their left: from, to as (n, 2)."""
    above = triangles[:, :, 2] > z
    mixed = above.any(axis=1) & ~above.all(axis=1)
    cut, above = triangles[mixed], above[mixed]
    # Turned so that the lone corner, above or below the two others, is the first.
    lone_above = above.sum(axis=1) == 1
    lone = np.where(lone_above, above.argmax(axis=1), (~above).argmax(axis=1))
    order = (lone[:, None] + np.arange(3)) % 3
    a, b, c = (cut[np.arange(len(cut)), order[:, i]] for i in range(3))

    def at(p, q):
        # From the lower end, so that two triangles that share an edge are cut in the same place.
        low, high = np.where((p[:, 2] < q[:, 2])[:, None], p, q), np.where((p[:, 2] < q[:, 2])[:, None], q, p)
        share = (z - low[:, 2]) / (high[:, 2] - low[:, 2])
        return low[:, :2] + share[:, None] * (high - low)[:, :2]

    first, second = at(a, b), at(a, c)
    swap = lone_above[:, None]
    return np.where(swap, first, second), np.where(swap, second, first)


def winding(start, end, xs, ys):
    """Winding number at each place of a grid."""
    numbers = np.zeros((len(ys), len(xs) + 1), np.int32)
    up = start[:, 1] < end[:, 1]
    low, high = np.where(up[:, None], start, end), np.where(up[:, None], end, start)
    first, last = np.searchsorted(ys, low[:, 1], "left"), np.searchsorted(ys, high[:, 1], "left")
    count = last - first
    which = np.repeat(np.arange(len(count)), count)
    row = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + first[which]
    share = (ys[row] - low[which, 1]) / (high[which, 1] - low[which, 1])
    x = low[which, 0] + share * (high[which, 0] - low[which, 0])
    np.add.at(numbers, (row, np.searchsorted(xs, x, "left")), np.where(up[which], -1, 1))
    return np.cumsum(numbers, axis=1)[:, :-1]


class Stack:
    """The masks of a folder; one that is missing is black."""

    def __init__(self, folder):
        self.paths = sorted(path for path in folder.iterdir() if path.suffix == ".png")
        self.flips = (1, 1)
        self.load = functools.lru_cache(maxsize=4)(self.load)

    def load(self, k):
        return np.asarray(Image.open(self.paths[min(k, len(self.paths) - 1)]).convert("L")) >= 128

    def mask(self, k):
        return self.load(k)[:: self.flips[0], :: self.flips[1]] & (k < len(self.paths))


class Sections:
    def __init__(self, mesh, ours):
        manifest = json.loads((ours / "manifest.json").read_text())
        matrix, grid = np.array(manifest["transform"]), manifest["grid"]
        self.pitch, self.layer = np.array(grid["pixel_pitch_mm"]), grid["layer_height_mm"]
        self.triangles = read_stl(mesh.read_bytes()) @ matrix[:3, :3].T + matrix[:3, 3]
        room = 4  # pixels, for shifts
        self.low = np.maximum((self.triangles.min(axis=(0, 1))[:2] / self.pitch).astype(int) - room, 0)
        self.high = (self.triangles.max(axis=(0, 1))[:2] / self.pitch).astype(int) + room

    def differ(self, stack, layers, shift=(0, 0, 0)):
        """Pixels of a stack that differ. shift: of the mesh, in pixels and layers."""
        sum_of_all = 0
        for k in layers:
            start, end = segments(self.triangles, (k + 0.5 - shift[2]) * self.layer)
            xs, ys = ((np.arange(self.low[i], self.high[i]) + 0.5 - shift[i]) * self.pitch[i] for i in range(2))
            mask = stack.mask(k).copy()
            area = slice(self.low[1], self.high[1]), slice(self.low[0], self.high[0])
            mask[area] ^= winding(start, end, xs, ys)[: mask[area].shape[0], : mask[area].shape[1]] != 0
            sum_of_all += int(mask.sum())
        return sum_of_all

    def fit(self, stack, layers):
        """The shift at which a stack fits best, and what differs then: a search along the axes, with ever smaller steps."""
        shift, least, step = (0, 0, 0), self.differ(stack, layers), 0.4
        while step > FINEST_SHIFT and least > 0:
            tried = [tuple(s + sign * step * (i == axis) for i, s in enumerate(shift)) for axis in range(3) for sign in (1, -1)]
            best, where = min((self.differ(stack, layers, there), there) for there in tried)
            if best < least:
                least, shift = best, where
            else:
                step /= 2
        return shift, least


def compare(mesh, ours, theirs, every):
    """Pixels of both that differ, theirs at the best shift in three layers, and that shift."""
    sections, mine, other = Sections(mesh, ours), Stack(ours / "layers"), Stack(theirs)
    layers = range(0, max(len(mine.paths), len(other.paths)), every)
    few = [k * len(other.paths) // 4 for k in (1, 2, 3)]
    # A stack may be mirrored.
    ways = []
    for flips in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        other.flips = flips
        ways.append((sections.differ(other, layers), flips))
    off, other.flips = min(ways)
    shift, shifted = sections.fit(other, few)
    return sections.differ(mine, layers), off, shifted, shift


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=Path)
    parser.add_argument("ours", type=Path)
    parser.add_argument("theirs", type=Path)
    parser.add_argument("--every", type=int, default=1)
    chosen = parser.parse_args()
    ours, theirs, shifted, shift = compare(chosen.mesh, chosen.ours, chosen.theirs, chosen.every)
    print(f"pixels that differ from the exact sections: ours {ours}, theirs {theirs}; in three layers, with the mesh "
          f"({shift[0]:.2f}, {shift[1]:.2f}) pixels and {shift[2]:.2f} layers away, theirs {shifted}")  # fmt: skip


if __name__ == "__main__":
    main()
