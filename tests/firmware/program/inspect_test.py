#!/usr/bin/env python3
"""plumbline inspect, orient and sample as users run them."""

import json
import math
import struct
import subprocess

from case import add_ball, U64, Program, main, turn_normals, write_sphere


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
        self.assertAlmostEqual(told["largest_scale"], 29.0 / 24, delta=0.01)
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
        # A ball is lifted by 5 mm, above a raft of 0.8 mm.
        self.assertAlmostEqual(told["now"]["layers"] * 0.05, told["now"]["height_mm"] + 5.8, delta=0.5)
        # All are of one size, and have supports that were counted.
        for way in told["best"]:
            self.assertAlmostEqual(way["height_mm"], 24, delta=0.5)
            self.assertGreater(way["tips"], 0)
            self.assertLess(way["tip_scars_mm2"], way["tips"] * 0.3)
            self.assertLess(math.cos(math.radians(way["rotate_x_deg"])) * math.cos(math.radians(way["rotate_y_deg"])), math.cos(math.radians(19.9)))
        clean = json.loads(self.run_it("orient", self.scan, "--json", "--keep-clean", "-z").stdout)
        self.assertNotEqual(clean["cheapest"], 0)

    def test_a_proposal_is_printed_as_it_was_shown(self):
        write_sphere(self.scan)
        add_ball(self.scan, 20_000, 6, (14, 0, 9))
        way = json.loads(self.run_it("orient", self.scan, "--json", "--height", "20mm").stdout)["best"][0]
        turned = ("--rotate-x", way["rotate_x_deg"], "--rotate-y", way["rotate_y_deg"])
        self.slice_it(*turned, "--height", "20mm", "--no-preview", "--supports", "none")
        self.assertAlmostEqual(self.manifest()["size_mm"][2], way["height_mm"], delta=0.01 * way["height_mm"])

    def test_orient_refuses_a_mesh_without_area(self):
        mesh = self.dir / "line.obj"
        mesh.write_text("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n")
        for arguments in ((mesh,), (mesh, "--json")):
            done = self.run_it("orient", *arguments, status=1)
            self.assertRegex(done.stderr, r"line\.obj: its 1 triangle has no area: .* Export it again")
            self.assertEqual(done.stdout, "")

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

    def test_draws_where_the_checks_find_something(self):
        write_sphere(self.scan)
        self.cut_below(-8)  # so that it stands on a disc
        picture = self.dir / "issues.png"
        self.run_it("inspect", self.scan, "--issues", picture)
        self.assertFalse(picture.exists())
        add_ball(self.scan, 20_000, 6, (24, 0, 4))
        done = self.run_it("inspect", self.scan, "--issues", picture)
        self.assertIn("piece that nothing holds", done.stdout)
        self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        done = self.run_it("inspect", self.scan, "--issues", self.dir / "no/issues.png", status=1)
        self.assertIn("no/issues.png", done.stderr)

    def test_reads_a_pipe_too(self):
        write_sphere(self.scan)
        with open(self.scan, "rb") as scan:
            cat = subprocess.Popen(["cat"], stdin=scan, stdout=subprocess.PIPE)
            done = self.run_it("inspect", "/dev/stdin", stdin=cat.stdout)
            cat.stdout.close()
            cat.wait()
        self.assertRegex(done.stdout, r"scanned    (99\.\d|100\.0) % of the surface; closed: underside 0\.0 %")

    def test_reports_a_mesh_that_is_smaller_than_any_pixel(self):
        mesh = self.dir / "tiny.obj"
        mesh.write_text("v 0 0 0\nv 1e-9 0 0\nv 0 1e-9 0\nv 0 0 1e-9\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        self.assertIn("4 triangles", self.run_it("inspect", mesh, "--printer", self.board).stdout)

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
