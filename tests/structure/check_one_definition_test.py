#!/usr/bin/env python3
"""Shows check_one_definition.py two boxes of one name, as two folders of this program once had them: check_one_definition_test.py COMPILER"""

import sys
import tempfile
import unittest
from pathlib import Path

from check_one_definition import compared, compile_one

MAIN = "bool checks_box_is_empty();\nbool screen_box_is_empty();\nint main() { return checks_box_is_empty() + screen_box_is_empty(); }\n"
CHECKS = """namespace plumbline {
struct PixelBox {
  unsigned column = ~0U, column_end = 0, row = ~0U, row_end = 0;
  bool empty() const { return column >= column_end; }
};
}
bool checks_box_is_empty() { const plumbline::PixelBox box{3, 9, 0, 5}; return box.empty(); }
"""
SCREEN = """namespace plumbline {
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
  constexpr bool empty() const { return width <= 0 || height <= 0; }
};
}
bool screen_box_is_empty() { const plumbline::PixelBox box{0, 0, 10, 10}; return box.empty(); }
"""


class CheckOneDefinition(unittest.TestCase):
    compiler = "g++"

    def said_about(self, *sources):
        with tempfile.TemporaryDirectory() as folder:
            objects = []
            for number, text in enumerate(sources):
                source, target = Path(folder, f"{number}.cpp"), str(Path(folder, f"{number}.o"))
                source.write_text(text, encoding="utf-8")
                self.assertEqual(compile_one([self.compiler, "-std=c++20", "-O3", "-c", str(source), "-o", "x.o"], folder, target, {}), "")
                objects.append(target)
            return compared(self.compiler, objects, str(Path(folder, "all.o")))

    def test_two_types_of_one_name_are_found(self):
        self.assertIn("violates the C++ One Definition Rule", self.said_about(MAIN, CHECKS, SCREEN))

    def test_types_of_two_names_are_not(self):
        self.assertEqual(self.said_about(MAIN, CHECKS.replace("PixelBox", "RegionBox"), SCREEN), "")


if __name__ == "__main__":
    CheckOneDefinition.compiler = sys.argv.pop(1)
    sys.exit(unittest.main())
