#!/usr/bin/env python3
"""plumbline check, and the checks of plumbline slice: what is found in the masks, and what happens then."""

import json
import math
import shutil
import struct
import subprocess
import unittest
import zipfile
import zlib

from case import Program, box, main, write_lying_cone

COLUMNS, ROWS, LAYERS, PITCH = 70, 50, 24, 0.1


def is_solid(c, r, k):
    """A block with a closed bubble and a well that opens upwards, and beside it a ball that hangs from a beam."""
    ball = math.dist((c, r, k), (55, 25, 14)) < 7
    beam = 30 <= c < 60 and 23 <= r < 28 and k >= 19
    bubble = math.dist((c, r, k), (20, 15, 12)) < 4.5
    well = 12 <= c < 28 and 30 <= r < 42 and k >= 9
    return (5 <= c < 40 and 5 <= r < 45 and not bubble and not well) or ball or beam


def write_peers_layers(folder):
    """As PrusaSlicer exports them: 8 bits, edges in grey, all files in one folder."""

    def grey(c, r, k):
        share = sum(is_solid(c + dc, r + dr, k) for dc in (-0.4, 0, 0.4) for dr in (-0.4, 0, 0.4)) / 9
        return round(255 * share)

    folder.mkdir()
    for k in range(LAYERS):
        lines = b"".join(b"\0" + bytes(grey(c, r, k) for c in range(COLUMNS)) for r in range(ROWS))
        chunks = ((b"IHDR", struct.pack(">IIBBBBB", COLUMNS, ROWS, 8, 0, 0, 0, 0)), (b"IDAT", zlib.compress(lines)), (b"IEND", b""))
        body = b"".join(struct.pack(">I", len(d)) + n + d + struct.pack(">I", zlib.crc32(n + d)) for n, d in chunks)
        (folder / f"peer{k:05}.png").write_bytes(b"\x89PNG\r\n\x1a\n" + body)
    return {(c, r, k) for k in range(LAYERS) for r in range(ROWS) for c in range(COLUMNS) if grey(c, r, k) > 127}


def flooded(seeds, may_pass, top=LAYERS):
    """Voxels that are reached from the seeds, face to face, below a layer."""
    seen = {s for s in seeds if may_pass(s)}
    todo = list(seen)
    while todo:
        c, r, k = todo.pop()
        for n in ((c + 1, r, k), (c - 1, r, k), (c, r + 1, k), (c, r - 1, k), (c, r, k + 1), (c, r, k - 1)):
            inside = 0 <= n[0] < COLUMNS and 0 <= n[1] < ROWS and 0 <= n[2] < top
            if inside and n not in seen and may_pass(n):
                seen.add(n)
                todo.append(n)
    return seen


class Check(Program):
    def test_check_finds_in_a_peers_layers_what_floods_of_the_volume_find(self):
        solid = write_peers_layers(self.dir / "peer")
        told = json.loads(self.run_it("check", self.dir / "peer", "--pixel-pitch", PITCH, "--layer-height", PITCH, "--json").stdout)
        kinds = told["issues"]["kinds"]

        def voxels(found):
            return round(found["volume_ml"] * 1000 / PITCH**3, 1)

        self.assertEqual(voxels(told), len(solid))

        everywhere = [(c, r, k) for c in range(COLUMNS) for r in range(ROWS) for k in range(LAYERS)]
        sides = [v for v in everywhere if v[0] in (0, COLUMNS - 1) or v[1] in (0, ROWS - 1)]
        open_air = flooded(sides + [v for v in everywhere if v[2] == LAYERS - 1], lambda v: v not in solid)
        trapped = [v for v in everywhere if v not in solid and v not in open_air]
        self.assertEqual([kinds["resin_trap"]["count"], kinds["suction_cup"]["count"]], [1, 1])
        self.assertEqual(voxels(kinds["resin_trap"]["largest"][0]), len(trapped))

        sucked = sum(
            len([v for v in everywhere if v[2] == k and v not in solid and v not in reached])
            for k in range(LAYERS)
            for reached in [flooded(sides, lambda v: v not in solid, k + 1)]
        )
        self.assertEqual(voxels(kinds["suction_cup"]["largest"][0]), sucked - len(trapped))

        ball = flooded([(55, 25, 14)], lambda v: v in solid, 19)  # below the beam
        self.assertEqual([kinds[kind]["count"] for kind in ("island", "free_piece")], [1, 1])
        piece = kinds["free_piece"]["largest"][0]
        self.assertEqual(voxels(piece), len(ball))
        self.assertEqual(kinds["island"]["largest"][0]["layer"], min(k for _, _, k in ball))
        self.assertEqual((piece["first_layer"], piece["last_layer"]), (min(k for *_, k in ball), 18))

    def test_check_finds_in_the_written_layers_what_slice_has_found(self):
        self.slice_it("--supports", "none")
        issues = self.manifest()["issues"]
        self.assertEqual(list(issues["kinds"]), ["overhang", "tear", "first_layer_area"])  # a ball on 3 mm2
        self.assertTrue((self.out / "issues.png").read_bytes().startswith(b"\x89PNG"))
        picture = self.dir / "found.png"
        told = json.loads(self.run_it("check", self.out, "--json", "--picture", picture).stdout)
        # Overhangs of layers alone are UVtools', which sees none here.
        self.assertEqual(told["issues"], {**issues, "kinds": {kind: found for kind, found in issues["kinds"].items() if kind != "overhang"}})
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

    @unittest.skipUnless(shutil.which("prusa-slicer"), "needs the package prusa-slicer")
    def test_check_finds_in_a_stack_of_prusa_slicer_what_is_in_the_mesh(self):
        # A block of 3 x 4 x 2.4 mm with a bubble of 1.2 x 1.6 x 1 mm, and a peg of 1 x 1 x 1.2 mm below a beam beside it.
        solid = box((0, 0, 0), (3, 4, 2.4)) + box((0.8, 1, 0.6), (2, 2.6, 1.6), hollow=True)
        peg = box((4, 1, 0.8), (5, 2, 2)) + box((2.8, 1, 2), (5, 2, 2.4))
        mesh, archive, folder = self.dir / "mesh.stl", self.dir / "mesh.sl1", self.dir / "peer"
        mesh.write_text(f"solid mesh\n{solid}{peg}endsolid mesh\n")
        panel = ("--display-width", 7, "--display-height", 5, "--display-pixels-x", COLUMNS, "--display-pixels-y", ROWS)
        command = ("prusa-slicer", "--export-sla", mesh, "--output", archive, "--printer-technology", "SLA", "--layer-height", PITCH,
                   "--initial-layer-height", PITCH, "--display-orientation", "landscape", *panel, "--bed-shape", "0x0,7x0,7x5,0x5",
                   "--center", "3.5,2.5", "--supports-enable=0", "--pad-enable=0", "--absolute-correction", 0,
                   "--elefant-foot-compensation", 0)  # fmt: skip
        subprocess.run(list(map(str, command)), check=True, capture_output=True)
        with zipfile.ZipFile(archive) as layers:
            layers.extractall(folder, [name for name in layers.namelist() if name.endswith(".png") and "/" not in name])
        told = json.loads(self.run_it("check", folder, "--pixel-pitch", PITCH, "--layer-height", PITCH, "--json").stdout)
        kinds = told["issues"]["kinds"]
        self.assertEqual([kinds[kind]["count"] for kind in ("resin_trap", "island", "free_piece")], [1, 1, 1])
        self.assertNotIn("suction_cup", kinds)
        self.assertAlmostEqual(kinds["resin_trap"]["largest"][0]["volume_ml"] * 1000, 1.2 * 1.6 * 1, delta=0.2)
        piece = kinds["free_piece"]["largest"][0]
        self.assertAlmostEqual(piece["volume_ml"] * 1000, 1.2, delta=0.2)
        self.assertEqual((piece["first_layer"], piece["last_layer"]), (8, 19))


if __name__ == "__main__":
    main()
