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

    def test_supports_are_set_by_hand(self):
        self.slice_it("--no-preview", "--support-stand", "plate")
        found = self.manifest()["supports"]
        self.assertEqual((found["added"], found["blocked_areas"], found["settings"]["support_at"]), (0, 0, []))
        # Low on the sphere's side, where its slope carries itself; and one above it, where there is nothing.
        self.slice_it("--no-preview", "--supports", "none")
        place = self.place_at_the_side()
        issues = self.slice_it("--no-preview", "--support-stand", "plate", "--support-at", "900,3,20.1")
        self.assertIn("no surface within 1.5 mm of x 900.0, y 3.0, z 20.10 mm to support", issues.stderr)
        text = ",".join(map(str, place))
        done = self.slice_it("--no-preview", "--support-stand", "plate", "-v", "--support-at", text, "--no-support-at", "0,0,900", "--no-support-at", "1,2,900,0.5")
        self.assertNotIn("no surface", done.stderr)
        self.assertIn("by hand: 1 added, no others in 2 areas", done.stdout + done.stderr)
        supports = self.manifest()["supports"]
        self.assertEqual((supports["added"], supports["blocked_areas"]), (1, 2))
        self.assertEqual(supports["settings"]["support_at"], [place])
        self.assertEqual(supports["settings"]["no_support_at"], [[0, 0, 900, 2], [1, 2, 900, 0.5]])
        self.assertEqual(supports["below_overhangs"] + supports["below_islands"], found["count"] + 1)

    def place_at_the_side(self):
        """4 mm above the plate, in print coordinates."""
        manifest = self.manifest()
        grid = manifest["grid"]
        _, rows = png_rows((self.out / "layers" / f"{int(4 / grid['layer_height_mm']):05}.png").read_bytes())
        row = len(rows) // 2
        bits = "".join(f"{byte:08b}" for byte in rows[row])
        column = bits.index("1")
        return [round((column + 0.5) * grid["pixel_pitch_mm"][0], 3), round((row + 0.5) * grid["pixel_pitch_mm"][1], 3), 4.0]

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
            (("--support-at", "1,2"), "--support-at: '1,2' is not one of up to 32 places x, y, z"),
            (("--support-at", "nan,2,3"), "'nan,2,3'"),
            (("--support-at", ""), "--support-at: ' '"),
            (("--support-at", ";".join(f"1,2,{i}" for i in range(33))), "'1,2,32'"),
            (("--no-support-at", "1,2,3,0"), "radii from 0.1 to 100 mm"),
            (("--supports", "none", "--support-at", "1,2,3"), "support_at is given, but supports are off"),
        ):
            done = self.slice_it(*arguments, status=2)
            self.assertIn(message, done.stderr)
            self.assertFalse(self.out.exists())


if __name__ == "__main__":
    main()
