"""UVtools' rules for islands, overhangs, resin traps and suction cups, with the same operations of OpenCV that its IssueManager uses
(version 6, settings of its command line). An oracle for slicer/checks: written from UVtools' description of what it looks for, with
contours and a sweep in both directions where plumbline has regions and one sweep."""

from dataclasses import dataclass, field

import cv2
import numpy as np

PLUS = cv2.MORPH_CROSS


@dataclass
class Rules:
    island_white: int = 1  # brighter pixels belong to a region
    island_pixel: int = 10  # pixels of a region that count
    holding_pixel: int = 150  # pixels below that hold
    held_share: float = 0.25
    erode: int = 40
    trap_white: int = 100
    trap_area: float = 4
    drain_pixels: int = 10
    drain_white: int = 30
    cup_area: float = 100
    cup_mm: float = 0.5


@dataclass
class Found:
    islands: list = field(default_factory=list)  # (layer, pixels)
    overhangs: list = field(default_factory=list)  # (layer, area)
    traps: list = field(default_factory=list)  # (first layer, last layer, area of all layers)
    cups: list = field(default_factory=list)


def box_of(mask):
    """Rows and columns with white pixels, as slices; none if it is black."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)) if len(rows) else None


def groups_of(white, of_holes):
    """Contours with all contours within, each with their net area: of the outermost regions, or of the holes in those."""
    contours, tree = cv2.findContours(white, cv2.RETR_TREE, cv2.CHAIN_APPROX_SIMPLE)
    found = {}
    for i in range(len(contours)):
        chain = [i]
        while tree[0][chain[-1]][3] != -1:
            chain.append(tree[0][chain[-1]][3])
        if of_holes and len(chain) < 2:
            continue
        found.setdefault(chain[-2] if of_holes else chain[-1], []).append(contours[i])
    for group in found.values():
        group.sort(key=cv2.contourArea, reverse=True)
    return [(group, cv2.contourArea(group[0]) - sum(map(cv2.contourArea, group[1:]))) for group in found.values()]


def filled(group, shape):
    return cv2.drawContours(np.zeros(shape, np.uint8), group, -1, 255, -1)


def overhangs_of(layer, below, rules):
    """New pixels that remain when they are eroded by a plus, and their groups with an area of a pixel or more."""
    fresh = cv2.threshold(cv2.subtract(layer, below), 127, 255, cv2.THRESH_BINARY)[1]
    size = 2 * rules.erode + 1
    left = cv2.erode(fresh, cv2.getStructuringElement(PLUS, (size, size)), borderType=cv2.BORDER_DEFAULT)
    return left, [(g, area) for g, area in groups_of(left, False) if len(g[0]) >= 3 and area >= 1]


def find_regions(index, layer, below, rules, found):
    box = box_of(np.maximum(layer, below))
    if box is None or not layer.any():
        return
    layer, below = np.ascontiguousarray(layer[box]), np.ascontiguousarray(below[box])
    left, overhangs = overhangs_of(layer, below, rules)
    found.overhangs += [(index, area) for _, area in overhangs]
    count, labels = cv2.connectedComponents((layer > rules.island_white).astype(np.uint8), connectivity=4)
    counted = labels[layer >= rules.island_pixel]
    pixels = np.bincount(counted, minlength=count)
    held = np.bincount(labels[(layer >= rules.island_pixel) & (below >= rules.holding_pixel)], minlength=count)
    hanging = np.bincount(labels[left > 0], minlength=count)
    for i in range(1, count):
        needed = max(1, pixels[i] * rules.held_share)
        if pixels[i] == 0 or held[i] >= needed:
            continue
        if held[i] >= 10 and held[i] >= needed / 4 and (not overhangs or hanging[i] == 0):
            continue
        found.islands.append((index, int(pixels[i])))


def overlap(a, b, shape):
    boxes = [cv2.boundingRect(group[0]) for group in (a, b)]
    (ax, ay, aw, ah), (bx, by, bw, bh) = boxes
    if ax + aw <= bx or bx + bw <= ax or ay + ah <= by or by + bh <= ay:
        return False
    return bool((filled(a, shape) & filled(b, shape)).any())


def columns_of(by_layer, shape):
    """Groups of contours that overlap from layer to layer, top down."""
    columns = []
    for index in sorted(by_layer, reverse=True):
        for group, area in by_layer[index]:
            near = [c for c in columns if c[-1][0] in (index, index + 1) and overlap(group, c[-1][1], shape)]
            columns = [c for c in columns if not any(c is other for other in near)]
            columns.append([entry for c in near for entry in c] + [(index, group, area)])
    return columns


def find_hollows(layers, layer_mm, rules, found):
    shape = layers[0].shape
    holes, outside = [], []
    for layer in layers:
        white = (layer > rules.trap_white).astype(np.uint8)
        holes.append([h for h in groups_of(white, True) if h[1] >= rules.trap_area])
        outer = [group[0] for group, _ in groups_of(white, False)]
        outside.append(cv2.bitwise_not(np.maximum(filled(outer, shape), np.where(layer > rules.drain_white, 255, 0).astype(np.uint8))))
    solid = [np.where(layer > rules.drain_white, 255, 0).astype(np.uint8) for layer in layers]
    traps, opened = {}, {}
    air = outside[0]
    for i in range(len(layers)):
        air = cv2.subtract(air, solid[i]) | outside[i]
        for hole in holes[i]:
            mask = filled(hole[0], shape)
            common = cv2.countNonZero(air & mask)
            if common == 0:
                traps.setdefault(i, []).append(hole)
            elif common >= rules.drain_pixels:
                opened.setdefault(i, []).append(hole)
                air = air | mask
            else:
                air = cv2.subtract(air, mask)
    cups, waiting = {}, []
    air = cv2.bitwise_not(solid[-1])
    for i in reversed(range(len(layers))):
        known = outside[i]
        for hole in opened.get(i, []):
            known = known | filled(hole[0], shape)
        air = cv2.subtract(air, solid[i]) | known
        kept = []
        for hole in traps.get(i, []):
            mask = filled(hole[0], shape)
            if cv2.countNonZero(air & mask) >= rules.drain_pixels:
                air = air | mask
                cups.setdefault(i, []).append(hole)
                for column in [c for c in waiting if any(k <= i + 1 and overlap(g, hole[0], shape) for k, g, _ in c)]:
                    waiting = [c for c in waiting if c is not column]
                    for k, group, area in column:
                        cups.setdefault(k, []).append((group, area))
                        if k != i:
                            traps[k] = [t for t in traps[k] if t[0] is not group]
                continue
            air = cv2.subtract(air, mask)
            kept.append(hole)
            near = [c for c in waiting if c[-1][0] in (i, i + 1) and overlap(hole[0], c[-1][1], shape)]
            waiting = [c for c in waiting if not any(c is other for other in near)]
            waiting.append([entry for c in near for entry in c] + [(i, *hole)])
        if i in traps:
            traps[i] = [t for t in kept if not any(t[0] is c[0] for c in cups.get(i, []))]

    def sized(column):
        return (min(k for k, *_ in column), max(k for k, *_ in column), sum(area for *_, area in column))

    found.traps += [sized(c) for c in columns_of(traps, shape) if all(k > 0 for k, *_ in c)]
    large = {k: [hole for hole in holes_here if hole[1] >= rules.cup_area] for k, holes_here in cups.items()}
    for column in columns_of(large, shape):
        first, last, area = sized(column)
        if (last - first + 1) * layer_mm >= rules.cup_mm - 1e-9:
            found.cups.append((first, last, area))


def find_issues(layers, layer_mm, rules=None):
    """@param layers  grey images of a stack, from the plate up, 8 bits"""
    rules = rules or Rules()
    found = Found()
    box = box_of(np.max(layers, axis=0))
    for index in range(1, len(layers)):
        find_regions(index, layers[index], layers[index - 1], rules, found)
    # UVtools looks at the box round all layers. A border of black changes nothing and keeps contours off the edge.
    cropped = [np.pad(layer[box], 1) for layer in layers]
    find_hollows(cropped, layer_mm, rules, found)
    return found
