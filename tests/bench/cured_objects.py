"""Meshes whose surfaces are known by formula, for measuring what a print cures: sphere, tilted planes, holes, pins, a thin wall, a shelf.

Each is binary STL, mm, closed, with all faces outwards.
"""

import numpy as np


def write_stl(path, triangles):
    """triangles: (n, 3, 3) mm."""
    records = np.zeros(len(triangles), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")]))
    records["corners"] = triangles
    with open(path, "wb") as file:
        file.write(bytes(80) + np.uint32(len(triangles)).tobytes() + records.tobytes())


def prism(outline, y0, y1):
    """A convex outline in x and z, counter-clockwise as seen from -y, drawn out along y."""
    outline = np.asarray(outline, float)
    n = len(outline)
    front, back = (np.column_stack([outline[:, 0], np.full(n, y), outline[:, 1]]) for y in (y0, y1))
    triangles = []
    for i in range(1, n - 1):
        triangles += [(front[0], front[i], front[i + 1]), (back[0], back[i + 1], back[i])]
    for i in range(n):
        j = (i + 1) % n
        triangles += [(front[i], back[j], front[j]), (front[i], back[i], back[j])]
    return np.array(triangles)


def sphere(radius=2.0, rings=160):
    theta, phi = np.meshgrid(np.arange(rings + 1) * np.pi / rings, np.arange(2 * rings) * np.pi / rings, indexing="ij")
    at = radius * np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), -np.cos(theta)], -1)
    at[0], at[-1] = (0, 0, -radius), (0, 0, radius)
    beside = np.roll(at, -1, axis=1)
    a, b, c, d = at[:-1], at[1:], beside[1:], beside[:-1]
    first, second = np.stack([a, c, b], -2)[:-1], np.stack([a, d, c], -2)[1:]
    return np.concatenate([first.reshape(-1, 3, 3), second.reshape(-1, 3, 3)])


def tilted_slab(degrees, length=4.0, thick=2.0, deep=3.0):
    """A plate of which two sides are tilted by this much to the plate: one faces up, one down."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    corners = [(0, 0), (length * c, length * s), (length * c - thick * s, length * s + thick * c), (-thick * s, thick * c)]
    return prism(corners, 0, deep)


def ring_plate(hole, size=6.0, thick=3.0, upright=False, steps=256):
    """A square plate with a round hole, upright (its axis along z) or lying (along y)."""
    angles = np.arange(steps) * 2 * np.pi / steps
    inner = hole * np.column_stack([np.cos(angles), np.sin(angles)])
    outer = inner / np.abs(inner).max(axis=1, keepdims=True) * size / 2
    triangles = []
    for i in range(steps):
        j = (i + 1) % steps
        a, b, c, d = inner[i], inner[j], outer[j], outer[i]
        lo = [np.array([p[0], 0.0, p[1]]) for p in (a, b, c, d)]
        hi = [p + np.array([0, thick, 0]) for p in lo]
        for p, q, r, s, turned in ((lo[0], lo[1], lo[2], lo[3], False), (hi[0], hi[1], hi[2], hi[3], True),
                                   (lo[0], hi[0], hi[1], lo[1], False), (lo[3], lo[2], hi[2], hi[3], False)):
            for t in ((p, q, r), (p, r, s)):
                triangles.append(t[::-1] if not turned else t)
    triangles = np.array(triangles)
    return triangles[:, :, [0, 2, 1]][:, ::-1] if upright else triangles


def pin(radius=1.5, height=4.0, steps=256):
    angles = np.arange(steps) * 2 * np.pi / steps
    outline = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return prism(outline, 0, height)[:, :, [0, 2, 1]][:, ::-1]


def box(x0, x1, y0, y1, z0, z1):
    return prism([(x0, z0), (x1, z0), (x1, z1), (x0, z1)], y0, y1)


def shelf(thick=0.3):
    """A plate of this thickness that stands out from a wall; one closed outline of eight corners."""
    upper, lower = box(0, 4, 0, 3, 2, 2 + thick), box(0, 1, 0, 3, 0, 4)
    return np.concatenate([lower, upper])


def objects():
    """Name and triangles of each."""
    yield "sphere r 2", sphere()
    for degrees in (5, 15, 30, 45, 60, 75, 85):
        yield f"plane {degrees}", tilted_slab(degrees)
    yield "lying hole r 1", ring_plate(1.0)
    yield "hole r 1.5", ring_plate(1.5, upright=True)
    yield "pin r 1.5", pin()
    yield "wall .4", box(0, 0.4, 0, 5, 0, 4)
    yield "shelf .3", shelf()
