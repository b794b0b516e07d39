#!/usr/bin/env python3
"""plumbline slice, inspect and sample as users run them: files, output, exit status, signals, memory."""

import json
import math
import os
import signal
import struct
import subprocess
import unittest

from case import PLUMBLINE, SIM2K, U64, Program, add_ball, job_hash, layer_hash, main, png_rows, split, turn_normals
from case import write_lying_cone, write_sphere


class Slice(Program):
    def test_manifest_describes_the_files(self):
        self.slice_it("--threads", 2)
        manifest = self.manifest()
        grid = manifest["grid"]
        self.assertEqual((grid["columns"], grid["rows"]), (403, 300))
        self.assertEqual(grid["pixel_pitch_mm"], [0.1, 0.1])
        self.assertEqual(self.layers(), [f"{k:05}.png" for k in range(grid["layers"])])
        hashes, white = [], 0
        for name in self.layers():
            columns, rows = png_rows(self.out / "layers" / name)
            self.assertEqual((columns, len(rows)), (403, 300))
            hashes.append(layer_hash(columns, rows))
            white += sum(bin(byte).count("1") for row in rows for byte in row)
        self.assertEqual(manifest["hashes"]["layers"], [f"{h:016x}" for h in hashes])
        self.assertEqual(manifest["hashes"]["job"], f"{job_hash(hashes):016x}")
        self.assertAlmostEqual(manifest["volume_mm3"], white * 0.1**3, places=3)
        self.assertAlmostEqual(manifest["volume_mm3"] / (4 / 3 * math.pi * 12**3), 1, delta=0.005)
        self.assertEqual(sum(manifest["points"].values()), manifest["thinning"]["points_left"])
        decided = ("outside", "perfect", "winding_number", "base_plane")
        self.assertEqual(sum(manifest["rays"][key] for key in decided), manifest["rays"]["interested"])

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

    def test_masks_do_not_depend_on_the_number_of_threads(self):
        jobs = set()
        for threads in (1, 2, 3, 8):
            self.slice_it("--threads", threads, "--no-preview")
            jobs.add(json.dumps(self.manifest()["hashes"]))
        self.assertEqual(len(jobs), 1)

    def test_threads_default_to_openmp_s(self):
        self.slice_it("--no-preview", env={**os.environ, "OMP_NUM_THREADS": "3"})
        self.assertEqual(self.manifest()["threads"], 3)

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
        self.assertEqual(supports["lifted_layers"] * manifest["grid"]["layer_height_mm"], 6)  # the elevation and the raft
        self.assertEqual(supports["unbraced_pillars"], 0)
        # The lowest layer is the raft's.
        _, rows = png_rows(self.out / "layers" / "00000.png")
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

    def test_wrong_support_settings_are_refused(self):
        for arguments, message in (
            (("--supports", "none", "--support-base-diameter", 3), "support_base_diameter is given, but supports are off"),
            (("--supports", "auto", "--support-critical-angle", 81), "not a number from 30 to 80"),
            (("--supports", "auto", "--support-pillar-diameter", 5), "more than support_base_diameter"),
            (("--supports", "yes"), "yes"),
        ):
            done = self.slice_it(*arguments, status=2)
            self.assertIn(message, done.stderr)
            self.assertFalse(self.out.exists())

    def test_files_of_one_frame_are_one_scan(self):
        self.slice_it("--no-preview")
        whole = self.manifest()
        top, bottom = self.dir / "top.ply", self.dir / "bottom.ply"
        split(self.scan, 7000, top, bottom)
        same = ("--printer", self.board)
        done = self.run_it("slice", top, bottom, "-o", self.out, "--no-preview", "--verbose", "--supports", "none", *same)
        manifest = self.manifest()
        self.assertEqual(manifest["hashes"], whole["hashes"])
        self.assertEqual(manifest["scan"]["name"], "top.ply and 1 more")
        self.assertEqual(manifest["scan"]["points"], 20_000)
        told = [(file["name"], file["points"]) for file in manifest["scan"]["files"]]
        self.assertEqual(told, [("top.ply", 7000), ("bottom.ply", 13_000)])
        self.assertNotIn("files", whole["scan"])
        self.assertIn("top.ply and 1 more: 20000 points", done.stdout)
        self.assertIn("bottom.ply: 13000 points", done.stdout)
        inspected = json.loads(self.run_it("inspect", top, bottom, "--json", *same).stdout)
        self.assertEqual([file["name"] for file in inspected["scan"]["files"]], ["top.ply", "bottom.ply"])
        self.assertEqual(inspected["scan"]["points"], 20_000)
        self.assertIn("bottom.ply: 13000 points", self.run_it("inspect", top, bottom, *same).stdout)

    def test_missing_file_among_several_is_named(self):
        write_sphere(self.scan)
        done = self.run_it("slice", self.scan, self.dir / "back.ply", "-o", self.out, status=1)
        self.assertIn("back.ply: the scan cannot be opened", done.stderr)
        self.assertFalse(self.out.exists())
        done = self.run_it("slice", *[self.scan] * 33, "-o", self.out, status=2)
        self.assertIn("scan", done.stderr)

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

    def test_base_is_what_was_asked_for(self):
        for kind, flat in (("none", False), ("flat", True)):
            self.slice_it("--base", kind, "--no-preview")
            self.assertEqual(self.manifest()["underside"], {"base": kind, "on_base_plane": flat})
        self.assertIn("round", self.slice_it("--base", "round", status=2).stderr)

    def test_manifest_says_what_the_surface_rests_on(self):
        write_sphere(self.scan, points=40_000)
        done = self.slice_it()
        whole = self.manifest()["evidence"]
        self.assertGreater(whole["surface"]["measured"], 0.99)
        self.assertAlmostEqual(sum(whole["surface"].values()), 1)
        self.assertRegex(done.stdout, r"scanned    (99\.[0-9]|100\.0) % of the surface; closed: underside 0\.0 %, elsewhere 0\.[0-9] %")
        self.assertTrue((self.out / "coverage.png").read_bytes().startswith(b"\x89PNG"))
        # Without what lies below z = -8: a disc of radius 8.9 on a surface of 4 pi 12^2.
        self.cut_below(-8)
        done = self.slice_it("--no-preview")
        self.assertRegex(done.stderr, r"warning: the underside \(1\d\.\d % of the surface\) was not scanned")
        manifest = self.manifest()
        part = manifest["evidence"]
        self.assertFalse((self.out / "coverage.png").exists())
        self.assertTrue(manifest["underside"]["on_base_plane"])
        disc, cap = 12**2 - 8**2, 2 * 12 * (12 + 8)
        self.assertAlmostEqual(part["surface"]["base_plane"], disc / (disc + cap), delta=0.05)
        # Crossings at the base plane are counted in the lowest layer. Each row: measured, winding number, base plane.
        self.assertEqual(len(part["layers"]), manifest["grid"]["layers"])
        self.assertEqual(sum(row[2] for row in part["layers"]), part["crossings"]["base_plane"])
        self.assertEqual(part["layers"][0][2], part["crossings"]["base_plane"])
        self.assertAlmostEqual(part["layers"][0][2] * 0.01, math.pi * disc, delta=30)
        self.assertEqual(sum(part["layers"][100][1:]), 0)

    def test_json_is_the_manifest_without_the_layers_and_nothing_else(self):
        done = self.slice_it("--json")
        told, manifest = json.loads(done.stdout), self.manifest()
        self.assertEqual(done.stderr, "")
        del manifest["hashes"]["layers"]
        del manifest["evidence"]["layers"]
        self.assertEqual(told, manifest)

    def test_quiet_prints_nothing(self):
        done = self.slice_it("--quiet")
        self.assertEqual((done.stdout, done.stderr), ("", ""))

    def test_verbose_adds_a_line_for_each_stage_with_its_memory(self):
        done = self.slice_it("--verbose")
        for word in ("sphere.ply: 20000 points", " mm", "403 x 300 px", "crossings", "MiB", "manifest.json"):
            self.assertIn(word, done.stdout)
        stages = [line.split()[0] for line in done.stderr.splitlines() if "MiB" in line]
        for stage in ("read", "trees", "clustering", "rays", "layers"):
            self.assertEqual(stages.count(stage), 1)
        self.assertNotIn("\033", done.stderr)

    def test_progress_speaks_of_the_scan_and_its_layers(self):
        done = self.slice_it("--no-preview")
        steps = [line[2:].rstrip("s 0123456789.") for line in done.stderr.splitlines() if line.startswith("  ")]
        self.assertEqual(steps, ["reading the scan", "finding the surface", "slicing", "writing the layer"])

    def test_older_job_is_replaced_whole(self):
        self.slice_it()
        before = len(self.layers())
        self.slice_it("--scale", 0.5)
        after = self.manifest()["grid"]["layers"]
        self.assertLess(after, before)
        self.assertEqual(len(self.layers()), after)

    def test_folder_with_other_files_is_left_alone(self):
        self.out.mkdir()
        (self.out / "thesis.doc").write_text("years of work")
        done = self.slice_it(status=1)
        self.assertIn("holds 'thesis.doc'", done.stderr)
        self.assertEqual([path.name for path in self.out.iterdir()], ["thesis.doc"])

    def test_fit_prints_as_large_as_the_printer_can(self):
        self.slice_it("--fit", "--no-preview")
        self.assertAlmostEqual(max(self.manifest()["size_mm"][:2]), 29.8, delta=0.1)

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

    def test_scan_that_lies_wrong_is_told_once_while_it_is_read(self):
        write_lying_cone(self.scan)
        done = self.slice_it("--no-preview")
        told = [i for i, line in enumerate(done.stderr.splitlines()) if "lie on its side" in line]
        ended = [i for i, line in enumerate(done.stderr.splitlines()) if line.startswith("  finding the surface")]
        self.assertEqual(len(told), 1, done.stderr)
        self.assertLess(told[0], ended[0])
        sentence = done.stderr.splitlines()[told[0]].removeprefix("plumbline: warning: ")
        self.assertRegex(sentence, r"^the scan seems to lie on its side or its head\. To stand it up: --rotate-y -?90$")
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

    @unittest.skipIf("PLUMBLINE_SANITIZED" in os.environ, "a sanitizer's memory is not the program's")
    def test_peak_memory_is_at_most_the_arena_and_16_mib(self):
        write_sphere(self.scan, points=100_000)
        arena_mib = 16
        child = subprocess.Popen(
            [PLUMBLINE, "slice", self.scan, "-o", self.out, "--printer", self.board, "--quiet", "--arena-mib", str(arena_mib)]
        )
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(child.returncode, 0)
        manifest = self.manifest()
        self.assertEqual(manifest["arena"]["bytes"], arena_mib << 20)
        self.assertLessEqual(manifest["arena"]["peak_bytes"], arena_mib << 20)
        print(f"peak resident {usage.ru_maxrss / 1024:.1f} MiB with an arena of {arena_mib} MiB")
        self.assertLessEqual(usage.ru_maxrss / 1024, arena_mib + 16)


class Interrupted(Program):
    def interrupt(self, number):
        write_sphere(self.scan, points=100_000)
        arguments = ["slice", self.scan, "-o", self.out, "--pixel-pitch", "0.01", "--layer-height", "0.01"]
        child = subprocess.Popen([PLUMBLINE, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for line in child.stderr:  # once a step has ended, the program catches signals
            if line.startswith("  reading the scan"):
                break
        child.send_signal(number)
        _, rest = child.communicate(timeout=120)
        self.assertEqual(child.returncode, 130, rest)
        self.assertIn("interrupted; nothing of this job was left in", rest)
        self.assertFalse(self.out.exists())

    def test_by_the_user(self):
        self.interrupt(signal.SIGINT)

    def test_by_the_system(self):
        self.interrupt(signal.SIGTERM)


class Inspect(Program):
    def test_measures_the_sphere(self):
        write_sphere(self.scan, points=20_000, radius=12)
        done = self.run_it("inspect", self.scan, "--printer", self.board, "--json")
        self.assertEqual(done.stderr, "")
        told = json.loads(done.stdout)
        self.assertEqual(told["scan"]["points"], 20_000)
        self.assertEqual(told["scan"]["normals"], {"have": 20_000, "missing": 0, "zero_length": 0})
        for side in told["size_mm"]:
            self.assertAlmostEqual(side, 24, delta=0.05)
        # On a Fibonacci lattice the nearest point is 0.9 to 1 times the square root of a point's area away.
        self.assertAlmostEqual(told["spacing_mm"] / math.sqrt(4 * math.pi * 12**2 / 20_000), 0.95, delta=0.1)
        self.assertLess(told["roughness_mm"], 0.02)
        self.assertEqual(told["units"], {"used": "mm", "guess": "mm"})
        self.assertTrue(told["fits"])
        self.assertAlmostEqual(told["largest_scale"], 29.8 / 24, delta=0.01)
        self.assertFalse(self.out.exists())

    def test_measures_noise(self):
        write_sphere(self.scan, points=20_000, radius=12)
        data = bytearray(self.scan.read_bytes())
        start = data.index(b"end_header\n") + 11
        state = 1
        for i in range(20_000):  # moves each point along its normal by a triangular noise of standard deviation 0.1 mm
            total = 0.0
            for _ in range(2):
                state = (state * 6364136223846793005 + 1442695040888963407) & U64
                total += (state >> 11) / 2**53 - 0.5
            shift = total * 0.1 * math.sqrt(6)
            at = start + 24 * i
            values = struct.unpack("<6f", data[at : at + 24])
            struct.pack_into("<3f", data, at, *(values[a] + shift * values[3 + a] for a in range(3)))
        self.scan.write_bytes(data)
        told = json.loads(self.run_it("inspect", self.scan, "--json").stdout)
        self.assertAlmostEqual(told["noise_mm"], 0.1, delta=0.02)
        # The median distance from the middle of a triangular distribution is sqrt(6) (1 - sqrt(1/2)) = 0.717 of its deviation.
        self.assertAlmostEqual(told["roughness_mm"], 0.0717, delta=0.015)

    def test_report_is_readable(self):
        write_sphere(self.scan)
        done = self.run_it("inspect", self.scan, "--printer", self.board, "--scale", 3)
        for word in ("20000 points", "normals", "fits       no", "up to scale 1.2"):
            self.assertIn(word, done.stdout)
        self.assertNotIn("MiB", done.stdout)
        done = self.run_it("inspect", self.scan, "--printer", self.board, "--verbose")
        for word in ("spacing", "noise", "MiB"):
            self.assertIn(word, done.stdout)

    def test_orient_lists_four_ways_up_and_draws_them(self):
        write_sphere(self.scan)
        picture = self.dir / "ways.png"
        done = self.run_it("orient", self.scan, "--picture", picture)
        self.assertEqual(done.stdout.count("--rotate-x"), 4)
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))
        told = json.loads(self.run_it("orient", self.scan, "--json").stdout)
        self.assertEqual(len(told["best"]), 4)
        self.assertAlmostEqual(told["now"]["height_mm"], 24, delta=0.5)

    def test_warns_of_what_was_not_scanned_and_draws_it(self):
        write_sphere(self.scan, points=40_000)
        done = self.run_it("inspect", self.scan)
        self.assertRegex(done.stdout, r"scanned    (99\.\d|100\.0) % of the surface; closed: underside 0\.0 %")
        self.assertNotIn("warning", done.stderr)
        self.cut_below(-8)
        picture = self.dir / "seen.png"
        done = self.run_it("inspect", self.scan, "--picture", picture)
        self.assertRegex(done.stderr, rf"warning: the underside \(\d+\.\d % of the surface\) was not scanned: see {picture}")
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))
        told = json.loads(self.run_it("inspect", self.scan, "--json").stdout)["never_seen"]
        disc, cap = 12**2 - 8**2, 2 * 12 * (12 + 8)
        self.assertTrue(told["underside"])
        self.assertAlmostEqual(told["underside_share"], disc / (disc + cap), delta=0.05)
        self.assertLess(told["rest_share"], 0.01)
        done = self.run_it("inspect", self.scan, "--picture", self.dir / "no" / "seen.png", status=1)
        self.assertIn("no/seen.png", done.stderr)

    def test_warns_of_a_scan_that_encloses_nothing(self):
        write_sphere(self.scan, points=40_000)
        self.cut_below(6)  # leave a cap,
        turn_normals(self.scan, lambda i: True)  # with normals that face inwards
        done = self.run_it("inspect", self.scan)
        self.assertRegex(done.stderr, r"warning: \d+ % of the scan encloses nothing: its other side was not scanned")
        self.assertIn("the scan shows one side only, which faces down", done.stdout)
        self.assertIn("--rotate-x 180", done.stdout)
        self.assertGreater(json.loads(self.run_it("inspect", self.scan, "--json").stdout)["never_seen"]["encloses_nothing"], 0.5)

    def test_reads_a_pipe_too(self):
        write_sphere(self.scan)
        with open(self.scan, "rb") as scan:
            cat = subprocess.Popen(["cat"], stdin=scan, stdout=subprocess.PIPE)
            done = self.run_it("inspect", "/dev/stdin", stdin=cat.stdout)
            cat.stdout.close()
            cat.wait()
        self.assertRegex(done.stdout, r"scanned    (99\.\d|100\.0) % of the surface; closed: underside 0\.0 %")

    def test_says_that_normals_are_missing(self):
        write_sphere(self.scan, normals=False)
        told = json.loads(self.run_it("inspect", self.scan, "--json").stdout)
        self.assertEqual(told["scan"]["normals"], {"have": 0, "missing": 20_000, "zero_length": 0})

    def test_thins_a_scan_to_the_arena(self):
        write_sphere(self.scan, points=100_000)
        told = json.loads(self.run_it("inspect", self.scan, "--json", "--arena-mib", 4, "--threads", 1).stdout)
        self.assertLess(told["thinning"]["points_left"], 100_000)
        self.assertGreater(told["thinning"]["cell_mm"], 0)
        self.assertLessEqual(told["thinning"]["points_left"], told["thinning"]["room_for_points"])


class Sample(Program):
    def test_can_be_inspected(self):
        path = self.dir / "bust.ply"
        self.run_it("sample", path, "--points", 5000, "--seed", 3)
        told = json.loads(self.run_it("inspect", path, "--json").stdout)
        self.assertEqual(told["scan"]["points"], 5000)

    def test_cannot_be_written_without_a_folder(self):
        done = self.run_it("sample", self.dir / "no/bust.ply", status=1)
        self.assertIn("no/bust.ply", done.stderr)


if __name__ == "__main__":
    main()
