"""Measures supports on masks alone, whoever made them: islands, tips and what each carries, scars, distance from walls, room for a cutter, free pillars,
volume."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

HANGS_MM = 3  # an overhang hangs from tips up to this far below it
PILLAR_MM2 = 4  # a larger region is no pillar
TIP_MM = 2  # round a place where a support touches the object it may be near it
TOUCH_MM = 1  # a higher place is no tip: the support runs along a wall
CLEAR_MM = 1
GAP_MM = 1
UPRIGHT = 0.2  # pixels by which the middle of a pillar moves from layer to layer, at most


@dataclass
class Figures:
    islands: int  # regions of a layer with nothing below
    tips: int
    mean_mm2: float  # overhang area nearest to one tip
    most_mm2: float
    far_mm2: float  # overhang with no tip within HANGS_MM
    free_mm: float  # longest stretch of a pillar that nothing touches
    volume_mm3: float  # of all that is not the object
    scars_mm2: float  # sides of voxels at which supports and object touch
    front_scars_mm2: float  # of these, what the worst of three front views sees
    clear_mm: float  # least distance of a support from the object farther than TIP_MM from where it touches it; CLEAR_MM at most
    gaps_mm3: float  # between supports, narrower than GAP_MM


def islands_of(masks):
    count = 0
    for below, mask in zip(masks, masks[1:]):
        labels, regions = ndimage.label(mask)
        held = np.unique(labels[below & mask])
        count += regions - np.count_nonzero(held)
    return count


def tips_of(thing, supports):
    """Middles of the places where supports touch the object from below: layer, row, column."""
    contact = np.zeros_like(thing)
    contact[1:] = supports[:-1] & thing[1:] & ~thing[:-1]
    labels, tips = ndimage.label(contact, np.ones((3, 3, 3)))
    return np.array(ndimage.center_of_mass(contact, labels, range(1, tips + 1))).reshape(-1, 3)


def loads_of(thing, tips, pitch):
    """Area of overhang for each tip, and of that which is far from all tips. Voxels are cubes, so a surface at 45 degrees advances by
    a pixel a layer."""
    loads, far = np.zeros(len(tips)), 0
    for layer in range(1, len(thing)):
        if not thing[layer].any():
            continue
        below = ndimage.binary_dilation(thing[layer - 1], np.ones((3, 3)))
        places = np.argwhere(thing[layer] & ~below)
        if len(places) == 0:
            continue
        near = np.flatnonzero((tips[:, 0] <= layer + 1) & (tips[:, 0] > layer - HANGS_MM / pitch)) if len(tips) else []
        if len(near) == 0:
            far += len(places)
            continue
        away, which = cKDTree(tips[near, 1:]).query(places)
        reached = away <= HANGS_MM / pitch
        np.add.at(loads, near[which[reached]], 1)
        far += np.count_nonzero(~reached)
    return loads * pitch**2, far * pitch**2


def longest_free(supports, thing, pitch):
    """Length of the longest chain of regions, each above the one before and neither split nor joined, that stands upright."""
    longest, chains, labels_below = 0, {}, None
    for layer in range(len(supports)):
        labels, regions = ndimage.label(supports[layer] | thing[layer], np.ones((3, 3)))
        here = {}
        if regions and labels_below is not None:
            both = np.unique(np.stack([labels_below.ravel(), labels.ravel()])[:, ((labels_below > 0) & (labels > 0)).ravel()], axis=1)
            ups, downs = np.bincount(both[0]), np.bincount(both[1])
            sizes = np.bincount(labels.ravel())
            part = np.unique(labels[thing[layer]])
            middles = ndimage.center_of_mass(labels > 0, labels, range(1, regions + 1))
            for low, high in both.T:
                if ups[low] != 1 or downs[high] != 1 or sizes[high] * pitch**2 > PILLAR_MM2 or high in part:
                    continue
                middle = np.array(middles[high - 1])
                length, before = chains.get(low, (0, middle))
                length = length + 1 if np.abs(middle - before).max() <= UPRIGHT else 0
                here[high] = (length, middle)
                longest = max(longest, length)
        chains, labels_below = here, labels
    return longest * pitch


def scars_of(thing, supports):
    """The sides at which they touch, and the object's voxels that have one."""
    sides, touched = 0, np.zeros_like(thing)
    for axis in range(3):
        for near, far in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
            here = tuple(near if a == axis else slice(None) for a in range(3))
            there = tuple(far if a == axis else slice(None) for a in range(3))
            scars = thing[here] & supports[there]
            sides += np.count_nonzero(scars)
            touched[here] |= scars
    return sides, touched


def front_scars(thing, touched):
    """Pixels of scars in the worst of three views: from the front, the object's least y, and from 40 degrees beside it."""
    surface = thing & ~ndimage.binary_erosion(thing)
    layer, y, x = np.argwhere(surface).T
    scar = touched[surface]
    worst = 0
    for angle in np.radians((-40, 0, 40)):
        column = np.round(x * np.cos(angle) - y * np.sin(angle)).astype(int)
        column -= column.min()
        depth = x * np.sin(angle) + y * np.cos(angle)
        first = np.full((layer.max() + 1, column.max() + 1), np.inf)
        np.minimum.at(first, (layer, column), depth)
        seen = scar & (depth <= first[layer, column] + 1.2)
        worst = max(worst, len(np.unique(np.stack((layer[seen], column[seen])), axis=1).T))
    return worst


def clearance(thing, supports, pitch):
    labels, _ = ndimage.label(ndimage.binary_dilation(thing) & supports, np.ones((3, 3, 3)))
    tips = [[(side.start + side.stop - 1) / 2 for side in box] for box in ndimage.find_objects(labels)
            if (box[0].stop - box[0].start) * pitch <= TOUCH_MM]  # fmt: skip
    away = ndimage.distance_transform_edt(~thing)[supports] * pitch
    near = away < CLEAR_MM
    places = np.argwhere(supports)[near]
    if len(tips) and len(places):
        away = away[near][cKDTree(tips).query(places)[0] * pitch > TIP_MM]
    return away.min(initial=CLEAR_MM)


def narrow_gaps(thing, supports, pitch):
    reach = round(GAP_MM / 2 / pitch)
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    disc = x * x + y * y <= reach * reach
    edge = reach + 1
    gaps = 0
    for held, part in zip(supports, thing):
        closed = ndimage.binary_closing(np.pad(held, edge), disc)[edge:-edge, edge:-edge] if held.any() else held
        gaps += np.count_nonzero(closed & ~held & ~part)
    return gaps


def measure_supports(thing, masks, pitch):
    """thing, masks: object without and with supports, aligned, [layer, row, column]."""
    supports = masks & ~thing
    tips = tips_of(thing, supports)
    loads, far = loads_of(thing, tips, pitch)
    sides, touched = scars_of(thing, supports)
    return Figures(
        islands_of(masks), len(tips), loads.mean() if len(loads) else 0, loads.max() if len(loads) else 0, far,
        longest_free(supports, thing, pitch), np.count_nonzero(supports) * pitch**3, sides * pitch**2,
        front_scars(thing, touched) * pitch**2, clearance(thing, supports, pitch), narrow_gaps(thing, supports, pitch) * pitch**3,
    )  # fmt: skip
