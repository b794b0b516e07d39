#!/usr/bin/env python3
"""Where plumbline slice puts an object, how large, and which way up."""

import json
import re
import subprocess

from case import PLUMBLINED, SIM2K, SOURCE_DIR, Program, box, confirm_plate, main, png_rows


class Placement(Program):
    def test_transform_and_origin_agree_with_each_other_and_with_the_object(self):
        self.slice_it("--rotate-x", 30, "--rotate-z", 250, "--scale", 0.75, "--no-preview")
        manifest = self.manifest()
        matrix, origin = manifest["transform"], manifest["grid"]["origin_mm"]
        printed = [sum(matrix[r][c] * origin[c] for c in range(3)) + matrix[r][3] for r in range(4)]
        for coordinate in printed[:3]:
            self.assertAlmostEqual(coordinate, 0, places=9)
        self.assertEqual(matrix[3], [0, 0, 0, 1])
        # The sphere's centre is over the middle of the panel, one radius above the plate.
        for found, wanted in zip([row[3] for row in matrix[:3]], (20.15, 15, 9)):
            self.assertAlmostEqual(found, wanted, delta=0.02)

    def test_origin_is_in_mm_whatever_the_unit(self):
        self.slice_it("--no-preview")
        in_mm = self.manifest()["grid"]["origin_mm"]
        self.slice_it("--units", "cm", "--scale", 0.1, "--no-preview")
        for ten_times, origin in zip(self.manifest()["grid"]["origin_mm"], in_mm):
            self.assertAlmostEqual(ten_times, 10 * origin, places=4)

    def test_base_is_what_was_asked_for(self):
        for kind, flat in (("none", False), ("flat", True)):
            self.slice_it("--base", kind, "--no-preview")
            self.assertEqual(self.manifest()["underside"], {"base": kind, "on_base_plane": flat})
        self.assertIn("round", self.slice_it("--base", "round", status=2).stderr)

    def test_fit_prints_as_large_as_the_printer_can(self):
        self.slice_it("--fit", "--no-preview")
        self.assertAlmostEqual(max(self.manifest()["size_mm"][:2]), 29.0, delta=0.1)
        self.assertEqual(self.manifest()["issues"]["kinds"].get("touching_bound"), None)

    def test_error_about_a_large_object_gives_the_scale_that_fits(self):
        done = self.slice_it("--scale", 2, status=1)
        self.assertRegex(done.stderr, r"sphere\.ply: the object is 4\d\.\d+ mm .* Use --scale 1\.2")

    def test_height_gives_the_size_whatever_the_unit(self):
        for text, mm in (("12mm", 12), ("1.5cm", 15), ("0.5in", 12.7)):
            self.slice_it("--height", text, "--no-preview")
            self.assertAlmostEqual(self.manifest()["size_mm"][2], mm, delta=0.1)

    def corrected_printer(self, **values):
        """@returns a board file as sim2k, with a profile beside it, both with these values instead of theirs"""
        (self.dir / "profiles").mkdir(exist_ok=True)
        for source, path in ((SIM2K, self.dir / "sim2k.toml"), (SOURCE_DIR / "board/profiles/standard.toml", self.dir / "profiles/standard.toml")):
            text = source.read_text()
            for key, value in values.items():
                text = re.sub(rf"^{key} = \S+", f"{key} = {value}", text, flags=re.M)
            path.write_text(text)
        return self.dir / "sim2k.toml"

    def write_block(self):
        mesh = self.dir / "block.stl"
        mesh.write_text(f"solid block\n{box((0, 0, 0), (20, 10, 5))}endsolid block\n")
        return mesh

    def test_masks_are_larger_by_what_printer_and_resin_shrink(self):
        block = self.write_block()
        board = self.corrected_printer(relative_correction_x=1.02, material_correction_x=1.03, material_correction_y=1.04, relative_correction_z=1.1)
        done = self.run_it("slice", block, "-o", self.out, "--printer", board, "--supports", "none", "--no-preview")
        manifest = self.manifest()
        self.assertIn("corrected  masks 1.0506, 1.04, 1.1 times as large in x, y, z\n", done.stdout)
        for found, wanted in zip(manifest["size_correction"], (1.02 * 1.03, 1.04, 1.1)):
            self.assertAlmostEqual(found, wanted, places=6)
        self.assertEqual(manifest["absolute_correction_mm"], 0)
        self.assertEqual(manifest["grid"]["layers"], 110)
        for found, wanted in zip(manifest["size_mm"], (20, 10, 5)):
            self.assertAlmostEqual(found, wanted, places=5)
        columns, rows = png_rows((self.out / "layers/00050.png").read_bytes())
        lit = [row for row in rows if any(row)]
        self.assertAlmostEqual(len(lit) * 0.04725, 10 * 1.04, delta=0.05)
        self.assertAlmostEqual(sum(b.bit_count() for b in lit[100]) * 0.04725, 20 * 1.02 * 1.03, delta=0.05)

    def test_an_archive_of_corrected_masks_has_the_layers_of_the_stage(self):
        archive = self.dir / "block.sl1"
        board = self.corrected_printer(relative_correction_z=1.1)
        self.run_it("slice", self.write_block(), "-o", archive, "--printer", board, "--supports", "none", "--no-preview")
        report = json.loads(self.run_it("inspect", archive, "--printer", board, "--json").stdout)["archive"]
        self.assertEqual((report["layers"], report["layer_height"]), (110, 0.05))
        # It is printed as it is: not corrected once more.
        self.run_it("print", archive, "--printer", board, "--accept", "--report", self.dir / "r.json", "--quiet")
        contract = json.loads((self.dir / "r.json").read_text())["contract"]
        self.assertEqual(contract["size_correction"], [1, 1, 1])
        self.assertAlmostEqual(contract["height_mm"], 5.5, places=3)
        done = self.run_it("print", archive, "--printer", board, "--absolute-correction", -0.02, status=1)
        self.assertIn("is sliced already", done.stderr)

    def test_a_print_is_corrected_as_its_profile_says_and_measured_as_it_shrinks(self):
        block, report = self.write_block(), self.dir / "r.json"
        same = ("print", block, "--supports", "none", "--truth", block, "--accept", "--quiet", "--report", report)
        walls, made = [], []
        for values in ({}, {"material_correction_x": 1.05, "material_correction_y": 1.05, "material_correction_z": 1.05}, {"absolute_correction": -0.1}):
            self.run_it(*same, "--printer", self.corrected_printer(**values))
            made.append(json.loads(report.read_text()))
            walls.append(made[-1]["part"]["deviation_um"]["wall_mean"])
        self.assertEqual(made[1]["contract"]["size_correction"], [1.05, 1.05, 1.05])
        self.assertEqual((made[1]["layers"], made[1]["layer_height_mm"]), (105, 0.05))
        self.assertAlmostEqual(made[1]["contract"]["height_mm"], 5, places=3)
        self.assertLess(abs(walls[1] - walls[0]), 30, "a pixel is 47 um, and 5 % of 10 mm are 500")
        self.assertEqual(made[2]["contract"]["absolute_correction_mm"], -0.1)
        self.assertAlmostEqual(walls[2] - walls[0], -100, delta=30)
        self.run_it(*same, "--printer", self.corrected_printer(absolute_correction=-0.1), "--absolute-correction", 0)
        self.assertEqual(json.loads(report.read_text())["part"]["deviation_um"]["wall_mean"], walls[0])

    def test_what_was_sliced_is_true_before_its_outlines_are_moved(self):
        report, walls = self.dir / "r.json", []
        for by in (0, -0.1):
            self.run_it("print", self.write_block(), "--printer", SIM2K, "--supports", "none", "--accept", "--quiet", "--report", report,
                        "--keep-part", self.dir / "part", "--absolute-correction", by)  # fmt: skip
            walls.append(json.loads(report.read_text())["part"]["deviation_um"]["wall_mean"])
        self.assertAlmostEqual(walls[1] - walls[0], -100, delta=30)

    def test_the_printer_makes_the_same_masks_as_the_desktop(self):
        state, stick, report = self.dir / "state", self.dir / "stick", self.dir / "r.json"
        stick.mkdir()
        block = self.write_block()
        block.rename(stick / "block.stl")
        confirm_plate(state)
        board = self.corrected_printer(start='"on_stick"', material_correction_x=1.02, relative_correction_z=1.1, absolute_correction=-0.06)
        command = [PLUMBLINED, "--printer", board, "--state", state, "--stick", stick, "--speedup", 1e6, "--jobs", 1]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=120, check=False)
        self.assertIn("block.stl: finished, 110 of 110 layers", done.stdout + done.stderr)
        printed = json.loads((state / "report.json").read_text())
        self.assertEqual(printed["contract"]["size_correction"], [1.02, 1, 1.1])
        self.run_it("print", stick / "block.stl", "--printer", board, "--accept", "--quiet", "--report", report)
        at_desk = json.loads(report.read_text())
        self.assertEqual(printed["contract"], at_desk["contract"])
        self.assertEqual([line["mask_hash"] for line in printed["exposures"]], [line["mask_hash"] for line in at_desk["exposures"]])

    def test_corrections_of_nothing_change_no_mask(self):
        def hashes(*more):
            self.slice_it("--no-preview", *more)
            return self.manifest()["hashes"]["layers"]

        plain = hashes()
        self.assertEqual(hashes("--absolute-correction", 0), plain)
        self.assertNotEqual(hashes("--absolute-correction", -0.05), plain)
        self.assertIn("-0.5 to 0.5", self.slice_it("--absolute-correction", 2, status=2).stderr)

    def test_way_up_that_was_found_is_the_one_that_can_be_typed(self):
        self.slice_it("--orient", "auto", "--no-preview")
        found = self.manifest()
        x, y = found["orientation"]["turned_deg"]
        self.slice_it("--rotate-x", x, "--rotate-y", y, "--no-preview")
        for row, wanted in zip(self.manifest()["transform"][:3], found["transform"]):
            for typed, turned in zip(row[:3], wanted):
                self.assertAlmostEqual(typed, turned, places=9)


if __name__ == "__main__":
    main()
