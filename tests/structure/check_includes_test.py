#!/usr/bin/env python3
"""Runs check_includes.py on small trees: one keeps every rule, each of the others breaks one."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from check_includes import check

# Keeps every rule.
GOOD = {
    "slicer/core/arena.hpp": '#include <cstddef>\n#include "slicer/core/error.hpp"\n',
    "slicer/core/error.hpp": "",
    "slicer/cloud/kd_tree.cpp": '#include <nanoflann.hpp>\n#include "slicer/cloud/kd_tree.hpp"\n#include "slicer/core/arena.hpp"\n',
    "slicer/cloud/kd_tree.hpp": "",
    "hal/clock.hpp": '#include "slicer/core/error.hpp"\n',
    "hal/linux/clock.cpp": '#include "hal/clock.hpp"\n#include <ctime>\n',
    "hal/sim/clock.hpp": '#include "hal/clock.hpp"\n',
    "firmware/printer.cpp": '#include "hal/clock.hpp"\n#include "firmware/cli/commands.hpp"\n#include <thread>\n',
    "firmware/pictures/png.cpp": '#include "slicer/cloud/kd_tree.hpp"\n#include <spng.h>\n',
    "firmware/cli/commands.hpp": '#include "firmware/messages/exit_code.hpp"\n#include "firmware/pictures/png.hpp"\n',
    "slicer/rays/deep/shooter.hpp": '#include "slicer/cloud/kd_tree.hpp"\n#include "slicer/rays/ray_grid.hpp"\n',
    "slicer/slicer.cpp": '#include "slicer/rays/ray_grid.hpp"\n#include "slicer/plan/memory_plan.hpp"\n',
    "slicer/reader/formats/ply.cpp": '#include "slicer/reader/stream/number.hpp"\n#include "slicer/core/error.hpp"\n',
    "hal/linux/linux_machine.cpp": '#include "hal/linux/gpio/line.hpp"\n',
    "firmware/machine/linux_back_end.cpp": '#include "hal/linux/clock.hpp"\n',
    "firmware/machine/simulated_back_end.cpp": '#include "hal/sim/clock.hpp"\n',
    "slicer/example/embed.cpp": '#include "slicer/slicer.hpp"\n#include "slicer/rays/ray_grid.hpp"\n#include <fstream>\n',
    "tests/png_test.cpp": '#include <lodepng.h>\n#include "hal/sim/clock.hpp"\n#include "firmware/printer.hpp"\n',
}


class CheckIncludes(unittest.TestCase):
    def violations(self, changes):
        with tempfile.TemporaryDirectory() as folder:
            for path, text in {**GOOD, **changes}.items():
                file = Path(folder, path)
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text, encoding="utf-8")
            return check(folder)[1]

    def assert_only(self, changes, place, reason):
        found = self.violations(changes)
        self.assertEqual(len(found), 1, found)
        self.assertTrue(found[0].startswith(place + ":"), found)
        self.assertIn(reason, found[0])

    def test_a_good_tree_has_no_violations(self):
        self.assertEqual(self.violations({}), [])

    def test_each_folder_has_its_namespace(self):
        self.assertEqual(self.violations({"hal/good.hpp": "namespace plumbline::inline hal::kms {\n}\n"}), [])
        self.assert_only({"hal/bad.hpp": "namespace plumbline::inline slicer {\n}\n"},
                         "hal/bad.hpp:0", "namespace plumbline::inline slicer: its folder's is plumbline::inline hal")

    def test_core_includes_nothing_of_ours(self):
        self.assert_only({"slicer/core/bad.hpp": '// why\n\n#include "slicer/cloud/kd_tree.hpp"\n'},
                         "slicer/core/bad.hpp:3", "slicer/core may not include slicer;")

    def test_slicer_does_not_include_firmware(self):
        self.assert_only({"slicer/reader/bad.cpp": '#include "firmware/printer.hpp"\n'},
                         "slicer/reader/bad.cpp:1", "slicer may not include firmware")

    def test_slicer_does_not_include_hal(self):
        self.assert_only({"slicer/bad.cpp": '#include "hal/clock.hpp"\n'}, "slicer/bad.cpp:1", "may not include hal")

    def test_hal_does_not_include_slicer(self):
        self.assert_only({"hal/bad.hpp": '#include "slicer/cloud/kd_tree.hpp"\n'}, "hal/bad.hpp:1", "hal may not include slicer;")

    def test_hal_does_not_include_its_back_ends(self):
        self.assert_only({"hal/bad.cpp": '#include "hal/linux/clock.hpp"\n'},
                         "hal/bad.cpp:1", "hal may not include hal/linux")

    def test_back_ends_do_not_include_each_other(self):
        self.assert_only({"hal/linux/bad.cpp": '#include "hal/sim/clock.hpp"\n'},
                         "hal/linux/bad.cpp:1", "hal/linux may not include hal/sim")

    def test_product_does_not_include_the_simulator(self):
        self.assert_only({"firmware/bad.cpp": '#  include "hal/sim/clock.hpp"\n'},
                         "firmware/bad.cpp:1", "firmware may not include hal/sim")

    def test_product_opens_each_back_end_in_one_source_file(self):
        self.assert_only({"firmware/bad.cpp": '#include "hal/linux/clock.hpp"\n'},
                         "firmware/bad.cpp:1", "firmware may not include hal/linux")
        self.assert_only({"firmware/machine/back_end.cpp": '#include "hal/sim/clock.hpp"\n'},
                         "firmware/machine/back_end.cpp:1", "firmware may not include hal/sim")
        self.assert_only({"firmware/machine/linux_back_end.cpp": '#include "hal/sim/clock.hpp"\n'},
                         "firmware/machine/linux_back_end.cpp:1", "firmware may not include hal/sim")

    def test_product_does_not_include_tests(self):
        self.assert_only({"firmware/bad.cpp": '#include "tests/fake.hpp"\n'},
                         "firmware/bad.cpp:1", "firmware may not include tests")

    def test_pictures_include_nothing_else_of_the_firmware(self):
        self.assert_only({"firmware/pictures/bad.cpp": '#include "firmware/messages/exit_code.hpp"\n'},
                         "firmware/pictures/bad.cpp:1", "firmware/pictures may not include firmware;")

    def test_a_folder_does_not_include_a_later_one(self):
        order = "core, reader, cloud, placement, orientation, implicit, normals, views, surface, rrep, mesh, rays, layers, dose, supports, checks, plan"
        self.assert_only({"slicer/cloud/bad.hpp": '#include "slicer/plan/memory_plan.hpp"\n'}, "slicer/cloud/bad.hpp:1",
                         f"slicer/cloud -> slicer/plan is the wrong way: the order in slicer is {order}, then")
        self.assert_only({"slicer/rays/deep/bad.cpp": '#include "slicer/layers/mask.hpp"\n'}, "slicer/rays/deep/bad.cpp:1",
                         "slicer/rays -> slicer/layers is the wrong way")
        self.assert_only({"slicer/core/arena.hpp": '#include "slicer/core/regions/layer_regions.hpp"\n'}, "slicer/core/arena.hpp:1",
                         "the order in slicer/core is numbers, words, resin, ., regions")
        self.assert_only({"slicer/reader/stream/bad.cpp": '#include "slicer/reader/formats/ply.hpp"\n'},
                         "slicer/reader/stream/bad.cpp:1", "the order in slicer/reader is stream, records, formats, triangles, then")
        self.assert_only({"firmware/io/bad.cpp": '#include "firmware/cli/commands.hpp"\n'},
                         "firmware/io/bad.cpp:1", "firmware/io -> firmware/cli is the wrong way")
        self.assert_only({"hal/linux/gpio/bad.cpp": '#include "hal/linux/keeper/keeper.hpp"\n'},
                         "hal/linux/gpio/bad.cpp:1", "hal/linux/gpio -> hal/linux/keeper is the wrong way")

    def test_no_folder_includes_the_files_above_it(self):
        self.assert_only({"slicer/plan/bad.cpp": '#include "slicer/slicer.hpp"\n'},
                         "slicer/plan/bad.cpp:1", "slicer/plan -> slicer is the wrong way")
        self.assert_only({"slicer/reader/formats/bad.cpp": '#include "slicer/reader/scan_reader.hpp"\n'},
                         "slicer/reader/formats/bad.cpp:1", "slicer/reader/formats -> slicer/reader is the wrong way")

    def test_a_new_folder_needs_a_place_in_the_order(self):
        self.assert_only({"slicer/new/room.cpp": '#include "slicer/core/error.hpp"\n'},
                         "slicer/new/room.cpp:1", "slicer/new has no place in the order of slicer: give it one")

    def test_our_headers_are_written_from_the_top(self):
        self.assert_only({"slicer/bad.cpp": '#include "kd_tree.hpp"\n'}, "slicer/bad.cpp:1", "from the top")
        self.assert_only({"slicer/bad.cpp": '#include "../firmware/printer.hpp"\n'}, "slicer/bad.cpp:1", "from the top")
        self.assert_only({"slicer/bad.cpp": '#include "slicer/../firmware/printer.hpp"\n'}, "slicer/bad.cpp:1", "from the top")

    def test_angle_brackets_do_not_hide_one_of_ours(self):
        self.assert_only({"slicer/core/bad.cpp": "#include <slicer/cloud/kd_tree.hpp>\n"}, "slicer/core/bad.cpp:1", "quotes")

    def test_a_macro_does_not_hide_one_of_ours(self):
        self.assert_only({"slicer/bad.cpp": "#include HEADER\n"}, "slicer/bad.cpp:1", "macro")

    def test_nanoflann_is_in_exactly_one_source_file(self):
        found = self.violations({"slicer/second.cpp": "#include <nanoflann.hpp>\n"})
        self.assertEqual([v.split(": ")[0] for v in found], ["slicer/cloud/kd_tree.cpp:1", "slicer/second.cpp:1"])
        found = self.violations({"slicer/cloud/kd_tree.cpp": ""})
        self.assertEqual(len(found), 1, found)
        self.assertIn("none does", found[0])

    def test_a_wrapped_library_is_in_one_source_file_outside_tests(self):
        found = self.violations({"firmware/second.cpp": "#include <spng.h>\n"})
        self.assertEqual(len(found), 2, found)

    def test_a_wrapped_library_is_not_in_a_header(self):
        self.assert_only({"firmware/bad.hpp": "#include <toml++/toml.h>\n"}, "firmware/bad.hpp:1", "source file only")

    def test_slicer_has_no_thread_file_or_clock(self):
        for header in ("thread", "fstream", "chrono", "sys/mman.h"):
            self.assert_only({"slicer/core/bad.cpp": f"#include <{header}>\n"}, "slicer/core/bad.cpp:1", "devices or clock")

    def test_exit_status_shows_the_result(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(self.run_script(folder).returncode, 2, "an empty folder is an error")
            Path(folder, "slicer").mkdir()
            Path(folder, "slicer/bad.cpp").write_text('#include <nanoflann.hpp>\n#include "hal/clock.hpp"\n')
            result = self.run_script(folder)
            self.assertEqual(result.returncode, 1)
            self.assertIn("slicer/bad.cpp:2: ", result.stdout)
            Path(folder, "slicer/bad.cpp").write_text("#include <nanoflann.hpp>\n")
            self.assertEqual(self.run_script(folder).returncode, 0)

    def run_script(self, folder):
        script = Path(__file__).with_name("check_includes.py")
        return subprocess.run([sys.executable, script, folder], capture_output=True, text=True, check=False)


if __name__ == "__main__":
    unittest.main()
