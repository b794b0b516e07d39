#!/usr/bin/env python3
"""plumbline slice as users run it: files, output, exit status, signals, memory."""

import json
import math
import os
import pty
import re
import signal
import subprocess
import unittest

from case import PLUMBLINE, Program, job_hash, layer_hash, main, png_rows, split, write_sphere


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
            columns, rows = png_rows((self.out / "layers" / name).read_bytes())
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

    def test_masks_do_not_depend_on_the_number_of_threads(self):
        jobs = set()
        for threads in (1, 2, 3, 8):
            self.slice_it("--threads", threads, "--no-preview")
            jobs.add(json.dumps(self.manifest()["hashes"]))
        self.assertEqual(len(jobs), 1)

    def test_threads_default_to_openmp_s(self):
        self.slice_it("--no-preview", env={**os.environ, "OMP_NUM_THREADS": "3"})
        self.assertEqual(self.manifest()["threads"], 3)

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

    def test_a_terminal_gets_one_bar_for_the_whole(self):
        write_sphere(self.scan)
        process, terminal = pty.fork()
        if process == 0:
            os.execv(PLUMBLINE, [str(PLUMBLINE), "slice", str(self.scan), "-o", str(self.out), "--pixel-pitch", "0.05", "--layer-height", "0.05"])
        said = b""
        try:
            while data := os.read(terminal, 65536):
                said += data
        except OSError:  # it has ended
            pass
        os.close(terminal)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), 0)
        shares = [int(share) for share in re.findall(r"[#.]{24} +(\d+) %", said.decode())]
        self.assertEqual(shares, sorted(shares))
        self.assertEqual((shares[0], shares[-1], shares.count(100)), (0, 100, 1))
        self.assertGreater(len(set(shares)), 5)

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


if __name__ == "__main__":
    main()
