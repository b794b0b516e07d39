#!/usr/bin/env python3
"""Converts the mesh of pcl_poisson_reconstruction for PrusaSlicer: vtk_to_stl.py MESH.vtk MESH.stl

Reads a legacy ASCII VTK file of triangles and writes the largest piece of the mesh as a binary STL. The others are what the
reconstruction made of outliers; users remove them by hand. Prints the volume that the piece encloses, mm3.
"""

import struct
import sys
from collections import Counter
from itertools import islice


def numbers(lines, count, kind):
    found = []
    while len(found) < count:
        found.extend(map(kind, next(lines).split()))
    if len(found) != count:
        raise ValueError(f"{len(found)} numbers where {count} were announced")
    return found


def read(path):
    """Points (x, y, z) and triangles (three indices of points)."""
    points, triangles = [], []
    with open(path, encoding="ascii") as lines:
        if "ASCII" not in [line.strip() for line in islice(lines, 3)]:
            raise ValueError("not an ASCII file of the legacy format")
        for line in lines:
            words = line.split()
            if words and words[0] == "POINTS":
                flat = iter(numbers(lines, 3 * int(words[1]), float))
                points = list(zip(flat, flat, flat))
            elif words and words[0] in ("POLYGONS", "VERTICES"):
                flat = numbers(lines, int(words[2]), int)
                if words[0] == "POLYGONS":
                    if len(flat) != 4 * int(words[1]):
                        raise ValueError("the mesh has polygons that are no triangles")
                    triangles = list(zip(flat[1::4], flat[2::4], flat[3::4]))
    if not triangles:
        raise ValueError("the mesh has no triangles")
    return points, triangles


def largest_piece(points, triangles):
    """The triangles of the piece that has most points."""
    joined_to = list(range(len(points)))

    def root(i):
        while joined_to[i] != i:
            joined_to[i] = joined_to[joined_to[i]]
            i = joined_to[i]
        return i

    for a, b, c in triangles:
        joined_to[root(a)] = root(b)
        joined_to[root(b)] = root(c)
    largest = Counter(map(root, range(len(points)))).most_common(1)[0][0]
    return [triangle for triangle in triangles if root(triangle[0]) == largest]


def main(source, target):
    points, triangles = read(source)
    triangles = largest_piece(points, triangles)
    volume = 0.0
    with open(target, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", len(triangles)))
        for corners in triangles:
            a, b, c = (points[corner] for corner in corners)
            # The normal may be left out: readers compute it from the order of the corners.
            file.write(struct.pack("<12fH", 0, 0, 0, *a, *b, *c, 0))
            volume += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    print(f"{volume / 6:.1f}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
