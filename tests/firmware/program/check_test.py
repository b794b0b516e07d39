#!/usr/bin/env python3
"""plumbline check, and the checks of plumbline slice: what is found in the masks, and what happens then."""

import json

from case import Program, main, write_lying_cone


class Check(Program):
    def test_check_finds_in_the_written_layers_what_slice_has_found(self):
        self.slice_it("--supports", "none")
        issues = self.manifest()["issues"]
        self.assertEqual(list(issues["kinds"]), ["first_layer_area"])
        self.assertTrue((self.out / "issues.png").read_bytes().startswith(b"\x89PNG"))
        picture = self.dir / "found.png"
        told = json.loads(self.run_it("check", self.out, "--json", "--picture", picture).stdout)
        self.assertEqual(told["issues"], issues)
        self.assertAlmostEqual(told["volume_ml"] * 1000, self.manifest()["volume_mm3"], places=3)
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))
        # The same of the scan, without its layers.
        told = json.loads(self.run_it("check", self.scan, "--printer", self.board, "--supports", "none", "--json").stdout)
        self.assertEqual(told["issues"], issues)
        # A folder of PNG files alone needs a pitch.
        (self.out / "manifest.json").rename(self.dir / "elsewhere.json")
        done = self.run_it("check", self.out / "layers", status=1)
        self.assertIn("Give --pixel-pitch and --layer-height, or --printer", done.stderr)
        done = self.run_it("check", self.out / "layers", "--pixel-pitch", 0.1, "--layer-height", 0.1)
        self.assertIn(f"{issues['layers']} of 403 x 300 px, 0.1 x 0.1 x 0.1 mm each", done.stdout)
        self.assertRegex(done.stdout, r"warn       1 small first layer of 3\.\d+ mm2")

    def test_check_slices_a_scan_as_slice_does(self):
        write_lying_cone(self.scan)
        for options in (("--fit",), ("--orient", "auto"), ("--floor", "-8", "--base", "flat")):
            self.slice_it(*options, "--supports", "auto", "--no-preview")
            manifest = self.manifest()
            told = json.loads(self.run_it("check", self.scan, "--printer", self.board, "--supports", "auto", *options, "--json").stdout)
            self.assertEqual((told["grid"]["layers"], told["issues"]), (manifest["grid"]["layers"], manifest["issues"]), options)

    def test_what_is_asked_about_must_be_accepted(self):
        ask = ("--supports", "none", "--check", "first_layer_area=ask", "--no-preview")
        done = self.slice_it(*ask, status=1)
        self.assertRegex(done.stderr, r"1 small first layer of .* or accept it with --accept")
        self.assertFalse(self.out.exists())
        self.slice_it(*ask, "--accept")
        self.assertEqual(self.manifest()["issues"]["kinds"]["first_layer_area"]["action"], "warn")
        self.slice_it("--supports", "none", "--check", "all=ignore", "--no-preview")
        self.run_it("check", self.out, "--check", "first_layer_area=refuse", status=1)
        for wrong in ("overhang", "overhang=shout", "cliff=warn"):
            self.assertIn("is not KIND=ACTION", self.slice_it("--check", wrong, status=2).stderr)


if __name__ == "__main__":
    main()
