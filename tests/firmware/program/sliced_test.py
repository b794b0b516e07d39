#!/usr/bin/env python3
"""Prints that somebody else has sliced: .sl1 archives and zips of PNG files, for print, check, inspect and the daemon."""

import json
import os
import shutil
import signal
import struct
import subprocess
import unittest
import zipfile
import zlib

from case import SIM2K, Program, confirm_plate, main, on_stick_printer

MONO2K = SIM2K.with_name("mono2k.toml")  # the same panel without grey


def write_ell(path, height=2.0):
    """An L with a long and a short leg, so that no mirror image or turn of it is the same: 20 x 10 mm."""
    outline = [(0, 0), (20, 0), (20, 4), (6, 4), (6, 10), (0, 10)]
    flat = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    corner = lambda i, z: (*outline[i], z)
    faces = [[corner(i, 0) for i in reversed(face)] for face in flat] + [[corner(i, height) for i in face] for face in flat]
    for i in range(6):
        j = (i + 1) % 6
        faces += [[corner(i, 0), corner(j, 0), corner(j, height)], [corner(i, 0), corner(j, height), corner(i, height)]]
    with open(path, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", len(faces)))
        for face in faces:
            file.write(bytes(12) + b"".join(struct.pack("<3f", *corner) for corner in face) + bytes(2))


def png(columns, rows, pixels, depth=8, colour=0, extra=b""):
    """@param pixels  of all rows, filter bytes included"""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", columns, rows, depth, colour, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + extra + chunk(b"IDAT", zlib.compress(pixels)) + chunk(b"IEND", b"")


def square(size=200, island=0):
    """A white square in the middle of the panel of sim2k, in grey, and to its right a smaller one."""
    empty, row = bytes(1441), bytearray(1441)
    row[700 - size // 2 : 700 + size // 2] = b"\xff" * size
    both = row[:1000] + b"\xff" * island + row[1000 + island :]
    return png(1440, 2560, empty * 1000 + bytes(both) * island + bytes(row) * (size - island) + empty * (1560 - size))


def rgb_of(path):
    """Columns, rows and pixels of an RGB picture whose lines are stored as differences to the one above."""
    data, at, stream = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        if kind == b"IHDR":
            columns, rows = struct.unpack(">II", data[at + 8 : at + 16])
        if kind == b"IDAT":
            stream += data[at + 8 : at + 8 + length]
        at += 12 + length
    raw, pixels, above = zlib.decompress(stream), [], bytes(3 * columns)
    for line in (raw[at : at + 3 * columns + 1] for at in range(0, len(raw), 3 * columns + 1)):
        above = bytes((a + b) & 255 for a, b in zip(line[1:], above))
        pixels += zip(above[::3], above[1::3], above[2::3])
    return columns, rows, pixels


def exposures(report):
    return json.loads(report.read_text())["exposures"]


class Sliced(Program):
    same = ("--printer", SIM2K, "--layer-height", 0.1, "--supports", "none")

    def setUp(self):
        super().setUp()
        self.mesh, self.part, self.state = self.dir / "ell.stl", self.dir / "part.sl1", self.dir / "state"
        self.report = self.dir / "report.json"
        write_ell(self.mesh)

    def make_part(self):
        self.run_it("slice", self.mesh, "-o", self.part, "--no-preview", *self.same)

    def layer_hashes(self):
        self.run_it("slice", self.mesh, "-o", self.out, "--no-preview", *self.same)
        return self.manifest()["hashes"]["layers"]

    def pack(self, layers, ini="", name="part.zip"):
        path = self.dir / name
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for entry, body in layers.items():
                archive.writestr(entry, body)
            if ini:
                archive.writestr("prusaslicer.ini", ini)
        return path

    def print_it(self, part, *arguments, status=0):
        return self.run_it("print", part, "--printer", SIM2K, "--accept", "--report", self.report, *arguments, status=status)


class Printed(Sliced):
    def test_prints_the_masks_bit_for_bit_and_goes_on_after_a_power_cut(self):
        self.make_part()
        hashes = self.layer_hashes()
        self.print_it(self.part)
        printed = exposures(self.report)
        self.assertEqual([line["mask_hash"] for line in printed], hashes)
        self.assertEqual(json.loads(self.report.read_text())["state"], "finished")
        self.print_it(self.part, "--state", self.state, "--fault", "power.cut@layer=8", status=1)
        self.assertEqual((self.state / "archive").read_bytes(), self.part.read_bytes())
        self.part.unlink()
        self.run_it("print", "--resume", "--state", self.state, "--printer", SIM2K, "--report", self.report)
        resumed = json.loads(self.report.read_text())
        self.assertEqual((resumed["state"], resumed["scan"], resumed["objections"]), ("finished", "part.sl1", []))
        self.assertGreater(resumed["first_layer"], 0)
        self.assertEqual([line["mask_hash"] for line in resumed["exposures"]], hashes[resumed["first_layer"] :])
        self.assertFalse((self.state / "archive").exists(), "a print that has ended leaves nothing")

    def test_exposures_are_the_archives(self):
        ini = "exposure_time = 2.25\ninitial_exposure_time = 6\nfaded_layers = 0\nlayer_height = 0.05\n"
        part = self.pack({f"a{k:03}.png": square() for k in range(8)}, ini + "display_mirror_y = 1\n", "other.sl1")
        self.print_it(part)
        asked = [line["asked_s"] for line in exposures(self.report)]
        self.assertEqual(set(asked), {2.25, 6})
        self.assertEqual(json.loads(self.report.read_text())["layer_height_mm"], 0.05)
        for seconds, words in ((61, "other.sl1: its exposure of a layer is 61 s, this printer's lamp may be lit for 60 s at most"),
                               (121, "other.sl1: prusaslicer.ini: exposure_time is '121', allowed is 0.1 to 120 s. Export it again")):
            part = self.pack({"1.png": square()}, ini.replace("2.25", str(seconds)), "other.sl1")
            self.assertIn(words, self.print_it(part, status=1).stderr)

    def test_first_layer_is_as_high_as_the_archive_says(self):
        layers = {f"a{k:03}.png": square() for k in range(4)}
        same = self.pack(layers, "layer_height = 0.05\ninitial_layer_height = 0.05\n", "same.sl1")
        high = self.pack(layers, "layer_height = 0.05\ninitial_layer_height = 0.15\n", "high.sl1")
        summaries = [self.print_it(part).stdout for part in (same, high)]
        self.assertIn("4 of 4 layers, 0.20 mm", summaries[0])
        self.assertIn("4 of 4 layers, 0.30 mm", summaries[1])
        self.assertEqual(json.loads(self.report.read_text())["objections"], [])
        dark = self.pack(layers, "layer_height = 0.05\ninitial_layer_height = 0.9\n", "dark.sl1")
        self.assertIn("the first layer of 0.900 mm cures ", self.print_it(dark, status=1).stdout)

    def test_layers_may_be_any_png(self):
        grey = png(1440, 2560, (b"\0" + bytes(500) + b"\xff" * 300 + bytes(640)) * 2560)
        rgb = png(1440, 2560, (b"\0" + bytes(1500) + b"\xff" * 900 + bytes(1920)) * 2560, colour=2)
        for layer in (grey, rgb):
            self.print_it(self.pack({"1.png": layer, "2.png": layer}))
            if layer is grey:
                hashes = [line["mask_hash"] for line in exposures(self.report)]
        self.assertEqual([line["mask_hash"] for line in exposures(self.report)], hashes)

    def test_transparent_pixels_are_black(self):
        clear, white = b"\xff\xff\xff\0", b"\xff\xff\xff\xff"
        layer = png(1440, 2560, (b"\0" + clear * 500 + white * 300 + clear * 640) * 2560, colour=6)
        grey = png(1440, 2560, (b"\0" + bytes(500) + b"\xff" * 300 + bytes(640)) * 2560)
        volumes = [json.loads(self.run_it("check", self.pack({"1.png": body}), "--printer", SIM2K, "--json").stdout)["volume_ml"]
                   for body in (layer, grey)]
        self.assertEqual(volumes[0], volumes[1])

    def test_grey_is_counted(self):
        row = b"\0" + bytes(500) + b"\x7f" * 100 + b"\xff" * 280 + b"\x80" * 20 + bytes(540)
        part = self.pack({f"{k}.png": png(1440, 2560, row * 2560) for k in (1, 2)})
        told = json.loads(self.run_it("check", part, "--printer", SIM2K, "--json").stdout)["grey"]
        self.assertEqual(told, {"lit_pixels": 400 * 5120, "grey_pixels": 120 * 5120, "lost_pixels": 100 * 5120})
        text = self.run_it("check", part, "--printer", MONO2K).stdout
        self.assertIn("30.0 % of the area is neither black nor white: 25.0 % becomes black, 5.0 % white", text)
        self.assertIn("30.0 % of the area is neither black nor white\n", self.run_it("check", part, "--printer", SIM2K).stdout)

    def test_grey_cures_on_a_panel_that_shows_it(self):
        """A square of 200 pixels, and beside it 50 columns each of 120 and 60 of 255: of 8.75 mJ/cm2, with 3.2 to cure, 4.1 and 2.1."""
        row = b"\0" + bytes(500) + b"\xff" * 200 + b"\x78" * 50 + b"\x3c" * 50 + bytes(640)
        layer = png(1440, 2560, bytes(1441) * 1000 + row * 200 + bytes(1441) * 1360)
        ini = "exposure_time = 2.5\ninitial_exposure_time = 2.5\nfaded_layers = 3\nlayer_height = 0.05\n"
        part = self.pack({f"{k:02}.png": layer for k in range(12)}, ini)
        hashes = {}
        for printer, columns in ((SIM2K, 250), (MONO2K, 200)):
            kept = self.dir / printer.stem
            done = self.run_it("print", part, "--printer", printer, "--simulate", "--accept", "--keep-part", kept, "--report", self.report)
            contract = json.loads(self.report.read_text())["contract"]
            self.assertEqual((contract["grey_percent"], contract["shows_grey"]), (33.333, printer == SIM2K))
            self.assertEqual(contract["grey_lost_percent"], 0 if printer == SIM2K else 33.333)
            self.assertEqual("33.3 % of its area grey: the panel shows black or white, so 33.3 % of the area vanishes" in done.stderr, printer == MONO2K)
            cured = json.loads(self.run_it("check", kept / "layers", "--printer", SIM2K, "--json").stdout)
            self.assertAlmostEqual(cured["volume_ml"], columns * 200 * 12 * 0.04725**2 * 0.05 / 1000, 4)
            hashes[printer] = [line["mask_hash"] for line in exposures(self.report)]
        self.assertNotEqual(hashes[SIM2K], hashes[MONO2K])

    def test_masks_across_the_panel_are_turned_and_not_mirrored(self):
        """An L on a panel of 2560 x 1440, as the printer's own and as PrusaSlicer's SL1 has it."""
        def ell(columns, rows, turn):
            lines = [bytearray(columns + 1) for _ in range(rows)]
            for x, y in ((x, y) for x in range(400) for y in range(200) if x < 100 or y < 60):
                column, row = turn(600 + x, 500 + y)
                lines[row][column + 1] = 255
            return png(columns, rows, b"".join(lines))

        upright = self.pack({"1.png": ell(1440, 2560, lambda x, y: (x, y))}, name="upright.zip")
        # The plate's x towards y: what lies at (x, y) of 2560 x 1440 comes to (1439 - y, x).
        across = self.pack({"1.png": ell(2560, 1440, lambda x, y: (y, 1439 - x))}, name="across.zip")
        ini = "display_orientation = portrait\ndisplay_mirror_x = 1\ndisplay_width = 120.96\ndisplay_height = 68.04\n"
        portrait = self.pack({"1.png": ell(1440, 2560, lambda x, y: (1439 - x, 2559 - y))}, ini, name="portrait.sl1")
        hashes = []
        for part in (upright, across, portrait):
            done = self.print_it(part)
            words = "printed turned by 90 degrees: the archive is sliced for a panel of 2560 x 1440 pixels"
            (self.assertNotIn if part is upright else self.assertIn)(words, done.stderr)
            hashes += [line["mask_hash"] for line in exposures(self.report)]
            inspected = json.loads(self.run_it("inspect", part, "--printer", SIM2K, "--json").stdout)
            self.assertEqual((inspected["fits"], inspected["turned"]), (True, part is not upright))
        self.assertEqual(hashes[1:], hashes[:1] * 2)

    def test_packed_folder_is_the_same_print(self):
        ini = "exposure_time = 2.25\ninitial_exposure_time = 6\nfaded_layers = 0\nlayer_height = 0.05\n"
        layers = {f"a{k}.png": square(100, island=20) for k in range(4)}
        plain = self.pack({"prusaslicer.ini": ini, **layers}, name="plain.sl1")
        masks = []
        for slash in "/\\":
            part = self.pack({f"job{slash}{name}": body for name, body in {"prusaslicer.ini": ini, **layers}.items()}, name="packed.sl1")
            for path in (plain, part):
                self.print_it(path)
                masks.append([(line["mask_hash"], line["asked_s"]) for line in exposures(self.report)])
        self.assertEqual(masks[1:], masks[:1] * 3)

    def test_doubtful_settings_are_refused(self):
        layer, ini = square(), "exposure_time = 2\n"
        for files, words in (
            ({"a/config.ini": ini, "b/config.ini": ini}, "has two files config.ini. Pack one print into one archive"),
            ({"config.ini": "# note\n" * 10_000_000}, "its settings have more than 64 MiB. Export it again"),
            ({"config.ini": "expTime = 2\ncalibrateRegions = 8\n"}, "is an exposure test of 8 exposures, which this version can't print"),
            ({"config.ini": "expTime = 2\nexpTime = 3\n"}, "config.ini: expTime is '3', but another line says 2. Export it again"),
        ):
            self.assertIn(f"part.sl1: {words}", self.print_it(self.pack({**files, "1.png": layer}, name="part.sl1"), status=1).stderr)

    def test_part_is_kept_and_compared(self):
        self.make_part()
        self.print_it(self.part, "--keep-part", self.out)
        self.assertTrue((self.out / "comparison.png").exists())
        self.assertIsNone(json.loads(self.report.read_text())["part"]["deviation_um"], "an archive has no surface")
        refused = self.print_it(self.part, "--truth", self.mesh, status=1)
        self.assertIn("an archive does not say where the mesh lies in its layers. Leave out --truth", refused.stderr)

    def test_layers_are_in_the_order_of_their_numbers(self):
        layers = {f"p{k}.png": square(100 + 20 * k) for k in (11, 9, 10, 8)}
        self.print_it(self.pack({"preview.png": b"x", "thumbnail/thumbnail400x400.png": b"y", "__MACOSX/._p1.png": b"z", **layers}))
        pixels = json.loads(self.run_it("check", self.dir / "part.zip", "--printer", SIM2K, "--json").stdout)
        self.assertEqual(pixels["grid"]["layers"], 4)
        alone = [self.run_it("check", self.pack({"1.png": body}, name=f"{k}.zip"), "--printer", SIM2K, "--json").stdout
                 for k, body in layers.items()]
        volumes = [json.loads(text)["volume_ml"] for text in alone]
        self.assertEqual(sorted(volumes), [volumes[3], volumes[1], volumes[2], volumes[0]])
        self.assertEqual(len({line["mask_hash"] for line in exposures(self.report)}), 4)

    def test_missing_layer_is_refused_by_its_number(self):
        layer = square()
        part = self.pack({f"part{i:05}.png": layer for i in (0, 1, 3, 4)})
        refused = self.print_it(part, status=1).stderr
        self.assertIn("part.zip: layer 2 is missing between 1 and 3. Copy or export it again", refused)
        self.assertIn("layer 2 is missing", self.run_it("check", part, "--printer", SIM2K, status=1).stderr)
        steps = self.pack({f"{i}.png": layer for i in (50, 100, 150)}, name="steps.zip")
        self.run_it("check", steps, "--printer", SIM2K)

    def test_missing_last_layers_are_refused_by_their_number(self):
        layers = {f"part{i:05}.png": square() for i in range(4)}
        whole = self.pack({"config.ini": "numFast = 3\nnumSlow = 1\n", **layers}, name="whole.sl1")
        self.run_it("check", whole, "--printer", SIM2K)
        cut = self.pack({"config.ini": "numFast = 5\nnumSlow = 1\n", **layers}, name="cut.sl1")
        for command in (["print", cut], ["check", cut]):
            refused = self.run_it(*command, "--printer", SIM2K, status=1).stderr
            self.assertIn("cut.sl1: declares 6 layers, has 4. Copy or export it again", refused)
        stale = self.pack({"config.ini": "numFast = 3\n", **layers}, name="stale.sl1")
        self.assertIn("stale.sl1: declares 3 layers, has 4. Copy or export it again", self.print_it(stale, status=1).stderr)

    def test_settings_may_begin_with_a_byte_order_mark(self):
        part = self.pack({"1.png": square()}, "\ufeffdisplay_width = 120\ndisplay_height = 215\n", "wide.sl1")
        self.assertIn("panel of 120.00 x 215.00 mm", self.print_it(part, status=1).stderr)

    def test_another_panel_is_refused_with_both_sizes(self):
        part = self.pack({"1.png": png(1620, 2560, bytes(1621) * 2560)})
        for command in (["print", part], ["check", part]):
            done = self.run_it(*command, "--printer", SIM2K, status=1)
            for size in ("1620 x 2560", "1440 x 2560"):
                self.assertIn(size, done.stderr)
        inspected = self.run_it("inspect", part, "--printer", SIM2K).stdout
        self.assertIn("is sliced for a panel of 1620 x 2560 pixels, this printer's has 1440 x 2560", inspected)
        part = self.pack({"1.png": square()}, "display_width = 120\ndisplay_height = 215\n", "wide.sl1")
        done = self.print_it(part, status=1)
        self.assertIn("panel of 120.00 x 215.00 mm, this printer's has 68.04 x 120.96 mm", done.stderr)

    def test_broken_layer_is_found_before_light(self):
        whole = square()
        for broken, words in (
            (whole[: len(whole) // 2], "part.zip: layer 2: cannot be read as PNG"),
            (whole[:60] + bytes([whole[60] ^ 1]) + whole[61:], "part.zip: layer 2: cannot be read as PNG"),
            (b"no picture", "part.zip: layer 2: cannot be read as PNG"),
            (png(1440, 100, bytes(1441) * 100), "layer 2: has 1440 x 100 pixels, the first layer 1440 x 2560"),
        ):
            done = self.print_it(self.pack({"1.png": whole, "2.png": broken, "3.png": whole}), "--state", self.state, status=1)
            self.assertIn(words, done.stderr)
            self.assertFalse(self.report.exists())
            self.assertFalse((self.state / "job").exists())

    def test_bomb_ends_at_the_plan(self):
        # 200 MB that pack into 200 kB, as a chunk that a reader skips.
        for kind, words in ((b"tEXt", "cannot be read as PNG (reached chunk/cache limits)"), (b"abCd", "is longer than a mask can be")):
            bomb = struct.pack(">I", 100_000_000) + kind + bytes(100_000_000) + b"\0\0\0\0"
            part = self.pack({"1.png": png(1440, 2560, bytes(1441) * 2560, extra=bomb)})
            self.assertLess(part.stat().st_size, 250_000)
            done = self.run_it("check", part, "--printer", SIM2K, status=1)
            self.assertIn(f"part.zip: layer 1: {words}", done.stderr)

    def test_store_that_was_changed_stops_the_print_in_the_dark(self):
        layers = {f"{k}.png": square(100 + 10 * k) for k in range(1, 13)}
        part = self.pack(layers)
        self.print_it(part, "--state", self.state, "--fault", "power.cut@layer=4", status=1)
        # The same archive, but for one layer.
        changed = self.pack({**layers, "9.png": layers["8.png"]}, name="changed.zip")
        (self.state / "archive").write_bytes(changed.read_bytes())
        self.run_it("print", "--resume", "--state", self.state, "--printer", SIM2K, "--report", self.report, status=1)
        report = json.loads(self.report.read_text())
        self.assertEqual(report["state"], "fault")
        self.assertIn("layer 9 is not as it was when the print was checked", json.dumps(report["fault"]))
        self.assertEqual(report["next_layer"], 8, "the layer below has cured whole")
        self.assertEqual([line["end"] for line in report["exposures"]], ["time up"] * len(report["exposures"]))
        self.assertEqual(report["objections"], [])

    def test_other_files_under_its_name_are_named_by_their_bytes(self):
        def packed(entry):
            path = self.pack({entry: b"<model/>"} if entry else {}, name="packed.zip")
            return path.read_bytes()

        whole = self.pack({"1.png": square()}).read_bytes()
        for bytes_, words in (
            (b"\x07\x01\xfd\x12" + bytes(500), "is sliced for another printer (Chitubox); export it as .sl1"),
            (b"ISO-10303-21;\nHEADER;", "is a CAD model (STEP); export it as STL or 3MF"),
            (square(), "is a picture (PNG); give a scan, a mesh or a print that is sliced"),
            (b"7z\xbc\xaf\x27\x1c" + bytes(500), "this is a 7z archive; unpack it"),
            (self.mesh.read_bytes(), "is a scan or mesh, no sliced print. Give it the ending .stl"),
            (b"1 2 3\n4 5 6\n", "is a scan or mesh, no sliced print. Give it the ending .xyz"),
            (packed("3D/3dmodel.model"), "is a mesh, no sliced print. Give it the ending .3mf"),
            (packed(""), "this is an empty zip archive; copy or export the file again"),
            (bytes(500), "is not a zip archive, or is damaged; copy or export it again"),
            (whole[: len(whole) - 20], "is not a zip archive, or is damaged. Copy or export it again"),
            (b"", "the file is empty (0 bytes)"),
        ):
            self.part.write_bytes(bytes_)
            for command in (["print", self.part], ["check", self.part], ["inspect", self.part]):
                self.assertIn(f"part.sl1: {words}", self.run_it(*command, "--printer", SIM2K, status=1).stderr)

    def test_options_that_change_a_scan_are_refused(self):
        self.make_part()
        for options in (("--scale", 2), ("--supports", "auto"), ("--rotate-x", 90), ("--fit",)):
            done = self.print_it(self.part, *options, status=1)
            self.assertIn("part.sl1: is sliced already, so it is printed as it is", done.stderr)

    def test_what_is_sliced_is_not_sliced_again(self):
        self.make_part()
        done = self.run_it("slice", self.part, "-o", self.out, status=1)
        self.assertIn("part.sl1: this is a print that is sliced already; print it, or check it", done.stderr)

    def test_checks_find_the_same_as_in_a_folder(self):
        self.make_part()
        self.layer_hashes()
        ours = json.loads(self.run_it("check", self.part, "--json").stdout)
        folder = json.loads(self.run_it("check", self.out, "--json").stdout)
        self.assertEqual(ours.pop("grey")["grey_pixels"], 0)
        self.assertEqual({**ours, "name": 0}, {**folder, "name": 0})
        inspected = json.loads(self.run_it("inspect", self.part, "--json", "--printer", SIM2K).stdout)
        self.assertEqual((inspected["archive"]["layers"], inspected["archive"]["exposure_time"], inspected["fits"]), (20, 2.5, True))
        self.assertIn("20 layers of 0.1 mm, 2.00 mm high", self.run_it("inspect", self.part).stdout)

    @unittest.skipUnless(shutil.which("prusa-slicer"), "needs prusa-slicer")
    def test_prusaslicers_archives_lie_as_its_model_does(self):
        """Whatever PrusaSlicer mirrors and turns for its printer's panel: the L is at its place, and no mirror image."""
        folder = self.run_it("slice", self.mesh, "-o", self.out, "--no-preview", *self.same)
        ours = json.loads(self.run_it("check", self.out, "--json").stdout)["volume_ml"]
        for orientation, mirrors in (("portrait", (1, 0)), ("landscape", (0, 1)), ("landscape", (1, 1)), ("portrait", (0, 0))):
            ini, part = self.dir / "sla.ini", self.dir / "theirs.sl1"
            part.unlink(missing_ok=True)
            ini.write_text(
                "printer_technology = SLA\nlayer_height = 0.1\ninitial_layer_height = 0.1\ndisplay_pixels_x = 1440\n"
                "display_pixels_y = 2560\ndisplay_width = 68.04\ndisplay_height = 120.96\n"
                "bed_shape = 0x0,68.04x0,68.04x120.96,0x120.96\nsupports_enable = 0\npad_enable = 0\n"
                f"display_mirror_x = {mirrors[0]}\ndisplay_mirror_y = {mirrors[1]}\ndisplay_orientation = {orientation}\n"
            )
            subprocess.run(["prusa-slicer", "--loglevel", "1", "--export-sla", "--load", ini, "--center", "34.02,60.48", self.mesh,
                            "-o", part], check=True, capture_output=True)
            self.print_it(part, "--keep-part", self.dir / f"kept-{orientation}-{mirrors[0]}")
            kept = self.dir / f"kept-{orientation}-{mirrors[0]}" / "layers"
            self.assertAlmostEqual(self.shared_with(kept), 1, delta=0.01)

    def shared_with(self, kept):
        """Intersection over union of the middle layer with ours."""
        from case import png_rows
        ours, theirs = (png_rows((folder / "00010.png").read_bytes())[1] for folder in (self.out / "layers", kept))
        both = either = 0
        for a, b in zip(ours, theirs):
            a, b = int.from_bytes(a, "big"), int.from_bytes(b, "big")
            both += (a & b).bit_count()
            either += (a | b).bit_count()
        return both / either


class FromAStick(Sliced):
    """The daemon: the child without rights decodes every layer."""

    def start(self, *arguments):
        confirm_plate(self.state)
        stick = self.dir / "stick"
        return self.start_daemon("--printer", on_stick_printer(self.dir), "--state", self.state, "--stick", stick, *arguments)

    def put_stick(self, *files, job=""):
        folder = self.dir / "new"
        folder.mkdir()
        for file in files:
            shutil.copy(file, folder)
        if job:
            (folder / "job.toml").write_text(job)
        folder.rename(self.dir / "stick")

    def test_prints_from_its_store_and_survives_being_killed(self):
        self.make_part()
        hashes = self.layer_hashes()
        self.put_stick(self.part)
        daemon = self.start("--speedup", 60)
        self.until(daemon, "the stick may be pulled")
        shutil.rmtree(self.dir / "stick")
        self.until(daemon, "layer 3 of 20")
        os.kill(daemon.pid, signal.SIGKILL)
        daemon.wait()
        self.assertEqual((self.state / "archive").read_bytes(), self.part.read_bytes())
        daemon = self.start("--speedup", 1e6, "--jobs", 1)
        self.until(daemon, "an interrupted print can go on")
        self.run_it("ctl", "resume", "--socket", self.state / "state")
        self.until(daemon, "finished")
        self.assertEqual(daemon.wait(60), 0)
        report = json.loads((self.state / "report.json").read_text())
        self.assertEqual((report["state"], report["scan"]), ("finished", "part.sl1"))
        self.assertEqual([line["mask_hash"] for line in report["exposures"]][-15:], hashes[-15:])

    def test_grey_comes_through_the_child_as_this_process_decodes_it(self):
        """Rings of grey round a square, mirrored by the archive."""
        empty, row, edge = bytes(1441), bytearray(1441), bytearray(1441)
        for i, level in enumerate((40, 90, 127, 128, 200, 254)):
            row[601 + i] = row[800 - i] = level
        row[607:795] = b"\xff" * 188
        edge[601:801] = b"\x64" * 200
        layer = png(1440, 2560, empty * 999 + bytes(edge) + bytes(row) * 200 + bytes(edge) + empty * 1359)
        ini = "layer_height = 0.05\nexposure_time = 2.5\ninitial_exposure_time = 30\nfaded_layers = 3\ndisplay_mirror_x = 1\n"
        part = self.pack({f"{k:02}.png": layer for k in range(8)}, ini, name="part.sl1")
        self.print_it(part)
        hashes = [line["mask_hash"] for line in exposures(self.report)]
        self.put_stick(part)
        daemon = self.start("--speedup", 1e6, "--jobs", 1)
        self.until(daemon, "finished")
        self.assertEqual(daemon.wait(60), 0)
        report = json.loads((self.state / "report.json").read_text())
        self.assertEqual((report["state"], report["objections"]), ("finished", []))
        self.assertEqual((report["contract"]["shows_grey"], report["contract"]["grey_percent"] > 0), (True, True))
        self.assertEqual([line["mask_hash"] for line in report["exposures"]], hashes)

    def test_pulled_or_broken_while_it_is_copied(self):
        self.put_stick(self.pack({"1.png": square(), "notes": os.urandom(3_000_000)}, name="part.sl1"))
        for words, *faults in (("PL-107, stick pulled: part.sl1: the stick was pulled", "stick.slow@t=0s,by=0.01", "stick.pulled@t=0.5s,for=99s"),
                               ("PL-101, scan can't be read: part.sl1: the stick has bad sectors", "stick.bad_sector@t=0s")):
            daemon = self.start(*(word for fault in faults for word in ("--fault", fault)))
            self.assertNotIn("may be pulled", self.until(daemon, words))
            daemon.kill()
            daemon.wait()
            for name in ("archive", "archive.new", "job"):
                self.assertFalse((self.state / name).exists(), name)

    def pictures_of(self, part):
        """Prints it. @returns the state's numbers of pictures while it prints"""
        self.put_stick(part)
        daemon = self.start("--speedup", 60)
        self.until(daemon, "layer 1 of")
        state = json.loads(self.run_it("status", "--json", "--socket", self.state / "state").stdout)
        picture = self.dir / "issues.png"
        if state["pictures"]["issues"]:
            self.run_it("status", "--socket", self.state / "state", "--picture", "issues", "-o", picture)
        daemon.kill()
        daemon.wait()
        shutil.rmtree(self.dir / "stick")
        shutil.rmtree(self.state)
        return state["pictures"]

    def test_shows_where_the_masks_have_issues(self):
        # A square, and beside it on the second layer and above one that nothing holds.
        first, above = square(), square(island=60)
        ini = "layer_height = 0.05\nexposure_time = 2.5\ninitial_exposure_time = 30\n"  # else it is asked about
        self.assertIsNone(self.pictures_of(self.pack({f"{i}.png": first for i in range(1, 5)}, ini))["issues"])
        self.assertGreater(self.pictures_of(self.pack({f"{i}.png": first if i == 1 else above for i in range(1, 5)}, ini))["issues"], 0)
        columns, rows, pixels = rgb_of(self.dir / "issues.png")
        self.assertEqual((columns, rows), (320, 180))
        red = sum(red > 200 and green < 120 for red, green, _ in pixels)
        # The issue is drawn as large as the tile allows, with what is round it.
        self.assertGreater(red, 1000)
        self.assertLess(red, 320 * 180 // 2)

    def test_says_why_it_does_not_print(self):
        self.make_part()
        self.put_stick(self.part, job='[job]\nscan = "part.sl1"\n[placement]\nscale = 2.0\n')
        daemon = self.start("--speedup", 1e6)
        self.until(daemon, "part.sl1: is sliced already, so of the job's settings only the profile, exposures, lifts and waits count")
        daemon.kill()
        daemon.wait()
        shutil.rmtree(self.dir / "stick")
        broken = self.pack({"1.png": square(), "2.png": square()[:2000]})
        self.put_stick(broken)
        daemon = self.start("--speedup", 1e6)
        self.until(daemon, "part.zip: layer 2: cannot be read as PNG")
        self.assertFalse((self.state / "archive.new").exists(), "a refused archive takes no room")

    def test_names_what_lies_under_its_name(self):
        self.part.write_bytes(b"\x07\x01\xfd\x12" + bytes(500))
        self.put_stick(self.part)
        daemon = self.start("--speedup", 1e6)
        self.until(daemon, "part.sl1: is sliced for another printer (Chitubox). Export it as .sl1")

    def test_names_what_other_printers_print(self):
        for name in ("part.ctb", "part.pdf", "photo.png", "thumb.jpg"):
            (self.dir / name).write_bytes(b"\x12\xfd\x19\x86" + bytes(500))
        self.put_stick(*(self.dir / name for name in ("part.ctb", "part.pdf", "photo.png", "thumb.jpg")))
        daemon = self.start("--speedup", 1e6)
        said = self.until(daemon, "part.ctb is sliced for another printer (Chitubox). Export it as .sl1")
        self.assertNotIn("pdf", said)
        daemon.kill()
        daemon.wait()
        shutil.rmtree(self.dir / "stick")
        (self.dir / "part.sldprt").write_bytes(bytes(500))
        self.put_stick(self.dir / "part.sldprt")
        daemon = self.start("--speedup", 1e6)
        self.until(daemon, "part.sldprt is a CAD model (SolidWorks). Export it as STL or 3MF")
        daemon.kill()
        daemon.wait()
        shutil.rmtree(self.dir / "stick")
        self.put_stick(self.dir / "part.ctb", self.mesh)
        daemon = self.start("--speedup", 1e6)
        said = self.until(daemon, "reading ell.stl")
        self.assertIn("part.ctb is sliced for another printer (Chitubox); export it as .sl1", said)
        for name, words in (
            ("part.ctb", "part.ctb: is sliced for another printer (Chitubox); export it as .sl1"),
            ("part.pwmx", "part.pwmx: is sliced for another printer (Photon Workshop); export it as .sl1"),
            ("part.dwg", "part.dwg: is a CAD model (DWG); export it as STL or 3MF"),
            ("part.lys", "part.lys: is a project (Lychee Slicer); export its mesh as STL"),
            ("part.gcode", "part.gcode: is sliced for a filament printer (G-code); export its mesh as STL"),
        ):
            (self.dir / name).write_bytes(b"PK\x03\x04" + bytes(500))
            self.assertIn(words, self.print_it(self.dir / name, status=1).stderr)


if __name__ == "__main__":
    main()
