#!/usr/bin/env python3
"""What plumbline slice, inspect and print warn of in a scan."""

import json

from case import SIM2K, SOURCE_DIR, Program, add_ball, main, turn_normals, write_ball_on_plinth, write_lying_cone, write_sphere
from state_client import StatePrinter


class Warnings(Program):
    def test_stray_piece_is_left_out_reported_and_kept_on_request(self):
        write_sphere(self.scan)
        add_ball(self.scan, 200, 1.0, (40, 0, 0))
        done = self.slice_it("--no-preview")
        manifest = self.manifest()
        self.assertEqual(manifest["stray_pieces"]["pieces"], 1)
        self.assertEqual(manifest["stray_pieces"]["points"], 200)
        self.assertAlmostEqual(manifest["size_mm"][0], 24, delta=0.1)
        self.assertIn("warning: 1 stray piece was left out: 200 points apart from the object", done.stderr)
        told = json.loads(self.run_it("inspect", self.scan, "--json", "--printer", self.board).stdout)
        self.assertEqual((told["stray_pieces"]["pieces"], told["fits"]), (1, True))
        kept = self.slice_it("--keep-all", "--no-preview", status=1)  # 53 mm do not fit on 40
        self.assertRegex(kept.stderr, r"the object is 5[23]\.\d+ mm wide")
        told = json.loads(self.run_it("inspect", self.scan, "--json", "--keep-all").stdout)
        self.assertEqual(told["stray_pieces"]["pieces"], 0)
        self.assertAlmostEqual(told["size_mm"][0], 53, delta=0.1)

    def test_scan_that_lies_wrong_is_told_once_while_it_is_read(self):
        write_lying_cone(self.scan)
        done = self.slice_it("--no-preview")
        told = [i for i, line in enumerate(done.stderr.splitlines()) if "lie on its side" in line]
        ended = [i for i, line in enumerate(done.stderr.splitlines()) if line.startswith("  finding the surface")]
        self.assertEqual(len(told), 1, done.stderr)
        self.assertLess(told[0], ended[0])
        sentence = done.stderr.splitlines()[told[0]].removeprefix("plumbline: warning: ")
        self.assertRegex(sentence, r"^the scan seems to lie on its side or its head\. To stand it up: --rotate-y -?90\.$")
        self.assertEqual(self.manifest()["warnings"].count(sentence), 1)
        # The same in a print.
        done = self.run_it("print", self.scan, "--printer", SIM2K, "--supports", "none")
        self.assertEqual(done.stderr.count(sentence), 1)

    def test_guessed_units_are_reported(self):
        write_sphere(self.scan, radius=0.012)
        done = self.slice_it("--units", "auto")
        self.assertIn("says no unit; m, which make it 24 mm, are a guess", done.stderr)
        manifest = self.manifest()
        self.assertEqual(manifest["units"], {"used": "m", "guessed": True})
        self.assertAlmostEqual(manifest["size_mm"][2], 24, delta=0.1)

    def test_scan_that_is_inside_out_is_turned_and_told(self):
        self.slice_it()
        volume = self.manifest()["volume_mm3"]
        self.assertFalse(self.manifest()["normals_inside_out"])
        turn_normals(self.scan, lambda i: True)
        done = self.slice_it()
        told = "the scan is inside out: 100 % of its normals pointed into the object and were flipped"
        self.assertIn("warning: " + told, done.stderr)
        self.assertTrue(self.manifest()["normals_inside_out"])
        self.assertAlmostEqual(self.manifest()["volume_mm3"], volume, delta=0.001 * volume)
        self.assertIn(told, self.run_it("inspect", self.scan).stdout)
        self.assertTrue(json.loads(self.run_it("inspect", self.scan, "--json").stdout)["scan"]["normals_inside_out"])

    def test_scan_whose_normals_contradict_each_other_is_told(self):
        write_sphere(self.scan)
        turn_normals(self.scan, lambda i: i * 7 % 5 < 2)
        done = self.slice_it()
        self.assertRegex(done.stderr, r"warning: the scan's normals face into the object and out of it at random; \d+ % were flipped")
        self.assertTrue(self.manifest()["normals_contradictory"])

    def test_small_object_gets_a_warning(self):
        write_sphere(self.scan, radius=1)
        self.assertIn("warning: the object is only 2 mm long", self.slice_it().stderr)


class PrinterWarnings(StatePrinter):
    def test_plinth_that_is_cut_off_is_told_before_the_print_and_kept_on_request(self):
        write_ball_on_plinth(self.scan)
        board = self.dir / "sim2k.toml"
        board.write_text((SOURCE_DIR / "board/sim2k.toml").read_text().replace('"on_request"', '"after_preview"'))
        command = ("slice", self.scan, "-o", self.out, "--no-preview", "--supports", "none", "--printer", board, "--layer-height", 0.1)
        done = self.run_it(*command)
        self.assertRegex(
            done.stderr,
            r"warning: a floor of 40\.0 x 40\.0 x 3\.[2-8] mm was cut off, at height .* of the scan\. If it is a plinth, --floor keep prints it\.\n",
        )
        self.assertNotIn("lie on no surface", done.stderr)
        self.assertLess(self.manifest()["size_mm"][0], 17)
        kept = self.run_it(*command, "--floor", "keep")
        self.assertNotIn("cut off", kept.stderr)
        self.assertGreater(self.manifest()["size_mm"][0], 39)

        _, user = self.start(printer=board)
        user.state("idle")
        self.put_stick({"figure.ply": self.scan.read_bytes()})
        user.state("offered", "start")
        for key, value in (("layer_height", 0.1), ("supports", "none")):
            user.do("set", key=key, value=value)
        user.do("start")
        ready = user.until(lambda s: s["state"] == "offered" and s["sliced"], "a preview")
        told = [finding["told"] for finding in ready["findings"] if finding["told"]["code"] == "floor_cut"]
        self.assertEqual(len(told), 1, ready["findings"])
        self.assertAlmostEqual(told[0]["values"]["width_mm"], 40, delta=0.1)
        self.assertAlmostEqual(told[0]["values"]["depth_mm"], 40, delta=0.1)
        self.assertAlmostEqual(told[0]["values"]["height_mm"], 3.5, delta=0.3)
        self.assertIn({"key": "floor", "value": "keep"}, [remedy for finding in ready["findings"] for remedy in finding["remedies"]])
        self.assertFalse(any("job.toml" in finding["text"] for finding in ready["findings"]), "nobody here has one")


if __name__ == "__main__":
    main()
