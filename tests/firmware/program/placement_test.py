#!/usr/bin/env python3
"""Where plumbline slice puts an object, how large, and which way up."""

from case import Program, main


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
