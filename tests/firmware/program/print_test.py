#!/usr/bin/env python3
"""plumbline print and plumblined as their users see them."""

import json
import math
import re
import shutil
import signal
import subprocess
import time

from case import PLUMBLINED, SIM2K, SOURCE_DIR, Program, add_ball, box, confirm_plate, main, on_stick_printer, split, write_sphere


def ball(radius, rings=48):
    """ASCII STL."""
    at = lambda i, j: tuple(radius * c for c in (math.sin(math.pi * i / rings) * math.cos(math.pi * j / rings),
                                                 math.sin(math.pi * i / rings) * math.sin(math.pi * j / rings), math.cos(math.pi * i / rings)))
    facets = []
    for i in range(rings):
        for j in range(2 * rings):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            facets += ([(a, b, c)] if i < rings - 1 else []) + ([(a, c, d)] if i > 0 else [])
    lines = ["facet normal 0 0 0 outer loop " + " ".join("vertex %.6f %.6f %.6f" % p for p in f) + " endloop endfacet" for f in facets]
    return "\n".join(["solid ball", *lines, "endsolid ball\n"])


class Print(Program):
    def test_print_cures_the_masks_that_slice_writes_supports_included(self):
        write_sphere(self.scan)
        same = ("--supports", "auto", "--printer", SOURCE_DIR / "board" / "sim2k.toml", "--scale", 0.5)
        self.run_it("slice", self.scan, "-o", self.out, "--no-preview", *same)
        sliced = self.manifest()
        self.assertGreater(sliced["supports"]["count"], 4)
        part, report, state = self.dir / "part", self.dir / "report.json", self.dir / "state"
        done = self.run_it("print", self.scan, *same, "--keep-part", part, "--report", report)
        self.assertIn(f"supports   {sliced['supports']['count']}\n", done.stdout)
        printed = json.loads(report.read_text())
        self.assertEqual((printed["state"], printed["objections"]), ("finished", []))
        self.assertEqual([line["mask_hash"] for line in printed["exposures"]], sliced["hashes"]["layers"])
        cured = json.loads((part / "manifest.json").read_text())
        self.assertEqual(cured["hashes"], sliced["hashes"])
        self.assertEqual(cured["supports"], sliced["supports"])
        # Resume after a power cut without the scan: the stored job also has the supports.
        cut = self.run_it("print", self.scan, *same, "--state", state, "--fault", "power.cut@layer=20", status=1)
        self.assertIn("PL-901", cut.stdout)
        self.run_it("print", "--resume", "--state", state, *same[2:4], "--report", report)
        resumed = json.loads(report.read_text())
        self.assertEqual((resumed["state"], resumed["supports"]), ("finished", sliced["supports"]["count"]))
        self.assertEqual(resumed["objections"], [], "the simulated printer knows that a part is on the plate")
        self.assertEqual(resumed["layer_height_mm"], 0.05)
        self.assertLessEqual(resumed["first_layer"], 20)
        hashes = [line["mask_hash"] for line in resumed["exposures"]]
        self.assertEqual(hashes, sliced["hashes"]["layers"][resumed["first_layer"] :])

    def test_a_part_that_its_disk_has_no_room_for_is_refused_before_the_print(self):
        write_sphere(self.scan)
        disk, report = self.dir / "disk", self.dir / "report.json"
        disk.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2m", "none", disk], capture_output=True, check=False).returncode:
            self.skipTest("a small disk needs the right to mount one")
        self.addCleanup(subprocess.run, ["umount", disk], check=True)
        same = ("print", self.scan, "--printer", SIM2K, "--scale", 0.5, "--report", report)
        refused = self.run_it(*same, "--keep-part", disk / "part", status=1)
        self.assertRegex(refused.stderr, r"part: the printed part needs some [3-9]\.\d MB, 2\.\d MB are free\.\s+Make room")
        self.assertFalse(report.exists() or (disk / "part").exists())
        subprocess.run(["mount", "-o", "remount,size=8m", disk], check=True)
        self.run_it(*same, "--keep-part", disk / "part")
        # What the part takes now counts as free for the next one, which replaces it.
        subprocess.run(["mount", "-o", "remount,size=4m", disk], check=True)
        self.run_it(*same, "--keep-part", disk / "part")

    def test_layers_that_the_stages_steps_cannot_make_are_refused_before_any_light(self):
        write_sphere(self.scan)
        board = self.dir / "sim2k.toml"
        board.write_text(SIM2K.read_text().replace("microsteps = 16 ", "microsteps = 1 "))  # steps of 20 um
        (self.dir / "profiles").mkdir()
        shutil.copy(SOURCE_DIR / "board" / "profiles" / "standard.toml", self.dir / "profiles")
        same = ("--printer", board, "--scale", 0.1, "--supports", "none")
        fine, report = self.dir / "fine.sl1", self.dir / "report.json"
        self.run_it("slice", self.scan, "-o", fine, "--no-preview", "--printer", SIM2K, *same[2:], "--layer-height", 0.01)
        for what, asked in ((self.scan, (*same, "--layer-height", 0.01)), (fine, same[:2])):
            refused = self.run_it("print", what, *asked, "--report", report, status=1)
            self.assertIn("layer 0 would be 0.0200 mm high instead of 0.0100 mm", refused.stderr)
            self.assertIn("steps of 0.0200 mm; its dose would be off by 100 %", refused.stderr)
            self.assertFalse(report.exists(), "nothing was printed")

        # Off by a tenth of a layer or less: told.
        self.run_it("print", self.scan, *same, "--layer-height", 0.11, "--report", report)
        light = next(check for check in json.loads(report.read_text())["checks"] if check["check"] == "light")
        self.assertEqual(light["detail"], "a layer of 0.120 mm cures 0.121 mm deep; on the stage's steps the layers are 0.1000 to 0.1200 mm high")

    def test_what_nothing_holds_is_lost_and_named_with_layer_place_and_volume(self):
        # A ball beside another whose lower pole is 6 mm higher: it begins in the air.
        write_sphere(self.scan, radius=6)
        add_ball(self.scan, 8_000, 4, (12, 0, 4))
        part, report = self.dir / "part", self.dir / "report.json"
        same = ("print", self.scan, "--printer", SIM2K, "--keep-part", part, "--report", report)
        issues = self.dir / "issues.png"
        done = self.run_it(*same, "--supports", "none", "--issues", issues)
        self.assertEqual(issues.read_bytes(), (part / "issues.png").read_bytes())
        printed = json.loads(report.read_text())
        dropped = [lost for lost in printed["part"]["lost"] if lost["kind"] == "region dropped"]
        self.assertGreater(len(dropped), 0)
        ball = max(dropped, key=lambda lost: lost["ml"])
        self.assertAlmostEqual(ball["layer"], 6 / 0.05 + 0.2 / 0.05, delta=2, msg="raised by what cures too deep")
        self.assertAlmostEqual(ball["ml"], 4 / 3 * math.pi * 4**3 / 1000 - 0.2 * math.pi * 4**2 / 1000, delta=0.005)
        self.assertRegex(done.stdout, r"layer 1[12]\d, [0-9.]+ mm: region dropped: 0\.2\d+ ml at \([0-9.]+, [0-9.]+\) mm, layers")
        self.assertEqual(len(printed["objections"]), len(printed["part"]["lost"]))
        self.assertTrue((part / "comparison.png").exists())
        self.run_it(*same, "--supports", "auto")
        printed = json.loads(report.read_text())
        self.assertEqual((printed["objections"], printed["part"]["lost_ml"]), ([], 0))

    def test_the_part_is_measured_against_a_mesh_or_what_was_sliced(self):
        # A table of 8 x 8 x 2 mm on two legs of 3 mm, scanned upside down and half as large.
        outline = ((0, 0), (0.5, 0), (0.5, 1.5), (3.5, 1.5), (3.5, 0), (4, 0), (4, 2.5), (0, 2.5))
        front, back = ([(x, -y, -z) for x, z in outline] for y in (0, 4))
        triangles = []
        for a, b, c in ((0, 1, 2), (0, 2, 7), (7, 2, 3), (7, 3, 6), (3, 4, 5), (3, 5, 6)):
            triangles += [(front[a], front[b], front[c]), (back[a], back[c], back[b])]
        for a in range(8):
            b = (a + 1) % 8
            triangles += [(front[b], front[a], back[a]), (front[b], back[a], back[b])]
        facets = ["facet normal 0 0 0\nouter loop\n" + "".join("vertex %g %g %g\n" % p for p in t) + "endloop\nendfacet\n" for t in triangles]
        mesh, report, part = self.dir / "table.stl", self.dir / "report.json", self.dir / "part"
        mesh.write_text("solid table\n" + "".join(facets) + "endsolid table\n")
        same = ("print", mesh, "--printer", SIM2K, "--scale", 2, "--rotate-x", 180, "--supports", "none", "--accept", "--report", report)
        profile = self.dir / "profiles" / "mine.toml"
        profile.parent.mkdir()
        standard = (SOURCE_DIR / "board/profiles/standard.toml").read_text()
        standard = standard.replace("faded_layers = 8", "faded_layers = 0").replace("bottom_layer_count = 5", "bottom_layer_count = 1")
        # Of the table's underside 0.2 mm are cured too much where doses add up, unless the profile knows that they do.
        for exchange, blur, beyond in ((None, 0.5, 199.9), (0, 0.5, 0), (1, 0, 0)):
            known = "" if exchange is None else f"exchange = {exchange}"
            values = standard.replace("exchange = 0.0", known).replace("blur = 0.5", f"blur = {blur}")
            profile.write_text(values.replace('name = "standard"', 'name = "mine"'))
            found = []
            for against in (("--truth", mesh), ("--keep-part", part)):
                done = self.run_it(*same, "--profile", profile, *against)
                measured = json.loads(report.read_text())["part"]["deviation_um"]
                self.assertRegex(done.stdout, r"deviation  \d+ um RMS from (table.stl|r-rep), undersides [+-]\d+ um \(\d+ um RMS about it\), walls ")
                # In the corners below the table nothing is left open.
                self.assertLess(measured["missing"], 0.04 * measured["points"])
                self.assertLess(measured["missing"] - measured["sealed"], 0.001 * measured["points"], "rounded corners")
                found.append(measured)
            self.assertEqual([measured["against"] for measured in found], ["table.stl", "r-rep"])
            for measured in found:
                # A quarter of what faces down are the legs' feet, which the plate holds.
                self.assertAlmostEqual(measured["down_mean"] / 0.75, beyond, delta=8 if beyond else 25, msg="half a layer")
                self.assertLess(measured["top_rms"], 1)
            self.assertAlmostEqual(found[0]["rms"], found[1]["rms"], delta=16, msg="the R-Rep's edges are left out")
            if exchange is None:
                self.run_it(*same, "--profile", profile, "--grey", "vertical", status=1)
                continue
            self.run_it(*same, "--profile", profile, "--grey", "vertical", "--truth", mesh)
            measured = json.loads(report.read_text())
            self.assertEqual(measured["contract"]["grey"], "vertical")
            self.assertAlmostEqual(measured["part"]["deviation_um"]["down_mean"] / 0.75, 0, delta=4, msg="no half layer is left")
        self.run_it(*same)
        self.assertIsNone(json.loads(report.read_text())["part"]["deviation_um"], "nothing of the part was kept")

    def test_layers_are_as_high_as_the_surface_allows(self):
        report, state, mesh = self.dir / "report.json", self.dir / "state", self.dir / "ball.stl"
        mesh.write_text(ball(4.0))
        same = ("print", mesh, "--printer", "sim2k", "--supports", "auto", "--support-stand", "raised", "--report", report, "--truth", mesh)
        found = {}
        for height in ("0.05", "adaptive"):
            done = self.run_it(*same, "--layer-height", height)
            printed = found[height] = json.loads(report.read_text())
            self.assertEqual((printed["state"], printed["objections"], printed["late_masks"]), ("finished", [], 0))
            self.assertAlmostEqual(printed["elapsed_s"] / printed["estimated_s"], 1, delta=0.02)
        self.assertRegex(done.stderr + done.stdout, r"heights    0.02 to 0.1 mm, as the surface allows: \d+ layers where \d+ would be 0.05 mm high")
        even, adaptive = found["0.05"], found["adaptive"]
        self.assertLess(adaptive["part"]["deviation_um"]["top_rms"], 0.6 * even["part"]["deviation_um"]["top_rms"])
        self.assertLess(abs(adaptive["part"]["deviation_um"]["down_mean"]), 10)
        self.assertAlmostEqual(adaptive["resin_ml"], even["resin_ml"], delta=0.03 * even["resin_ml"])
        # Each layer's light follows its height: in its layer of 0.1 mm the light goes as far beyond as in one of 0.05 mm.
        lit = sorted({round(line["asked_s"], 3) for line in adaptive["exposures"][13:]})
        self.assertEqual(lit, [round(2.5 * math.exp((mm - 0.05) / 0.12), 3) for mm in (0.02, 0.06, 0.1)])
        # Resumed, it goes on with the same layers at the same heights.
        self.run_it(*same, "--layer-height", "adaptive", "--state", state, "--fault", "power.cut@layer=90", status=1)
        self.run_it("print", "--resume", "--state", state, "--printer", "sim2k", "--report", report)
        resumed = json.loads(report.read_text())
        self.assertEqual((resumed["state"], resumed["objections"]), ("finished", []))
        hashes = [line["mask_hash"] for line in adaptive["exposures"]]
        self.assertEqual([line["mask_hash"] for line in resumed["exposures"]], hashes[resumed["first_layer"] :])
        refused = self.run_it("slice", mesh, "-o", self.out, "--printer", "sim2k", "--layer-height", "adaptive", status=1)
        self.assertIn("--layer-height adaptive is for prints: in files all layers have one height", refused.stderr)

    def test_files_of_one_frame_are_one_print(self):
        write_sphere(self.scan)
        same = ("--printer", SIM2K, "--scale", 0.2)
        self.run_it("slice", self.scan, "-o", self.out, "--no-preview", *same)
        top, bottom, report = self.dir / "top.ply", self.dir / "bottom.ply", self.dir / "report.json"
        split(self.scan, 7000, top, bottom)
        self.run_it("print", top, bottom, *same, "--report", report)
        hashes = [line["mask_hash"] for line in json.loads(report.read_text())["exposures"]]
        self.assertEqual(hashes, self.manifest()["hashes"]["layers"])

    def test_report_is_short_and_verbose_adds_the_figures(self):
        write_sphere(self.scan)
        same = ("print", self.scan, "--printer", SIM2K, "--scale", 0.5, "--supports", "auto")
        short, long = self.run_it(*same), self.run_it(*same, "--verbose")
        for words in ("finished", "time ", "resin ", "no objections"):
            self.assertIn(words, short.stdout)
        for words in ("doses ", "masks ", "slowest "):
            self.assertNotIn(words, short.stdout)
            self.assertIn(words, long.stdout)
        self.assertRegex(short.stderr, r"printing layer 1 of \d+, .* left")
        self.assertNotIn("slack", short.stderr)
        self.assertNotIn("check memory", short.stderr)
        self.assertIn("check memory", long.stderr)

    def test_a_fault_gives_its_advice_once(self):
        write_sphere(self.scan)
        done = self.run_it("print", self.scan, "--printer", SIM2K, "--scale", 0.05, "--fault", "panel.dead@layer=2", status=1)
        self.assertIn("PL-202, panel does not answer", done.stdout)
        self.assertEqual(done.stdout.count("cable"), 1, done.stdout)

    def test_an_exposure_test_gives_each_strip_its_time_also_after_a_power_cut(self):
        bar, state, report = self.dir / "bar.stl", self.dir / "state", self.dir / "report.json"
        bar.write_text(f"solid part\n{box((0, 0, 0), (12, 6, 2))}endsolid part\n")
        same = ("print", bar, "--printer", SIM2K, "--supports", "none", "--report", report)
        self.run_it("print", bar, "--printer", SIM2K, "--supports", "none", "--quiet", "--exposure-test", "2.4s,2s", status=2)
        test = ("--exposure-test", "1.6s,2s,2.4,2.8s", "--state", state, "--fault", "power.cut@layer=20+1.8s")
        cut = self.run_it(*same, *test, status=1)
        self.assertIn("test       strips along x, from where the object begins: 0.0 to 3.0 mm 1.6 s, 3.0 to 6.0 mm 2 s, ", cut.stdout + cut.stderr)
        self.run_it("print", "--resume", "--state", state, "--printer", SIM2K, "--report", report, "--quiet")
        printed = json.loads(report.read_text())
        self.assertEqual((printed["state"], printed["objections"]), ("finished", []))
        strips = printed["contract"]["exposure_test"]
        self.assertEqual([(one["strip"], one["exposure_s"]) for one in strips], [(1, 1.6), (2, 2), (3, 2.4), (4, 2.8)])
        self.assertAlmostEqual(strips[1]["to_mm"], 6, delta=0.05)
        layer = [(one["exposure"], one["asked_s"]) for one in printed["exposures"] if one["layer"] == 30]
        self.assertEqual(layer, [(0, 1.6), (1, 0.4), (2, 0.4), (3, 0.4)])

    def test_resume_takes_what_is_stored_and_nothing_else(self):
        state = self.dir / "state"
        for more in (("x.ply",), ("--supports", "auto"), ("--support-head-width", 2), ("--truth", "x.stl"), ("--exposure-test", "2,3")):
            done = self.run_it("print", *more, "--resume", "--state", state, "--printer", SIM2K, status=2)
            self.assertIn("excludes", done.stderr)
        done = self.run_it("print", "--resume", "--state", state, "--printer", SIM2K, status=1)
        self.assertIn("no interrupted print", done.stderr)

    def measured(self, mesh, name, printer, *more):
        """What a print of a mesh deviates from it, and its report."""
        report = self.dir / f"{name}.json"
        self.run_it("print", mesh, "--printer", printer, "--supports", "none", "--truth", mesh, "--report", report, "--quiet", *more)
        printed = json.loads(report.read_text())
        self.assertEqual((printed["state"], printed["objections"], printed["late_masks"]), ("finished", [], 0))
        return printed["part"]["deviation_um"], printed

    def test_an_outline_of_the_bottom_layers_gets_no_more_light_than_others(self):
        # A block whose bottom layers get 30 s; one that stands on a foot of 1 mm beside it loses nothing.
        mesh, profile = self.dir / "part.stl", self.dir / "mine.toml"
        boxes = box((8, 0, 0), (12, 4, 1.5)) + box((1.5, 1.5, 0), (2.5, 2.5, 1)) + box((0, 0, 1), (4, 4, 1.5))
        mesh.write_text(f"solid part\n{box((0, 0, 0), (6, 6, 1.2))}endsolid part\n")
        text = (SOURCE_DIR / "board/profiles/standard.toml").read_text()
        spread, exposures = {}, {}
        for foot in ("0.0", "0.1", "0.6"):
            profile.write_text(text.replace("elefant_foot_compensation = 0.0", f"elefant_foot_compensation = {foot}"))
            deviation, printed = self.measured(mesh, foot, SIM2K, "--profile", profile)
            spread[foot], exposures[foot] = deviation["wall_rms"], printed["exposures"]
        self.assertGreater(spread["0.0"], 12)
        self.assertLess(spread["0.1"], 6)
        self.assertLess(spread["0.6"], 6)
        self.assertEqual([(one["layer"], one["exposure"], one["asked_s"]) for one in exposures["0.1"][:4]],
                         [(0, 0, 2.5), (0, 1, 27.5), (1, 0, 2.5), (1, 1, 27.5)])  # fmt: skip
        self.assertEqual(len(exposures["0.1"]), len(exposures["0.0"]) + 13)
        self.assertEqual({one["mask_hash"] for one in exposures["0.1"]}, {one["mask_hash"] for one in exposures["0.0"]})
        mesh.write_text(f"solid part\n{boxes}endsolid part\n")
        _, printed = self.measured(mesh, "small", SIM2K, "--profile", profile, "--accept")
        self.assertEqual((printed["part"]["lost"], printed["issues"]["falls_ml"], printed["issues"]["torn_ml"]), ([], 0, 0))

    def test_exposures_of_a_panel_of_black_and_white_cure_grey_as_a_grey_panel_does(self):
        # A beam whose underside rises by 2.5 mm over 8.
        mesh = self.dir / "part.stl"
        profile = ((0, 0), (4, 0), (4, 1.5), (12, 4), (12, 5.5), (0, 5.5))
        facets = []
        for corners in ((0, 1, 2), (0, 2, 5), (2, 3, 4), (2, 4, 5)):
            side = [profile[i] for i in corners]
            facets += [[(x, 0, z) for x, z in side], [(x, 6, z) for x, z in reversed(side)]]
        for (x, z), (u, w) in zip(profile, profile[1:] + profile[:1]):
            facets += [[(x, 0, z), (x, 6, z), (u, 6, w)], [(x, 0, z), (u, 6, w), (u, 0, w)]]
        lines = ["facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*v) for v in facet) + "endloop\nendfacet\n"
                 for facet in facets]  # fmt: skip
        mesh.write_text("solid part\n" + "".join(lines) + "endsolid part\n")
        text = SIM2K.read_text()
        found, times = {}, {}
        for name, key in (("levels", "grey_exposures = 0"), ("bits", "grey_exposures = 3"), ("none", "grey_exposures = 0")):
            board = self.dir / f"{name}.toml"
            board.write_text(text.replace('name = "sim2k"', f'name = "{name}"').replace("grey_exposures = 0", key)
                             .replace("grey_levels = 256", f"grey_levels = {256 if name == 'levels' else 2}"))  # fmt: skip
            standard = SOURCE_DIR / "board/profiles/standard.toml"
            grey = () if name == "none" else ("--grey", "vertical")
            found[name], printed = self.measured(mesh, name, board, "--profile", standard, *grey)
            times[name] = printed["elapsed_s"]
            exposures = printed["exposures"]
            asked = 5 * 30 + 8 * 16.25 + (printed["layers"] - 13) * 2.5
            self.assertAlmostEqual(sum(one["asked_s"] for one in exposures), asked, places=3)
            if name == "bits":
                self.assertTrue(1.5 * printed["layers"] < len(exposures) < 4 * printed["layers"])
            else:
                self.assertEqual(len(exposures), printed["layers"])
        for figure in ("rms", "down_mean", "down_rms", "wall_mean"):
            self.assertAlmostEqual(found["bits"][figure], found["levels"][figure], delta=0.5)
        self.assertGreater(found["none"]["down_rms"], found["bits"]["down_rms"] + 1)
        self.assertLess(times["bits"] - times["levels"], 0.11 * printed["layers"])

    def test_supports_come_from_the_profile_by_default(self):
        write_sphere(self.scan)
        profile, report = self.dir / "mine.toml", self.dir / "report.json"
        text = (SOURCE_DIR / "board/profiles/standard.toml").read_text()
        profile.write_text(text)
        same = ("print", self.scan, "--printer", SIM2K, "--scale", 0.5, "--profile", profile, "--report", report, "--quiet")
        counts = []
        for more in ((), ("--supports", "none"), ("--support-overhang-angle", 80)):
            self.run_it(*same, *more)
            counts.append(json.loads(report.read_text())["supports"])
        self.assertGreater(counts[0], 0)
        self.assertEqual(counts[1], 0)
        self.assertGreater(counts[2], counts[0])
        profile.write_text(re.sub("supports_enable = true", "supports_enable = false", text))
        self.run_it(*same)
        self.assertEqual(json.loads(report.read_text())["supports"], 0)
        done = self.run_it(*same, "--supports", "none", "--support-head-width", 2, status=1)
        self.assertIn("support_head_width is given, but supports are off", done.stderr)

    def test_lamp_line_is_lit_as_long_as_every_exposure(self):
        write_sphere(self.scan)
        line, report = self.dir / "line", self.dir / "report.json"
        same = ("print", self.scan, "--printer", SIM2K, "--scale", 0.02, "--lamp-line", f"file:{line}")
        done = self.run_it(*same, status=1)
        self.assertIn("--speedup", done.stderr)
        self.run_it(*same, "--speedup", 100, "--report", report, "--quiet")
        asked = [exposure["asked_s"] for exposure in json.loads(report.read_text())["exposures"]]
        changes = [text.split() for text in line.read_text().splitlines()]
        self.assertEqual([word for word, _ in changes], ["on", "off"] * len(asked))
        times = [int(at) for _, at in changes]
        for on, off, seconds in zip(times[::2], times[1::2], asked):
            self.assertLess((off - on) / 1e9, seconds / 100 + 0.05)


class Daemon(Program):
    """Plays the user: a folder that comes and goes, and signals."""

    def setUp(self):
        super().setUp()
        self.stick, self.state = self.dir / "stick", self.dir / "state"

    def start(self, *arguments, speedup=1e6, on_stick=True):
        """@param on_stick  the stick starts its print, onto a plate that somebody has confirmed"""
        printer = SIM2K
        if on_stick:
            printer = on_stick_printer(self.dir)
            confirm_plate(self.state)
        place = ("--printer", printer, "--state", self.state, "--stick", self.stick)
        return self.start_daemon(*place, "--speedup", speedup, *arguments)

    def put_stick(self, *scans, job="", radius=2):
        """Plugs a stick in: all its files appear at once."""
        folder = self.dir / "new"
        folder.mkdir()
        for name in scans:
            write_sphere(folder / name, points=5000, radius=radius)
        if job:
            (folder / "job.toml").write_text(job)
        folder.rename(self.stick)

    def ends(self, daemon, status):
        out, err = daemon.communicate(timeout=60)
        self.assertEqual(daemon.returncode, status, err)
        return out, err

    def control(self, *command, status=0):
        return self.run_it("ctl", *command, "--socket", self.state / "state", status=status)

    def test_prints_what_somebody_wants_from_the_stick_and_waits_for_an_empty_plate(self):
        daemon = self.start("--jobs", 2, on_stick=False)
        self.until(daemon, "is the plate empty?")
        self.control("plate-empty")
        self.until(daemon, "ready")
        self.put_stick("a.ply", "b.ply", job='[job]\nscan = "b.ply"\nprofile = "draft"\nsupports = "auto"\n', radius=6)
        self.until(daemon, "job.toml asks for b.ply. Press start to print it")
        self.control("start")
        self.until(daemon, "is the plate empty?")
        report = json.loads((self.state / "report.json").read_text())
        self.assertEqual((report["state"], report["scan"], report["profile"]), ("finished", "b.ply", "draft"))
        self.assertGreater(report["supports"], 0)
        shutil.rmtree(self.stick)
        time.sleep(0.3)
        self.put_stick("c.ply")
        time.sleep(1)
        self.control("plate-empty")
        said = self.until(daemon, "c.ply. Press start to print it")
        self.assertNotIn("reading", said)
        self.control("start")
        out, _ = self.ends(daemon, 0)
        self.assertEqual(out.count("finished"), 2, out)

    def test_an_absent_daemon_takes_no_command(self):
        self.assertIn("no plumblined serves its state at", self.refused())
        self.start().send_signal(signal.SIGKILL)
        self.assertIn("no plumblined serves its state at", self.refused())

    def refused(self):
        self.state.mkdir(exist_ok=True)
        return self.control("start", status=1).stderr

    def test_a_printer_that_is_not_wired_is_refused_before_the_scan_is_opened(self):
        done = self.run_it("print", self.scan, "--printer", SOURCE_DIR / "board" / "mono2k.toml", status=1)
        self.assertRegex(done.stderr, "how the printer is wired|simulated printers only")

    def test_names_of_files_forge_no_line(self):
        forged = self.dir / "a\nplumbline: PL-301, lamp stuck on\x1b[31m\u202e.ply"
        write_sphere(forged, points=5000, radius=2)
        report = self.dir / "report.json"
        runs = [self.run_it("print", forged, "--printer", SIM2K, "--report", report)]
        runs.append(self.run_it("slice", forged, "-o", self.out, "--verbose"))
        runs.append(self.run_it("inspect", forged, "--verbose"))
        forged.write_text("ply\n")
        runs.append(self.run_it("inspect", forged, status=1))
        for done in runs:
            for text in (done.stdout, done.stderr):
                self.assertNotRegex(text, r"[\x00-\x09\x0b-\x1f\x7f\u202e]")
                self.assertFalse([line for line in text.splitlines() if line.startswith("plumbline: PL-301")], text)
        shown = "a\\x0aplumbline: PL-301, lamp stuck on\\x1b[31m\\u{202e}.ply"
        self.assertIn(json.loads(report.read_text())["scan"][:20], shown)
        self.assertIn(shown, (self.out / "manifest.json").read_text().replace("\\\\", "\\"))

    def test_command_line_prints_onto_a_plate_that_somebody_says_is_empty(self):
        write_sphere(self.scan)
        real = ("print", self.scan, "--printer", SOURCE_DIR / "board" / "rig.toml", "--state", self.state, "--quiet")
        self.assertIn("add --plate-empty", self.run_it(*real, status=1).stderr)
        # A simulated printer's plate is a new one each time, but the record is kept for the daemon.
        (self.state / "plate-is-empty").touch()
        self.run_it(*real[:2], "--printer", SIM2K, *real[4:], "--scale", 0.05)
        self.assertEqual([path.name for path in self.state.iterdir()], ["machine"])
        self.assertIn("add --plate-empty", self.run_it(*real, status=1).stderr, "there is a part on it now")
        self.run_it(*real[:2], "--printer", SIM2K, *real[4:], "--scale", 0.05)

    def test_prints_from_a_stick_what_the_same_options_slice(self):
        write_sphere(self.scan, radius=6)
        self.cut_below(2)
        add_ball(self.scan, 200, 0.4, (14, 0, 3))
        sliced = set()
        for job, options in (("", ()), ('base = "none"', ("--base", "none")), ("keep_all = true", ("--keep-all",))):
            # Tilt the scan, so that the hole's rim is not level and each option makes a different part.
            same = ("--printer", SIM2K, "--layer-height", 0.05, "--rotate-x", 20, *options)
            self.run_it("slice", self.scan, "-o", self.out, "--no-preview", *same)
            hashes = self.manifest()["hashes"]["layers"]
            sliced.add(tuple(hashes))
            folder = self.dir / "new"
            folder.mkdir()
            shutil.copy(self.scan, folder / "a.ply")
            (folder / "job.toml").write_text(f'[job]\nscan = "a.ply"\n{job}\n[placement]\nrotate_x_deg = 20\nlayer_height = 0.05\n')
            folder.rename(self.stick)
            self.ends(self.start("--jobs", 1), 0)
            shutil.rmtree(self.stick)
            report = json.loads((self.state / "report.json").read_text())
            self.assertEqual([line["mask_hash"] for line in report["exposures"]], hashes, job)
        self.assertEqual(len(sliced), 3, "each option makes another part")

    def test_a_bad_stick_is_reported_and_the_next_one_works(self):
        daemon = self.start("--jobs", 1)
        self.until(daemon, "ready")
        self.put_stick("a.ply", job='[job]\nscan = "a.ply"\nsupports = "yes"\n')
        said = self.until(daemon, "PL-106")
        self.assertIn("job.toml:3: [job] supports: found a string 'yes', allowed is one of the strings none or auto. Correct", said)
        shutil.rmtree(self.stick)
        time.sleep(0.3)
        self.put_stick("a.ply")
        self.ends(daemon, 0)

    def test_advice_is_for_a_user_with_a_stick_and_buttons(self):
        daemon = self.start("--jobs", 1)
        self.until(daemon, "ready")
        self.put_stick("a.ply", job='[job]\nscan = "a.ply"\n[placement]\nscale = 1000\n')
        said = self.until(daemon, "PL-105")
        self.assertNotIn("--", said)
        self.assertIn("Under Settings", said)
        shutil.rmtree(self.stick)
        time.sleep(0.3)
        self.put_stick("a.ply")
        self.ends(daemon, 0)

    def test_ends_on_sigterm_and_resumes_the_print_later(self):
        self.put_stick("a.ply")
        daemon = self.start(speedup=50)
        self.until(daemon, "the stick may be pulled")
        time.sleep(2)
        daemon.send_signal(signal.SIGTERM)
        self.ends(daemon, 0)
        shutil.rmtree(self.stick)
        daemon = self.start()
        self.until(daemon, "an interrupted print can go on")
        daemon.send_signal(signal.SIGTERM)
        self.ends(daemon, 0)
        report = self.dir / "report.json"
        self.run_it("print", "--resume", "--state", self.state, "--printer", SIM2K, "--report", report)
        self.assertEqual(json.loads(report.read_text())["state"], "finished")

    def test_help_teaches(self):
        done = subprocess.run([PLUMBLINED, "--help"], capture_output=True, text=True, timeout=60, check=True)
        for words in ("job.toml", "--state", "--stick", "Examples:"):
            self.assertIn(words, done.stdout)


if __name__ == "__main__":
    main()
