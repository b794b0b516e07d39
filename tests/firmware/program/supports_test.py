#!/usr/bin/env python3
"""Supports of plumbline slice: what holds the object, what the manifest says of it, and which settings are refused."""

from case import Program, main, png_rows


class Supports(Program):
    def test_supports_hold_the_sphere_and_are_reported(self):
        self.slice_it("--no-preview")
        without = self.manifest()
        self.assertIsNone(without["supports"])
        done = self.slice_it("--support-pillar-diameter", 1.5)
        manifest = self.manifest()
        supports = manifest["supports"]
        self.assertGreater(supports["count"], 4)  # the lower 45 degrees of a sphere of 12 mm
        self.assertEqual(supports["count"], supports["below_islands"] + supports["below_overhangs"])
        ends = ("on_plate", "on_object", "on_supports")
        self.assertEqual(supports["count"], sum(supports[key] for key in ends))
        self.assertAlmostEqual(manifest["volume_mm3"] - supports["volume_mm3"], without["volume_mm3"], places=3)
        self.assertEqual(supports["settings"]["support_pillar_diameter"], 1.5)
        self.assertEqual(supports["settings"]["support_critical_angle"], 45)
        self.assertIn(f" ml of it in {supports['count']} supports\n", done.stdout)
        self.assertEqual(done.stderr.count("placing supports"), 1)
        self.assertAlmostEqual(supports["lifted_layers"] * manifest["grid"]["layer_height_mm"], 5.8)  # the elevation and the raft
        self.assertEqual(supports["unbraced_pillars"], 0)
        # The lowest layer is the raft's.
        _, rows = png_rows((self.out / "layers" / "00000.png").read_bytes())
        white = sum(bin(byte).count("1") for row in rows for byte in row)
        self.assertGreater(white, supports["on_plate"] * 100)
        # Supports are the default, and change nothing where nothing falls: a hemisphere on its flat side.
        self.slice_it("--support-base-diameter", 4, "--no-preview")
        default = self.manifest()
        self.slice_it("--supports", "auto", "--no-preview")
        self.assertEqual(self.manifest()["hashes"], default["hashes"])
        self.cut_below(0)
        self.slice_it("--supports", "auto", "--no-preview")
        supported = self.manifest()
        self.assertEqual(supported["supports"]["count"], 0)
        self.slice_it("--supports", "none", "--no-preview")
        self.assertEqual(self.manifest()["hashes"], supported["hashes"])

    def test_the_summary_says_how_the_object_stands_and_why(self):
        for arguments, height, sentence in (
            (("--supports", "auto"), 5.8, "5.8 mm above the plate, on a raft, since its underside is not flat; --support-stand plate puts it down"),
            (("--support-stand", "plate"), 0, "on the plate, as asked; its underside is not flat"),
            (("--support-object-elevation", 0), 0, "on the plate, as asked; its underside is not flat"),
        ):
            self.assertIn(f"stands     {sentence}\n", self.slice_it(*arguments, "--no-preview").stdout)
            self.assertEqual(self.stand(), (height, height > 0, False))
        self.cut_below(0)
        for arguments, height, flat, sentence in (
            (("--supports", "auto"), 0, True, "on the plate, since its underside is flat; --support-stand raised lifts it by 5.8 mm"),
            (("--support-stand", "raised"), 5.8, None, "5.8 mm above the plate, on a raft, as asked"),
            (("--support-object-elevation", 3), 3.8, None, "3.8 mm above the plate, on a raft, as asked"),
            (("--support-object-elevation", 3, "--pad-wall-thickness", 0), 3, None, "3 mm above the plate, without a raft, as asked"),
        ):
            self.assertIn(f"stands     {sentence}\n", self.slice_it(*arguments, "--no-preview").stdout)
            self.assertEqual(self.stand(), (height, height > 0, flat))

    def stand(self):
        supports = self.manifest()["supports"]
        height = round(supports["lifted_layers"] * self.manifest()["grid"]["layer_height_mm"], 6)
        return height, supports["raised"], supports["flat_underside"]

    def test_wrong_support_settings_are_refused(self):
        for arguments, message in (
            (("--supports", "none", "--support-base-diameter", 3), "support_base_diameter is given, but supports are off"),
            (("--supports", "auto", "--support-critical-angle", 81), "not a number from 30 to 80"),
            (("--supports", "auto", "--support-pillar-diameter", 5), "more than support_base_diameter"),
            (("--support-stand", "plate", "--support-object-elevation", 3), "support_object_elevation is 3 mm, but support_stand is plate"),
            (("--support-stand", "up"), "'up' is not one of auto, plate, raised"),
            (("--supports", "yes"), "yes"),
        ):
            done = self.slice_it(*arguments, status=2)
            self.assertIn(message, done.stderr)
            self.assertFalse(self.out.exists())


if __name__ == "__main__":
    main()
