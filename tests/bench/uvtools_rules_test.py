#!/usr/bin/env python3
"""Hollows that the build plate closes, by UVtools' rules. What it finds follows from its IssueManager by hand: the sweep upwards takes a
hollow for a trap if no air from outside reaches it, from layer 0 on. The sweep downwards makes a cup of it if air reaches it from above.
What is left is no trap if it begins on the plate.

slicer/checks finds other cups there, on purpose: tests/slicer/checks/stack_checker_test.cpp has the same stacks.
Needs .ci/setup bench.
"""

import unittest

import numpy as np
from uvtools_rules import find_issues

SIDE = 80


def stack_of(layers, solid, hollow):
    """Boxes are (column, column end, row, row end, layer, layer end)."""
    masks = np.zeros((layers, SIDE, SIDE), np.uint8)
    for boxes, value in ((solid, 255), (hollow, 0)):
        for column, column_end, row, row_end, layer, layer_end in boxes:
            masks[layer:layer_end, row:row_end, column:column_end] = value
    return list(masks)


def layers_of(found):
    return [first_and_last[:2] for first_and_last in found]


class ClosedByThePlate(unittest.TestCase):
    def test_a_tube_on_the_plate_is_a_cup_from_layer_0(self):
        found = find_issues(stack_of(20, [(20, 60, 20, 60, 0, 20)], [(30, 50, 30, 40, 0, 20)]), 0.1)
        self.assertEqual((found.traps, layers_of(found.cups)), ([], [(0, 19)]))

    def test_a_hole_of_a_raft_is_a_cup_whatever_its_area_in_mm(self):
        raft = stack_of(20, [(20, 60, 20, 60, 0, 10), (22, 28, 22, 28, 10, 20)], [(30, 50, 30, 40, 0, 10)])
        found = find_issues(raft, 0.1)
        self.assertEqual((found.traps, layers_of(found.cups)), ([], [(0, 9)]))

    def test_a_bowl_on_its_rim_is_neither_cup_nor_trap(self):
        found = find_issues(stack_of(20, [(20, 60, 20, 60, 0, 20)], [(30, 50, 30, 40, 0, 15)]), 0.1)
        self.assertEqual((found.traps, found.cups), ([], []))

    def test_the_same_hollow_above_the_plate_is_a_trap(self):
        found = find_issues(stack_of(20, [(20, 60, 20, 60, 0, 20)], [(30, 50, 30, 40, 1, 15)]), 0.1)
        self.assertEqual((layers_of(found.traps), found.cups), ([(1, 14)], []))


if __name__ == "__main__":
    unittest.main()
