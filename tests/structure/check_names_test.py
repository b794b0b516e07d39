#!/usr/bin/env python3
"""Runs check_names.py on small trees: one keeps the rule, each of the others breaks it."""

import sys
import tempfile
import unittest
from pathlib import Path

from check_names import check

GOOD = {
    "slicer/box.hpp": "namespace plumbline {\nstruct RegionBox {\n  int column = 0;\n  bool empty() const { return column > 0; }\n};\n"
    "inline constexpr int kMost = 1;\nenum class Way : char { kUp };\n}\n",
    "slicer/box.cpp": "namespace plumbline {\nnamespace {\nstruct Cell {};\nconstexpr int kSlots = 2;\n}\nstruct Server::State {};\n}\n",
    "hal/rows.cpp": "namespace plumbline {\nnamespace {\nstruct Cell {};  // struct RegionBox {}\nconstexpr int kSlots = 3;\n}\nusing Kind = int;\n}\n",
    "firmware/lanes.hpp": "namespace plumbline {\nclass PixelBox;\n#if 1\nstruct Lanes {};\n#else\nstruct Lanes { int x; };\n#endif\nextern const int kShared;\n}\n",
    "firmware/lanes.cpp": "namespace plumbline {\nconst int kShared = 1;\nusing Kind = char;\nstruct Outer {\n  struct RegionBox {};\n};\n"
    "template <>\nstruct Hash<RegionBox> {};\n}\n",
    "firmware/other.hpp": "namespace plumbline::preview {\nstruct RegionBox {};\n}\n",
}


class CheckNames(unittest.TestCase):
    def wrong_with(self, changes):
        with tempfile.TemporaryDirectory() as folder:
            for path, text in {**GOOD, **changes}.items():
                file = Path(folder, path)
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text, encoding="utf-8")
            return check(folder)[1]

    def test_a_good_tree_has_nothing(self):
        self.assertEqual(self.wrong_with({}), [])

    def test_two_types_of_one_name_are_found(self):
        # The two boxes of shared/cases/odr.
        for second in ("struct RegionBox {\n  int x = 0, y = 0;\n};", "class RegionBox final : public Box {\n};", "enum class RegionBox : char { kNone };"):
            found = self.wrong_with({"firmware/canvas.hpp": f"namespace plumbline {{\n\n{second}\n}}\n"})
            self.assertEqual(found, ["plumbline::RegionBox stands 2 times: slicer/box.hpp:2, firmware/canvas.hpp:3"])

    def test_aliases_and_constants_of_one_name_are_found(self):
        for second in ("using Way = int;", "inline constexpr double kMost = 2;"):
            self.assertEqual(len(self.wrong_with({"hal/second.hpp": f"namespace plumbline {{\n{second}\n}}\n"})), 1)

    def test_a_name_in_a_file_must_not_hide_one_of_the_program(self):
        found = self.wrong_with({"hal/second.cpp": "namespace plumbline {\nnamespace {\nstruct RegionBox {};\n}\n}\n"})
        self.assertEqual(found, ["hal/second.cpp:3: hides plumbline::RegionBox of slicer/box.hpp:2"])


if __name__ == "__main__":
    sys.exit(unittest.main())
