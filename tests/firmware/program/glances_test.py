#!/usr/bin/env python3
"""The small pictures of the scans and archives that are offered, and files that mean harm while theirs is drawn."""

import base64
import os
import shutil
import struct
import time
import unittest
import zipfile
import zlib

from case import SIM2K, main, write_sphere
from rgb_picture import rgb_rows
from sliced_test import png
from state_client import Client, StatePrinter

RED, GREEN, BLUE = b"\xff\x00\x00", b"\x00\xff\x00", b"\x00\x00\xff"
LAYER = png(1440, 2560, bytes(1441 * 2560))


def chunk(kind, body, crc=None):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body) if crc is None else crc)


def rgb_png(columns, rows, left, right=None):
    """A picture in one colour, or in two halves."""
    half = columns // 2
    return png(columns, rows, (b"\0" + left * half + (right or left) * (columns - half)) * rows, colour=2)


def archive_of(path, entries):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, body in entries.items():
            archive.writestr(name, body)
    return path.read_bytes()


class Glances(StatePrinter):
    def archive(self, thumbnails, layer=LAYER):
        return archive_of(self.dir / "made.zip", {"part00001.png": layer, **thumbnails})

    def seen(self, user, *names, number=0):
        """Waits until each of these has a picture of this stick. @returns the list, name -> picture"""
        def all_there(state):
            scans = {scan["name"]: scan["picture"] for scan in state["stick"]["scans"]}
            return all((scans.get(name) or 0) > number for name in names)
        state = user.until(all_there, f"pictures of {names}")
        return {scan["name"]: scan["picture"] for scan in state["stick"]["scans"]}

    def pixels(self, user, name):
        """Rows of 64 pixels, each (red, green, blue)."""
        number = [scan["name"] for scan in user.states[-1]["stick"]["scans"]].index(name) + 1
        reply = user.ask("picture", picture="scan", scan=number)
        self.assertTrue(reply["ok"], reply)
        file = self.dir / "glance.png"
        file.write_bytes(base64.b64decode(reply["png"], validate=True))
        columns, rows = rgb_rows(file)
        self.assertEqual((columns, len(rows)), (64, 64))
        return [[tuple(row[at : at + 3]) for at in range(0, len(row), 3)] for row in rows]

    def test_an_archive_shows_the_smallest_of_its_thumbnails_that_serves(self):
        _, user = self.start()
        see_through = png(400, 400, (b"\0" + bytes(4 * 200) + b"\xff\x00\x00\xff" * 200) * 400, colour=6)
        self.put_stick({
            "a.sl1": self.archive({"thumbnail/thumbnail800x480.png": rgb_png(800, 480, BLUE), "thumbnail/thumbnail400x400.png": rgb_png(400, 400, RED, GREEN),
                                   "thumbnail/tiny.png": rgb_png(32, 32, BLUE)}),
            "b.zip": self.archive({"preview.png": rgb_png(800, 400, GREEN)}),
            "c.sl1": self.archive({"thumbnail/small.png": rgb_png(32, 16, RED)}),
            "d.sl1": self.archive({"Thumbnail/see-through.PNG": see_through}),
            "e.sl1": self.archive({"thumbnail/grey.png": png(100, 100, (b"\0" + b"\x80" * 100) * 100)}),
        })
        self.seen(user, "a.sl1", "b.zip", "c.sl1", "d.sl1", "e.sl1")
        # Colours are those of a 16-bit screen: five bits.
        red, green, grey = (255, 0, 0), (0, 255, 0), (132, 132, 132)
        wide = self.pixels(user, "a.sl1")
        self.assertEqual(([set(row[:32]) for row in wide], [set(row[32:]) for row in wide]), ([{red}] * 64, [{green}] * 64))
        band = self.pixels(user, "b.zip")
        self.assertEqual([set(row) == {green} for row in band], [16 <= y < 48 for y in range(64)], "twice as wide as high")
        small = self.pixels(user, "c.sl1")
        self.assertEqual(sum(row.count(red) for row in small), 32 * 16, "it is not enlarged")
        self.assertEqual([row[16:48].count(red) for row in small[24:40]], [32] * 16, "but in the middle")
        half = self.pixels(user, "d.sl1")
        self.assertTrue(all(row[40] == red and row[20] != red for row in half))
        self.assertEqual({pixel for row in self.pixels(user, "e.sl1") for pixel in row}, {grey})

    def test_an_archive_without_thumbnails_shows_its_layers_from_the_front(self):
        # A tee: a post of 2 mm with a bar of 12 mm on top, 10 mm high.
        def layer(width):
            row = bytearray(1441)
            row[721 - width // 2 : 721 + width // 2] = b"\xff" * width
            return png(1440, 2560, bytes(1441) * 1200 + bytes(row) * 160 + bytes(1441) * 1200)
        post, bar = layer(42), layer(254)
        layers = {f"{k}.png": bar if k > 150 else post for k in range(1, 201)}
        scan, part = self.dir / "ball.ply", self.dir / "part.sl1"
        write_sphere(scan, points=5000, radius=2)
        self.run_it("slice", scan, "-o", part, "--printer", SIM2K, "--layer-height", 0.1, "--no-preview")
        empty = {f"{k}.png": LAYER for k in range(1, 4)}
        _, user = self.start()
        self.put_stick({"ball.sl1": part.read_bytes(), "empty.zip": archive_of(self.dir / "empty.zip", empty),
                        "tee.zip": archive_of(self.dir / "tee.zip", layers)})
        pictures = self.seen(user, "ball.sl1", "tee.zip")
        self.assertIsNone(pictures["empty.zip"], "there is nothing to see")
        rows = self.pixels(user, "tee.zip")
        width = [sum(sum(pixel) > 450 for pixel in row) for row in rows]  # the ground is darker
        tall = [y for y in range(64) if width[y] > 0]
        bar = [y for y in tall if width[y] > 30]
        self.assertGreater(len(tall), 35)
        self.assertLess(max(bar), tall[len(tall) // 2], "the bar is at the top")
        self.assertAlmostEqual(len(bar) / len(tall), 0.25, delta=0.1)
        self.assertAlmostEqual(max(width) / len(tall), 12 / 10, delta=0.2)
        below = [width[y] for y in tall if y > max(bar) + 2][:-3]
        self.assertAlmostEqual(sum(below) / len(below) / max(width), 2 / 12, delta=0.05)

    def test_a_chosen_archive_leaves_the_settings_of_the_scans(self):
        # Regression: a setting of the scan that was chosen before made the archive's print fail.
        _, user = self.start()
        self.put_stick({"a.ply": 2, "b.sl1": self.archive({})})
        user.state("offered", "set")
        user.do("set", key="scale", value=1.5)
        user.do("choose", scan=2)
        of_archive = user.until(lambda s: s["job"] and s["job"]["number"] == 2, "the archive")
        self.assertEqual(of_archive["job"]["scale"], 1)
        user.refused("is sliced already, so only its profile, exposures, lifts and waits can be set", "set", key="scale", value=2)
        user.do("choose", scan=1)
        user.until(lambda s: s["job"]["number"] == 1 and s["job"]["scale"] == 1.5, "the scan and its size")

    def hostile(self):
        """name -> bytes of files whose picture can't be drawn, or only by luck"""
        good = rgb_png(400, 400, RED)
        wrong_crc = good[:-16] + bytes([good[-16] ^ 1]) + good[-15:]
        header = struct.pack(">IIBBBBB", 400, 400, 8, 2, 0, 0, 0)
        short = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")
        vast = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 16000, 16000, 16, 6, 0, 0, 0)) + chunk(b"IDAT", b"")
        huge_chunk = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + struct.pack(">I", 0x7FFFFFFF) + b"IDAT" + bytes(100)
        palette = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 100, 100, 8, 3, 0, 0, 0)) + chunk(b"IDAT", zlib.compress((b"\0" + b"\xfe" * 100) * 100)) + chunk(b"IEND", b"")
        whole = self.archive({"thumbnail/t.png": good})
        directory = whole.rindex(b"PK\x05\x06")
        other_place = whole[: directory + 16] + struct.pack("<I", 0xFFFFFFF0) + whole[directory + 20 :]
        many = whole[: directory + 8] + struct.pack("<HH", 0xFFFF, 0xFFFF) + whole[directory + 12 :]
        flipped = bytearray(whole)
        flipped[whole.index(b"thumbnail/t.png") + 40] ^= 0xFF  # in the packed bytes
        return {
            "cut.sl1": whole[: len(whole) // 2], "no.zip": b"PK\x03\x04" + bytes(500), "place.sl1": other_place, "many.sl1": many,
            "packed.sl1": bytes(flipped), "crc.sl1": self.archive({"thumbnail/t.png": wrong_crc}), "short.sl1": self.archive({"thumbnail/t.png": short}),
            "vast.sl1": self.archive({"thumbnail/t.png": vast}), "chunk.sl1": self.archive({"thumbnail/t.png": huge_chunk}),
            "palette.sl1": self.archive({"thumbnail/t.png": palette}), "text.sl1": self.archive({"thumbnail/t.png": b"GIF89a" + bytes(300)}),
            "bomb.zip": archive_of(self.dir / "bomb.zip", {"1.png": png(16384, 16384, b"", depth=1), "2.png": LAYER}),
            "layers.zip": archive_of(self.dir / "layers.zip", {"1.png": LAYER, "2.png": png(16, 16, bytes(17 * 16))}),
            "cut.ply": b"ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n",
            "vast.ply": b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n" + bytes(500),
            "nan.xyz": b"nan nan nan\n" * 100, "same.xyz": b"1 1 1\n" * 100, "far.xyz": b"1e38 -1e38 1e38\n-1e38 1e38 0\n" * 50, "cut.stl": bytes(80) + struct.pack("<I", 1 << 31) + bytes(100),
            "bomb.3mf": archive_of(self.dir / "bomb.3mf", {"3D/3dmodel.model": b"<model>" + b" " * 30_000_000}),
        }

    def memory(self, daemon):
        """Sizes of the process, kB."""
        with open(f"/proc/{daemon.pid}/status", encoding="ascii") as file:
            return {line.split(":")[0]: int(line.split()[1]) for line in file if line.startswith(("VmData", "VmStk", "VmLck", "VmRSS"))}

    @unittest.skipIf("PLUMBLINE_SANITIZED" in os.environ, "a sanitizer's memory is not the program's")
    def test_hostile_files_have_no_picture_and_harm_neither_list_nor_memory(self):
        daemon, user = self.start()
        user.state("idle")
        hostile = self.hostile()
        last, between = "zz.ply", "m.sl1"
        files = {**hostile, last: 2, between: self.archive({"thumbnail/t.png": rgb_png(400, 400, GREEN)})}
        grown, number = [], 0
        for _ in range(4):
            self.put_stick(files)
            pictures = self.seen(user, last, between, number=number)
            number = max(picture or 0 for picture in pictures.values())
            self.assertEqual(set(pictures), set(files), "the list is whole")
            for name in hostile:
                # Points that all lie in one place, or far apart, may be drawn as what they are.
                if name not in ("same.xyz", "far.xyz", "nan.xyz"):
                    self.assertIsNone(pictures[name], name)
            self.assertEqual(self.pixels(user, between)[0][0], (0, 255, 0))
            self.assertIsNone(daemon.poll())
            self.assertEqual([scan["problem"] for scan in user.states[-1]["stick"]["scans"]], [None] * len(files), "nobody has printed one")
            shutil.rmtree(self.stick)
            user.until(lambda s: not s["stick"]["present"] and s["state"] == "idle", "no stick")
            grown.append(self.memory(daemon))
        self.assertEqual(grown[0], {**grown[0], **{key: grown[3][key] for key in ("VmData", "VmStk", "VmLck")}}, "no heap is left")
        self.assertLess(grown[3]["VmRSS"] - grown[0]["VmRSS"], 300)
        self.assertLess(len(os.listdir(f"/proc/{daemon.pid}/fd")), 50)
        Client(self, self.path).state("idle")

    def test_who_chooses_or_prints_does_not_wait_for_a_picture(self):
        _, user = self.start()
        self.put_stick({"a.ply": 2, "b.ply": 2, "c.ply": 2, "d.sl1": self.archive({})}, points=400_000)
        user.state("offered", "choose")
        began = time.monotonic()
        user.do("choose", scan=3)
        chosen = user.until(lambda s: s["job"] and s["job"]["number"] == 3, "the third scan")
        self.assertIsNone(chosen["stick"]["scans"][2]["picture"], "none of the third one yet")
        user.do("set", key="layer_height", value=0.1)
        user.do("set", key="supports", value="none")
        user.do("start")
        user.state("slicing")
        self.assertLess(time.monotonic() - began, 20)
        user.do("cancel")
        # They go on when it is offered again, and those that were there stay.
        user.do("offer") if user.state("idle", "offer") else None
        self.seen(user, "a.ply", "b.ply", "c.ply")
        user.do("choose", scan=2)
        user.do("set", key="layer_height", value=0.1)
        user.do("set", key="supports", value="none")
        user.do("start")
        self.assertEqual(user.state("plate in use", "plate-empty")["job"]["result"], "finished")


if __name__ == "__main__":
    main()
